"""Nothing of earlier steps is left after a restart of MuJoCo and PyBullet, or it is caught."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from spincheck.engines import EngineError, engines
from spincheck.engines.checks.read_back import UnsupportedError, start_state
from spincheck.suite import test_adapter
from spincheck.suite.contract_scenes import SCENES

pytestmark = pytest.mark.slow

TIMESTEP = 1e-3


def test_a_clock_of_mujoco_that_goes_on_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    engine = engines()["mujoco"]
    monkeypatch.setattr(mujoco, "mj_resetData", lambda *_: None)
    with pytest.raises(EngineError, match="clock must be at"):
        test_adapter.test_restarts_as_it_opens(engine, engine.method("RK4"))


@pytest.mark.needs_pybullet
def test_an_inertia_of_pybullet_that_stays_behind_is_caught(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A rigid body keeps the inertia, in world axes, of the attitude at its last step."""
    from spincheck.engines.adapters.pybullet.session import PyBulletSession

    engine = engines()["pybullet"]
    monkeypatch.setattr(PyBulletSession, "_renew_inertia", lambda *_: None)
    with pytest.raises(pytest.fail.Exception, match="a restart is not a scene opened there"):
        test_adapter.test_restarts_as_it_opens(engine, engine.method("maximal"))


@pytest.mark.needs_pybullet
@pytest.mark.parametrize("method", ["multibody", "multibody-p2p", "maximal"])
def test_pybullet_remembers_nothing_but_its_state(method: str) -> None:
    """Where the pivot has drifted to is a part of that: a run goes on from its own state."""
    engine, scene = engines()["pybullet"], SCENES["heavy-tilted"]
    with (
        engine.open(scene, engine.method(method), TIMESTEP) as continued,
        engine.open(scene, engine.method(method), TIMESTEP) as session,
    ):
        continued.advance(200)
        session.advance(57)
        session.restart(continued.read_state())
        for one in (continued, session):
            one.advance(90)
        apart = session.read_state().omega_body - continued.read_state().omega_body
    # A pivot takes back a fifth of its drift a step: roundings of the position, over the timestep.
    rounding = 16 * np.finfo(float).eps * (1 + 0.2 / TIMESTEP)
    assert np.linalg.norm(apart) <= rounding * np.linalg.norm(scene.start.omega_body)


@pytest.mark.needs_pybullet
def test_a_pivot_of_pybullet_that_cannot_bear_a_state_refuses_the_restart() -> None:
    engine, scene = engines()["pybullet"], SCENES["heavy-tilted"]
    with engine.open(scene, engine.method("maximal"), TIMESTEP) as session:
        fast = replace(start_state(scene), omega_body=np.array([0.0, 2e3, 0.0]))
        with pytest.raises(UnsupportedError, match="bears at most 500 N s a step"):
            session.restart(fast)


def test_a_body_that_mujoco_moves_by_its_origin_is_restarted_but_for_rounding() -> None:
    engine, scene = engines()["mujoco"], SCENES["free"]
    with engine.open(scene, engine.method("RK4"), TIMESTEP) as session:
        assert session.can_restart
        assert session.restarts_to_the_last_bit
    with engine.open(SCENES["free-tilted"], engine.method("RK4"), TIMESTEP) as session:
        assert not session.restarts_to_the_last_bit
