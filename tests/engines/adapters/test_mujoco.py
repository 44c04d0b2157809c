"""MuJoCo, by MJCF and by URDF: declared orders, determinism, separate memory, honest failures."""

from itertools import combinations

import mujoco
import numpy as np
import pytest
from scenes import SCENES, SPUN_UP, scene
from spincheck.engines import Engine, EngineError, Method, Run, engines
from spincheck.engines.adapters.mujoco.engine import MuJoCo
from spincheck.engines.adapters.mujoco.session import compiled
from spincheck.engines.adapters.mujoco.urdf_reader import MuJoCoURDF

EPS = np.finfo(float).eps
MUJOCO, BY_URDF = MuJoCo(), MuJoCoURDF()
INTEGRATORS = [method for method in MUJOCO.methods if not method.as_shipped]
METHODS = [
    pytest.param(engine, method, id=f"{engine.name}-{method.name}")
    for engine, methods in ((MUJOCO, INTEGRATORS), (BY_URDF, BY_URDF.methods))
    for method in methods
]
TIMESTEP = 1e-3
STEPS = np.arange(0, 101, 20)
SPAN = 0.5
#: Steps over SPAN at which a method of this order is in its asymptotic range, far above round-off.
COARSEST = {1: 256, 4: 32}
#: How far a measured order may be from the declared one, as for the verdict of a ladder.
ORDER_SLACK = 0.25


def run(engine: Engine, method: Method, name: str, timestep: float = TIMESTEP) -> Run:
    return engine.run(SCENES[name], method, timestep, STEPS)


def columns(run: Run) -> np.ndarray:
    """Everything a trajectory holds, side by side."""
    motion = run.trajectory
    assert motion is not None
    return np.hstack(
        [motion.q_world_body_wxyz, motion.omega_body, motion.com_world, motion.velocity_world]
    )


def measured_orders(engine: Engine, method: Method, name: str) -> tuple[float, float]:
    """Signed orders of ω and attitude, from differences of three runs, each halving the last."""
    motions = []
    for refinement in (1, 2, 4):
        steps = COARSEST[method.order] * refinement
        samples = np.arange(9) * (steps // 8)
        motions.append(engine.run(SCENES[name], method, SPAN / steps, samples).trajectory)
    coarse, medium, fine = motions
    assert coarse is not None
    assert medium is not None
    assert fine is not None
    pairs = ((coarse, medium), (medium, fine))
    omega = [np.abs(a.omega_body - b.omega_body).max() for a, b in pairs]
    attitude = [(a.R_world_body.inv() * b.R_world_body).magnitude().max() for a, b in pairs]
    return float(np.log2(omega[0] / omega[1])), float(np.log2(attitude[0] / attitude[1]))


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize(("engine", "method"), METHODS)
def test_every_scene_runs_or_is_unsupported_for_a_reason(
    engine: Engine, method: Method, name: str
) -> None:
    done = run(engine, method, name)
    if engine.unsupported(SCENES[name], method):
        assert (done.outcome, bool(done.reason)) == ("unsupported", True)
    else:
        assert (done.outcome, done.reason, done.steps) == ("ok", "", STEPS[-1])


@pytest.mark.parametrize(
    "name",
    ["free", "free-drag", "free-torque-world", "pivot", "heavy-tilted", "pivot-drag", "everything"],
)
@pytest.mark.parametrize(("engine", "method"), METHODS)
def test_orders_are_those_declared(engine: Engine, method: Method, name: str) -> None:
    if reason := engine.unsupported(SCENES[name], method):
        pytest.skip(reason)
    omega, attitude = measured_orders(engine, method, name)
    assert abs(omega - method.order) < ORDER_SLACK
    assert abs(attitude - method.attitude_order) < ORDER_SLACK


def test_every_two_integrators_differ_on_some_scene() -> None:
    runs = {
        (method.name, name): columns(run(MUJOCO, method, name))
        for method in INTEGRATORS
        for name in ("free-drag", "pivot")
    }
    for one, other in combinations([method.name for method in INTEGRATORS], 2):
        assert any(
            not np.array_equal(runs[one, name], runs[other, name])
            for name in ("free-drag", "pivot")
        ), f"{one} and {other} never differ"


@pytest.mark.parametrize("name", ["free-tilted", "heavy-tilted"])
@pytest.mark.parametrize(("engine", "method"), METHODS)
def test_k_steps_in_one_call_are_k_calls_bit_for_bit(
    engine: Engine, method: Method, name: str
) -> None:
    singles = engine.run(SCENES[name], method, TIMESTEP, np.arange(STEPS[-1] + 1))
    assert np.array_equal(columns(singles)[STEPS], columns(run(engine, method, name)))


@pytest.mark.parametrize(("engine", "method"), METHODS)
def test_a_run_repeats_bit_for_bit(engine: Engine, method: Method) -> None:
    first, second = (columns(run(engine, method, "heavy-tilted")) for _ in range(2))
    assert np.array_equal(first, second)


@pytest.mark.parametrize(("engine", "method"), METHODS)
def test_sessions_side_by_side_share_no_memory(engine: Engine, method: Method) -> None:
    alone = engine.open(SCENES["heavy-tilted"], method, TIMESTEP)
    alone.advance(50)
    first = engine.open(SCENES["heavy-tilted"], method, TIMESTEP)
    second = engine.open(SCENES["heavy-top"], method, TIMESTEP)
    for _ in range(50):
        first.advance(1)
        second.advance(1)
    wanted, got = alone.read_state(), first.read_state()
    assert all(np.array_equal(getattr(got, key), value) for key, value in vars(wanted).items())
    assert not np.array_equal(second.read_state().omega_body, got.omega_body)


@pytest.mark.parametrize("method", INTEGRATORS, ids=lambda method: method.name)
@pytest.mark.parametrize("name", SCENES)
def test_pruning_leaves_the_trajectory_as_it_was_bit_for_bit(name: str, method: Method) -> None:
    pruned = MUJOCO.open(SCENES[name], method, TIMESTEP)
    unpruned = MUJOCO.open_unpruned(SCENES[name], method, TIMESTEP)
    for session in (pruned, unpruned):
        session.advance(int(STEPS[-1]))
    wanted, got = unpruned.read_state(), pruned.read_state()
    assert all(np.array_equal(getattr(got, key), value) for key, value in vars(wanted).items())


@pytest.mark.parametrize("name", ["free-tilted", "free-falling", "pivot-plate", "heavy-tilted"])
def test_urdf_and_mjcf_are_one_body(name: str) -> None:
    (method,) = BY_URDF.methods
    by_mjcf = columns(run(MUJOCO, MUJOCO.method(method.name), name))
    difference = np.abs(columns(run(BY_URDF, method, name)) - by_mjcf).max()
    # Each step repeats the round-off of the tensor, which the URDF reader diagonalises again.
    roundoff = STEPS[-1] * 16 * EPS * np.abs(by_mjcf).max()
    assert difference < roundoff
    other_scene = columns(run(MUJOCO, MUJOCO.method(method.name), "free"))
    assert np.abs(other_scene - by_mjcf).max() > 1e9 * roundoff


@pytest.mark.parametrize("engine", [MUJOCO, BY_URDF], ids=lambda engine: engine.name)
@pytest.mark.parametrize(
    "body",
    ["\nmass = 1.0\ninertia = [1e-18, 1e-18, 1e-18]\n", "\nmass = 1e-18\ninertia = [1, 1, 1]\n"],
    ids=["inertia", "mass"],
)
def test_a_body_too_small_for_the_compiler_is_unsupported(engine: Engine, body: str) -> None:
    done = engine.run(scene("tiny", body=body), engine.method("RK4"), TIMESTEP, STEPS)
    assert (done.outcome, done.cause) == ("unsupported", "body")
    assert "scale the scene up" in done.reason


def test_what_the_compiler_refuses_is_told_in_its_words() -> None:
    # No body has such moments: one exceeds the sum of the others.
    inertial = "<inertial pos='0 0 0' mass='1' diaginertia='1 1 3'/>"
    text = f"<mujoco><worldbody><body><freejoint/>{inertial}</body></worldbody></mujoco>"
    with pytest.raises(EngineError, match=r"MuJoCo's compiler: .*inertia"):
        compiled(lambda: mujoco.MjModel.from_xml_string(text))


def test_a_start_beyond_what_mujoco_allows_diverges_in_its_words() -> None:
    fast = SPUN_UP.replace("40.0", "1e11")
    done = MUJOCO.run(
        scene("fast", start=fast, duration=1e-3), MUJOCO.method("RK4"), TIMESTEP, STEPS
    )
    assert done.outcome == "diverged"
    assert "huge value in QVEL" in done.reason


def test_the_version_is_the_librarys() -> None:
    assert MUJOCO.version == BY_URDF.version == mujoco.__version__


def test_both_are_found_by_name() -> None:
    assert {"mujoco", "mujoco-urdf"} <= set(engines())


@pytest.mark.parametrize("engine", [MUJOCO, BY_URDF], ids=lambda engine: engine.name)
def test_a_compiler_that_only_warns_fails_the_run_too(engine: Engine) -> None:
    # About its origin the body's mass matrix is singular in double precision.
    far = "\nmass = 1e8\ninertia = [1e-9, 1e-9, 1e-9]\ncom = [3.0, 4.0, 5.0]\n"
    done = engine.run(scene("far", body=far), engine.method("RK4"), TIMESTEP, STEPS)
    assert done.outcome == "failed"
    assert "Inertia matrix is too close to singular" in done.reason
