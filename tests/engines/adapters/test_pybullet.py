"""PyBullet: declared orders, the right equations, exact step counts, determinism, silence."""

import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
import pybullet as p
import pytest
from scenes import SCENES, scene
from scipy.spatial.transform import Rotation
from spincheck.engines import EngineError, Method, Run, State
from spincheck.engines.adapters.pybullet import worlds
from spincheck.engines.adapters.pybullet.engine import PyBullet
from spincheck.engines.adapters.pybullet.session import PyBulletSession
from spincheck.scenarios import Scenario

ENGINE = PyBullet()
METHODS = [method for method in ENGINE.methods if not method.as_shipped]
CASES = [
    pytest.param(scenario, method, id=f"{method.name}-{name}")
    for method in METHODS
    for name, scenario in SCENES.items()
    if not ENGINE.unsupported(scenario, method)
]
TIMESTEP = 1e-3
STEPS = np.arange(0, 101, 20)
SPAN = 0.25
#: Steps over SPAN at which a first-order method is in its asymptotic range in every scene.
COARSEST = 1024
#: How far a measured order may be from the declared one, as for the verdict of a ladder.
ORDER_SLACK = 0.25
#: s: short enough that one step is a derivative, long enough that its rounding stays below that.
INSTANT = 2.0**-20
#: Steps until a constraint has taken up its load: it lags by one, and makes good a fifth of its
#: drift a step; four fifths to this power are nothing.
SETTLING = 160
#: No power of two, and a timestep that is none either.
ODD_STEPS, ODD_TIMESTEP = 115, 1e-4


def run(scenario: Scenario, method: Method, timestep: float = TIMESTEP) -> Run:
    return ENGINE.run(scenario, method, timestep, STEPS)


def columns(run: Run) -> np.ndarray:
    """Everything a trajectory holds, side by side."""
    assert run.trajectory is not None, run.reason
    motion = run.trajectory
    return np.hstack(
        [motion.q_world_body_wxyz, motion.omega_body, motion.com_world, motion.velocity_world]
    )


def state(session: PyBulletSession) -> np.ndarray:
    return np.concatenate(list(vars(session.read_state()).values()))


def opened(scenario: Scenario, method: Method, timestep: float) -> PyBulletSession:
    session = ENGINE.open(scenario, method, timestep)
    assert isinstance(session, PyBulletSession)
    return session


@pytest.mark.parametrize(("scenario", "method"), CASES)
def test_every_scene_reads_back_runs_and_passes_its_audit(
    scenario: Scenario, method: Method
) -> None:
    result = run(scenario, method)
    assert (result.outcome, result.reason) == ("ok", "")
    assert result.active == scenario.called_for


def omega_rate(scenario: Scenario, state: State, gravity_sign: int = 1) -> np.ndarray:
    """dω/dt of a state, body axes: Euler's equations about the pivot, else about the com."""
    body, omega = scenario.body, state.omega_body
    R = Rotation.from_quat(state.q_world_body_wxyz, scalar_first=True).as_matrix()
    torque = scenario.torque_body + R.T @ scenario.torque_world - scenario.drag * omega
    inertia = body.inertia_com
    if scenario.has_pivot:
        inertia = body.inertia_origin
        weight = body.mass * gravity_sign * R.T @ scenario.gravity_world
        torque = torque + np.cross(body.com, weight)
    return np.linalg.solve(inertia, torque - np.cross(omega, inertia @ omega))


def settled_step(scenario: Scenario, method: Method) -> tuple[State, np.ndarray]:
    """A state a little after the start, and dω/dt as the step from there has it."""
    with opened(scenario, method, INSTANT) as session:
        session.advance(SETTLING)
        before = session.read_state()
        session.advance(1)
        return before, (session.read_state().omega_body - before.omega_body) / INSTANT


def rate_slack(scenario: Scenario, state: State) -> float:
    """What one step's derivative may be off: h |ω̈| / 2, bounded by the rates of the scene."""
    spin = float(np.linalg.norm(state.omega_body))
    rate = spin + float(np.linalg.norm(omega_rate(scenario, state))) / spin
    return INSTANT * rate**2 * spin + np.finfo(float).eps * spin / INSTANT


@pytest.mark.parametrize(("scenario", "method"), CASES)
def test_a_step_obeys_eulers_equations(scenario: Scenario, method: Method) -> None:
    before, rate = settled_step(scenario, method)
    error = np.abs(rate - omega_rate(scenario, before)).max()
    assert error <= rate_slack(scenario, before)


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_equations_with_gravity_upside_down_are_told_apart(method: Method) -> None:
    scenario = SCENES["heavy-tilted"]
    before, rate = settled_step(scenario, method)
    error = np.abs(rate - omega_rate(scenario, before, gravity_sign=-1)).max()
    assert error > 1000 * rate_slack(scenario, before)


def measured_orders(scenario: Scenario, method: Method) -> tuple[float, float]:
    """Signed orders of ω and attitude, from differences of three runs, each halving the last."""
    motions = []
    for refinement in (1, 2, 4):
        steps = COARSEST * refinement
        samples = np.arange(9) * (steps // 8)
        motions.append(ENGINE.run(scenario, method, SPAN / steps, samples).trajectory)
    pairs = list(pairwise(motions))
    omega = [np.abs(a.omega_body - b.omega_body).max() for a, b in pairs]
    attitude = [(a.R_world_body.inv() * b.R_world_body).magnitude().max() for a, b in pairs]
    return float(np.log2(omega[0] / omega[1])), float(np.log2(attitude[0] / attitude[1]))


@pytest.mark.parametrize(("scenario", "method"), CASES)
def test_orders_are_the_declared_ones(scenario: Scenario, method: Method) -> None:
    omega, attitude = measured_orders(scenario, method)
    assert abs(omega - method.order) <= ORDER_SLACK
    assert abs(attitude - method.attitude_order) <= ORDER_SLACK


@pytest.mark.parametrize(("scenario", "method"), CASES)
def test_many_steps_in_a_call_are_as_many_calls_bit_for_bit(
    scenario: Scenario, method: Method
) -> None:
    with (
        opened(scenario, method, ODD_TIMESTEP) as at_once,
        opened(scenario, method, ODD_TIMESTEP) as one_by_one,
    ):
        at_once.advance(ODD_STEPS)
        for _ in range(ODD_STEPS):
            one_by_one.advance(1)
        assert np.array_equal(state(at_once), state(one_by_one))


@pytest.mark.parametrize(("scenario", "method"), CASES)
def test_reading_does_not_disturb(scenario: Scenario, method: Method) -> None:
    with (
        opened(scenario, method, TIMESTEP) as watched,
        opened(scenario, method, TIMESTEP) as alone,
    ):
        for _ in range(ODD_STEPS):
            watched.advance(1)
            watched.check()
            watched.read_state()
            watched.read_body()
        alone.advance(ODD_STEPS)
        assert np.array_equal(state(watched), state(alone))


@pytest.mark.parametrize(("scenario", "method"), CASES)
def test_runs_are_deterministic(scenario: Scenario, method: Method) -> None:
    assert np.array_equal(columns(run(scenario, method)), columns(run(scenario, method)))


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_two_sessions_share_no_memory(method: Method) -> None:
    first, second = SCENES["heavy-top"], SCENES["heavy-tilted"]
    with opened(first, method, TIMESTEP) as a, opened(second, method, TIMESTEP) as b:
        for _ in range(10):
            a.advance(7)
            b.advance(5)
        interleaved = state(a), state(b)
    for scenario, steps, got in zip((first, second), (70, 50), interleaved, strict=True):
        with opened(scenario, method, TIMESTEP) as alone:
            alone.advance(steps)
            assert np.array_equal(state(alone), got)


def test_methods_differ_from_one_another() -> None:
    motions = [columns(run(SCENES["heavy-tilted"], method)) for method in METHODS]
    for a, b in pairwise(motions):
        assert np.abs(a - b).max() > TIMESTEP**2


def test_a_free_body_has_no_use_for_a_constraint() -> None:
    result = run(SCENES["free"], ENGINE.method("multibody-p2p"))
    assert result.outcome == "unsupported"
    assert result.reason == "pybullet multibody-p2p is for scenes with pivot"


def test_a_closed_world_is_given_back() -> None:
    session = opened(SCENES["pivot"], ENGINE.method("multibody"), TIMESTEP)
    assert p.isConnected(session.client)
    session.close()
    assert p.getNumBodies(session.client) == 0
    with opened(SCENES["free"], ENGINE.method("multibody"), TIMESTEP) as again:
        assert again.client == session.client


def test_giving_a_world_back_leaves_every_other_as_it_is() -> None:
    first = opened(SCENES["pivot"], ENGINE.method("multibody"), TIMESTEP)
    with opened(SCENES["pivot"], ENGINE.method("multibody"), TIMESTEP):
        pass
    assert p.getNumBodies(first.client) == 1
    first.close()


def test_a_scene_that_does_not_load_leaves_no_world_behind(monkeypatch) -> None:
    monkeypatch.setattr(worlds, "_empty", [])
    tiny = scene("tiny", body="\nmass = 1.0\ninertia = [1e-17, 1e-17, 1e-17]\n")
    before = p.connect(p.DIRECT)
    assert run(tiny, ENGINE.method("multibody")).outcome == "unsupported"
    after = p.connect(p.DIRECT)
    p.disconnect(before)
    p.disconnect(after)
    assert after == before + 1


def test_a_clock_that_somebody_else_set_is_noticed() -> None:
    with opened(SCENES["free"], ENGINE.method("multibody"), TIMESTEP) as session:
        session.advance(1)
        session.check()
        p.setTimeStep(2 * TIMESTEP, physicsClientId=session.client)
        with pytest.raises(EngineError, match="time and steps a call must be"):
            session.check()


#: Where `scenes` is.
SUPPORT = Path(__file__).parents[2] / "support"

SILENT = """
import sys
sys.path.insert(0, {folder!r})
{first}
import numpy as np
from scenes import SCENES
from spincheck.engines.adapters.pybullet.engine import PyBullet
engine = PyBullet()
for method in engine.methods:
    engine.run(SCENES["heavy-tilted"], method, 1e-3, np.array([0, 10]))
"""


def printed(first: str) -> str:
    """What a process that runs every method prints, C's output included."""
    script = SILENT.format(folder=str(SUPPORT), first=first)
    process = subprocess.run([sys.executable, "-c", script], capture_output=True, check=True)
    return (process.stdout + process.stderr).decode()


def test_nothing_reaches_the_terminal() -> None:
    assert printed("") == ""


def test_without_the_capture_it_would() -> None:
    assert "pybullet build time" in printed("import pybullet")
