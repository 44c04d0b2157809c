"""MuJoCo's defaults that alter a run: each, planted, is detected.

Resets, warnings, and what a state is read from. The traps are listed in
docs/measured/engines-mujoco.md.
"""

import copy
import ctypes
from collections.abc import Iterator
from pathlib import Path

import mujoco
import numpy as np
import pytest
from case_loops import each_case
from spincheck.engines import EngineError
from spincheck.engines.adapters.mujoco import clock
from spincheck.engines.adapters.mujoco.engine import MuJoCo
from spincheck.engines.adapters.mujoco.session import MuJoCoSession
from spincheck.engines.models.mjcf import mjcf
from spincheck.scenarios import Scenario, Trajectory, angular_momentum_world, energy
from spincheck.suite import test_adapter
from spincheck.suite.contract_scenes import SCENES

EPS = np.finfo(float).eps
#: A dozen products of rotations and vectors.
ROUNDOFF = 64 * EPS
TIMESTEP = 1e-3
MUJOCO = MuJoCo()
#: With it Euler blows the heavy top up within five seconds.
COARSE_TIMESTEP = 1e-2


def session_of(scene: Scenario, integrator: str = "RK4") -> MuJoCoSession:
    """A session as the adapter opens it: at the first keyframe of its model."""
    model = mujoco.MjModel.from_xml_string(mjcf(scene, TIMESTEP, integrator))
    return MuJoCoSession(scene, model)


def sample(session: MuJoCoSession) -> Trajectory:
    state = {name: value[None] for name, value in vars(session.read_state()).items()}
    return Trajectory(t=np.zeros(1), **state)


def test_a_reset_without_a_warning_is_caught_by_the_clock() -> None:
    session = session_of(SCENES["heavy-top"])
    session.advance(10)
    session.check()
    mujoco.mj_resetData(session.model, session.data)
    with pytest.raises(EngineError, match=r"clock must be at 0.01 s, got 0.0 s: it was reset"):
        session.check()


def test_a_warning_nobody_heard_is_caught_by_the_counter() -> None:
    session = session_of(SCENES["heavy-top"])
    session.data.warning[mujoco.mjtWarning.mjWARN_INERTIA].number = 1
    with pytest.raises(EngineError, match="counted 1 kinds of warning"):
        session.check()


def test_warnings_of_a_session_end_up_in_its_check_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    session, bare = session_of(SCENES["heavy-top"]), session_of(SCENES["heavy-top"])
    for one in (session, bare):
        one.data.qvel[0] = np.nan
    session.advance(1)
    assert ([*tmp_path.iterdir()], capfd.readouterr()) == ([], ("", ""))
    with pytest.raises(EngineError, match="huge value in QVEL"):
        session.check()
    # Of a bare step they are in a log file, and on the terminal.
    mujoco.mj_step(bare.model, bare.data)
    assert [path.name for path in tmp_path.iterdir()] == ["MUJOCO_LOG.TXT"]
    assert "WARNING" in capfd.readouterr().err


def staleness(integrator: str) -> tuple[float, float, float]:
    """How far the com as read, and MuJoCo's xipos, are from the state; how far a step moves it."""
    session = session_of(SCENES["heavy-tilted"], integrator)
    session.advance(100)
    state, fresh = session.read_state(), copy.copy(session.data)
    mujoco.mj_forward(session.model, fresh)
    ours, mujocos = (
        float(np.linalg.norm(com_world - fresh.xipos[1]))
        for com_world in (state.com_world, session.data.xipos[1])
    )
    return ours, mujocos, float(np.linalg.norm(state.velocity_world)) * TIMESTEP


def test_the_state_is_read_as_it_is_now_where_derived_data_are_old() -> None:
    """A step old after a step of Euler, those of the last stage after one of RK4."""
    ours, mujocos, moved = staleness("Euler")
    assert ours < ROUNDOFF
    assert mujocos == pytest.approx(moved, rel=0.1)
    ours, mujocos, moved = staleness("RK4")
    assert ours < ROUNDOFF
    assert 1e3 * ROUNDOFF < mujocos < 1e-3 * moved


def test_angular_momentum_about_the_pivot_is_not_mujocos_which_is_about_the_com() -> None:
    scene = SCENES["heavy-tilted"]
    session = session_of(scene)
    session.advance(100)
    state, fresh = session.read_state(), copy.copy(session.data)
    mujoco.mj_forward(session.model, fresh)
    mujoco.mj_subtreeVel(session.model, fresh)
    about_com = fresh.subtree_angmom[1]
    lever = scene.body.mass * np.cross(state.com_world, state.velocity_world)
    (about_pivot,) = angular_momentum_world(scene, sample(session))
    slack = ROUNDOFF * np.abs(about_pivot).max()
    assert np.abs(about_pivot - (about_com + lever)).max() < slack
    assert np.abs(about_pivot - about_com).max() > 1e9 * slack


@pytest.mark.parametrize("name", ["free-falling", "heavy-tilted"])
def test_mujocos_own_energy_is_ours_but_only_where_its_computation_is_on(name: str) -> None:
    scene = SCENES[name]
    session = session_of(scene)
    session.advance(100)
    assert session.data.energy.tolist() == [0.0, 0.0]
    model, fresh = copy.copy(session.model), copy.copy(session.data)
    model.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
    mujoco.mj_forward(model, fresh)
    (ours,) = energy(scene, sample(session))
    assert fresh.energy.sum() == pytest.approx(ours, rel=ROUNDOFF)


# Restarts


def test_a_clock_of_mujoco_that_goes_on_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mujoco, "mj_resetData", lambda *_: None)
    with pytest.raises(EngineError, match="clock must be at"):
        test_adapter.test_restarts_as_it_opens(MUJOCO, MUJOCO.method("RK4"))


def test_a_body_that_mujoco_moves_by_its_origin_is_restarted_but_for_rounding() -> None:
    with MUJOCO.open(SCENES["free"], MUJOCO.method("RK4"), TIMESTEP) as session:
        assert session.can_restart
        assert session.restarts_to_the_last_bit
    with MUJOCO.open(SCENES["free-tilted"], MUJOCO.method("RK4"), TIMESTEP) as session:
        assert not session.restarts_to_the_last_bit


# Properties of its integrators, measured


def motion(scene: Scenario, integrator: str, steps: np.ndarray, timestep: float) -> Trajectory:
    run = MUJOCO.run(scene, MUJOCO.method(integrator), timestep, steps)
    assert run.trajectory is not None
    return run.trajectory


def omega(name: str, integrator: str) -> np.ndarray:
    return motion(SCENES[name], integrator, np.arange(0, 101, 10), COARSE_TIMESTEP).omega_body


@pytest.mark.parametrize("name", ["pivot", "pivot-drag", "heavy-tilted"])
@pytest.mark.parametrize("integrator", ["implicitfast", "discrete"])
def test_on_a_pivot_implicitfast_and_discrete_are_euler(name: str, integrator: str) -> None:
    assert np.array_equal(omega(name, integrator), omega(name, "Euler"))
    assert not np.array_equal(omega(name, "implicit"), omega(name, "Euler"))


@pytest.mark.parametrize("integrator", ["implicitfast", "discrete"])
def test_on_a_free_body_implicitfast_and_discrete_are_implicit(integrator: str) -> None:
    assert np.array_equal(omega("free", integrator), omega("free", "implicit"))
    assert not np.array_equal(omega("free", integrator), omega("free", "Euler"))


def energy_changes(integrator: str) -> np.ndarray:
    """Relative change of energy from sample to sample of a free tumble."""
    free = SCENES["free"]
    energies = energy(free, motion(free, integrator, np.arange(0, 101, 10), COARSE_TIMESTEP))
    return np.diff(energies) / energies[0]


def test_implicit_drains_a_tumble_steadily_and_rk4_does_not() -> None:
    # By about (h |ω|)² a step: 1.4e-3 at |ω| = 3.7 rad/s and h = 10 ms.
    per_sample = 10 * (COARSE_TIMESTEP * np.linalg.norm(SCENES["free"].start.omega_body)) ** 2
    drained = energy_changes("implicit")
    assert (drained < 0).all()
    assert -drained.sum() > per_sample / 10
    assert np.abs(energy_changes("RK4")).max() < 1e-3 * per_sample


# The clock that its Python package hangs in: clean sessions step without it

STEPS = 10


class CountingClock:
    """Hung into MuJoCo in place of its package's clock: counts how often it is read."""

    def __init__(self) -> None:
        self.reads = 0
        self._function = ctypes.CFUNCTYPE(ctypes.c_double)(self._read)
        self.address = ctypes.cast(self._function, ctypes.c_void_p).value

    def _read(self) -> float:
        self.reads += 1
        return 0.0

    def read_by(self, session: MuJoCoSession) -> int:
        """How often some steps of a session read it."""
        before = self.reads
        session.advance(STEPS)
        return self.reads - before


@pytest.fixture
def counting(monkeypatch: pytest.MonkeyPatch) -> Iterator[CountingClock]:
    shipped = clock.SHIPPED
    counter = CountingClock()
    monkeypatch.setattr(clock, "SHIPPED", counter.address)
    yield counter
    clock.hang(shipped)


def opened(method: str) -> MuJoCoSession:
    return MUJOCO.open(SCENES["heavy-top"], MUJOCO.method(method), TIMESTEP)


CLEAN = [method.name for method in MUJOCO.methods if not (method.as_shipped or method.requires)]


@each_case("method", CLEAN)
def test_sessions_of_both_kinds_may_be_stepped_in_turn(
    counting: CountingClock, method: str
) -> None:
    """A clean method reads no clock; as shipped it is read many times a step."""
    with opened(method) as clean, opened("default") as shipped:
        reads = [counting.read_by(session) for session in (clean, shipped, clean, shipped)]
    assert [count and count > 10 * STEPS for count in reads] == [0, True, 0, True]


def test_the_audit_reads_the_clock_of_the_session_that_is_asked() -> None:
    with opened("Euler") as clean, opened("default") as shipped:
        for session in (clean, shipped):
            session.advance(1)
        assert clock.CLOCK not in clean.active()
        assert clock.CLOCK in shipped.active()


def test_a_session_that_is_closed_leaves_the_clock_hung_in() -> None:
    with opened("Euler") as session:
        session.advance(1)
        assert not clock.is_hung()
    assert clock.is_hung()
