"""PyBullet, beyond the contract: reuse of worlds, its clock, no output."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pybullet as p
import pytest
from case_loops import each_case
from library_scenes import library_scene
from pybullet_planted import ENGINE, MAXIMAL, METHODS, MULTIBODY, TIMESTEP, opened
from spincheck.engines import EngineError, Method, Run
from spincheck.engines.adapters.pybullet import worlds
from spincheck.engines.adapters.pybullet.session import PyBulletSession
from spincheck.engines.checks.read_back import UnsupportedError, start_state
from spincheck.reports.harness.measuring.steps import flowed
from spincheck.reports.harness.prepared import prepare
from spincheck.suite import test_adapter
from spincheck.suite.contract_scenes import SCENES, scene

TIPPE_TOP, CONTACT = library_scene("tippe-top-without-friction"), ENGINE.method("contact")


def test_a_closed_world_is_given_back_and_every_other_left_as_it_is() -> None:
    other = opened(SCENES["pivot"], MULTIBODY)
    session = opened(SCENES["pivot"], MULTIBODY)
    assert p.isConnected(session.client)
    session.close()
    assert (p.getNumBodies(session.client), p.getNumBodies(other.client)) == (0, 1)
    with opened(SCENES["free"], MULTIBODY) as again:
        assert again.client == session.client
    other.close()


def test_a_scene_that_does_not_load_leaves_no_world_behind(monkeypatch) -> None:
    monkeypatch.setattr(worlds, "_empty", [])
    tiny = scene("tiny", body="\nmass = 1.0\ninertia = [1e-17, 1e-17, 1e-17]\n")
    before = p.connect(p.DIRECT)
    run = ENGINE.run(tiny, MULTIBODY, TIMESTEP, np.arange(3))
    assert run.outcome == "unsupported"
    after = p.connect(p.DIRECT)
    p.disconnect(before)
    p.disconnect(after)
    assert after == before + 1


def test_a_clock_that_somebody_else_set_is_noticed() -> None:
    with opened(SCENES["free"], MULTIBODY) as session:
        session.advance(1)
        session.check()
        p.setTimeStep(2 * TIMESTEP, physicsClientId=session.client)
        with pytest.raises(EngineError, match="time and steps a call must be"):
            session.check()


def run_often(scene: str, method: str) -> Run:
    return ENGINE.run(SCENES[scene], ENGINE.method(method), 1e-4, np.arange(0, 200, 7))


def bits(run_made: Run) -> tuple[object, ...]:
    motion = run_made.trajectory
    samples = None if motion is None else [column.tobytes() for column in vars(motion).values()]
    # After a clamp, the torques measured in a world differ in digits that are not reported.
    active = run_made.active if run_made.outcome == "ok" else None
    return run_made.outcome, run_made.reason, active, samples


@pytest.mark.slow
def test_a_world_that_was_used_before_moves_a_body_as_a_new_one_does() -> None:
    pairs = [
        (scene, method.name)
        for scene in SCENES
        for method in ENGINE.methods
        if not ENGINE.unsupported(SCENES[scene], method)
    ]
    in_new_worlds = {}
    for pair in pairs:
        # A world that is forgotten, but not closed, takes 30 MB until the process ends.
        while worlds._empty:
            p.disconnect(worlds._empty.pop())
        in_new_worlds[pair] = bits(run_often(*pair))
    for k in np.random.default_rng(0).permutation(len(pairs)):
        assert bits(run_often(*pairs[k])) == in_new_worlds[pairs[k]]
    assert len(worlds._empty) == 1


# Restarts


def test_an_inertia_of_pybullet_that_stays_behind_is_caught(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A rigid body keeps the inertia, in world axes, of the attitude at its last step."""
    monkeypatch.setattr(PyBulletSession, "_step_at_rest", lambda *_: None)
    with pytest.raises(pytest.fail.Exception, match="a restart is not a scene opened there"):
        test_adapter.test_restarts_as_it_opens(ENGINE, MAXIMAL)


@each_case("method", METHODS)
def test_pybullet_remembers_nothing_but_its_state(method: Method) -> None:
    """Where the pivot has drifted to is a part of that: a run goes on from its own state."""
    scene = SCENES["heavy-tilted"]
    with (
        opened(scene, method) as continued,
        opened(scene, method) as session,
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


def apart_by_what_was_before() -> float:
    """By how much the last of many restarts ends elsewhere than that of a new session, rad/s."""
    steps, timestep = 96, 2.0**-11 / 100
    states = prepare(TIPPE_TOP, (), 1).places.states
    earlier = np.full(len(states.omega_body), -steps * timestep)
    starts, last = flowed(TIPPE_TOP, states, earlier), len(earlier) - 1
    with opened(TIPPE_TOP, CONTACT) as used, opened(TIPPE_TOP, CONTACT) as new:
        for session, first in (used, 0), (new, last):
            for k in range(first, last + 1):
                session.restart(starts.rows(k), timestep)
                session.advance(steps + 1)
        return float(np.abs(used.read_state().omega_body - new.read_state().omega_body).max())


def test_a_restart_of_pybullet_leaves_nothing_of_a_contact(monkeypatch: pytest.MonkeyPatch) -> None:
    assert apart_by_what_was_before() == 0
    monkeypatch.setattr(PyBulletSession, "_step_at_rest", lambda *_: None)
    assert apart_by_what_was_before() > 1e-4


def test_a_pivot_of_pybullet_that_cannot_bear_a_state_refuses_the_restart() -> None:
    scene = SCENES["heavy-tilted"]
    with opened(scene, MAXIMAL) as session:
        fast = replace(start_state(scene), omega_body=np.array([0.0, 2e3, 0.0]))
        with pytest.raises(UnsupportedError, match="bears at most 500 N s a step"):
            session.restart(fast)


# No output

SILENT = """
import numpy as np
from spincheck.suite.contract_scenes import SCENES
from spincheck.engines.adapters.pybullet.engine import PyBullet
engine = PyBullet()
for method in engine.methods:
    engine.run(SCENES["heavy-tilted"], method, 1e-3, np.array([0, 10]))
"""


@pytest.mark.processes
@pytest.mark.parametrize(("first", "prints"), [("", False), ("import pybullet", True)])
def test_nothing_reaches_the_terminal_and_without_the_capture_it_would(
    first: str, prints: bool
) -> None:
    """What a process prints that runs every method, C's output included."""
    script = [sys.executable, "-c", first + SILENT]
    process = subprocess.run(script, capture_output=True, check=True)
    printed = (process.stdout + process.stderr).decode()
    assert "pybullet build time" in printed if prints else printed == ""
