"""PyBullet's model of a body: what it reads, in which frames; when its pivot gives way."""

import tempfile
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pybullet as p
import pytest
from case_loops import each_case
from library_scenes import library_scene
from pybullet_planted import (
    BY_CONSTRAINT,
    ENGINE,
    MAXIMAL,
    MULTIBODY,
    STEPS,
    TIMESTEP,
    leave_out,
    opened,
    rotor,
    run,
)
from scipy.spatial.transform import Rotation
from spincheck.engines import Method
from spincheck.engines.adapters.pybullet import session, world, worlds
from spincheck.engines.checks.faults import Bounds, faults
from spincheck.engines.checks.read_back import READ_BACK_SLACK
from spincheck.reports.harness.measuring.examine import physics_in_words
from spincheck.suite.contract_scenes import PIVOT, SCENES, SKEW_GRAVITY, scene

EPS = np.finfo(float).eps
#: A few products of rotations a step, over `STEPS`.
ROUND_OFF = 16 * EPS * STEPS[-1]


# The model file


def test_no_file_of_a_world_is_left_where_its_process_may_be_killed(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Workers are killed, and run nothing at their exit."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    with opened(SCENES["free-tilted"], MULTIBODY):
        assert [*tmp_path.iterdir()] == []


def test_a_world_that_has_read_another_of_its_name_does_not_read_it(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """So that each scene has a world of its own."""
    one_place = SimpleNamespace(TemporaryDirectory=lambda **_: nullcontext(str(tmp_path)))
    monkeypatch.setattr(world, "tempfile", one_place)
    monkeypatch.setattr(worlds, "_empty", [])
    assert run(SCENES["free-tilted"], MULTIBODY).outcome == "ok"
    worlds._empty.clear()
    assert run(SCENES["free"], MULTIBODY).outcome == "ok"
    shared = p.connect(p.DIRECT)
    monkeypatch.setattr(session, "take_world", lambda: shared)
    monkeypatch.setattr(session, "give_back", lambda _: None)
    run(SCENES["free-tilted"], MULTIBODY)
    result = run(SCENES["free"], MULTIBODY)
    p.disconnect(shared)
    assert result.outcome == "failed"
    assert result.reason.startswith("'mass' must read back as")


# Frames


def attitude_after_a_step(spin: float) -> float:
    """Angle that a hung rotor is read to have turned by in its first step."""
    with opened(rotor(spin), MULTIBODY) as session:
        session.advance(1)
        q = session.read_state().q_world_body_wxyz
        return float(Rotation.from_quat(q, scalar_first=True).magnitude())


def test_without_forward_kinematics_it_is_read_a_step_late(monkeypatch: pytest.MonkeyPatch) -> None:
    assert attitude_after_a_step(10.0) == pytest.approx(10.0 * TIMESTEP, rel=ROUND_OFF)
    real = p.getLinkState
    monkeypatch.setattr(
        p,
        "getLinkState",
        lambda body, link, velocity, _, client: real(body, link, velocity, 0, client),
    )
    assert attitude_after_a_step(10.0) == 0.0


# A rigid body's inertia


def first_spin(method: Method) -> np.ndarray:
    """ω after one step from rest under a torque, world axes."""
    with opened(SCENES["free-torque-world"], method) as session:
        p.resetBaseVelocity(session.world.body, np.zeros(3), np.zeros(3), session.client)
        session.advance(1)
        return np.array(p.getBaseVelocity(session.world.body, session.client)[1])


def test_a_rigid_body_is_loaded_in_its_pose_lest_its_inertia_be_that_of_another(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scenario = SCENES["free-torque-world"]
    R = Rotation.from_quat(scenario.start.q_world_body_wxyz, scalar_first=True).as_matrix()
    tensor_world = R @ scenario.body.inertia_com @ R.T
    expected = TIMESTEP * np.linalg.solve(tensor_world, scenario.pushed["torque_world"])
    assert first_spin(MAXIMAL) == pytest.approx(expected, rel=READ_BACK_SLACK)

    real = p.loadURDF

    def load_then_turn(file: str, position: Any, attitude: Any, **keywords: Any) -> int:
        right = real(file, position, attitude, **keywords)
        pose = p.getBasePositionAndOrientation(right, keywords["physicsClientId"])
        p.removeBody(right, keywords["physicsClientId"])
        turned = int(real(file, **keywords))
        p.resetBasePositionAndOrientation(turned, *pose, keywords["physicsClientId"])
        return turned

    monkeypatch.setattr(p, "loadURDF", load_then_turn)
    assert np.abs(first_spin(MAXIMAL) - expected).max() > 0.1 * np.abs(expected).max()


# A pivot as a constraint


def test_a_constraint_that_is_taken_away_is_noticed() -> None:
    with opened(SCENES["heavy-tilted"], BY_CONSTRAINT) as session:
        session.advance(1)
        session.check()
        p.removeConstraint(p.getConstraintUniqueId(0, session.client), session.client)
        session.advance(1000)
        states = session.states([session.snapshot()])
        bounds = Bounds(TIMESTEP, np.inf, session.read_body().com)
        (fault,) = faults(states, bounds)
        assert fault.cause == "pivot"
        assert "pivot" not in session.active()


HEAVY = """
mass = 1e5
inertia = [1e5, 2e5, 2.5e5]
com = [0.0, 0.0, 1.0]
"""


def test_a_multibodys_constraint_bears_any_load(monkeypatch: pytest.MonkeyPatch) -> None:
    heavy = scene("heavy", body=HEAVY, effects=PIVOT + SKEW_GRAVITY)
    steps = np.arange(0, 101, 10)
    assert ENGINE.run(heavy, BY_CONSTRAINT, 0.01, steps).outcome == "ok"
    leave_out(monkeypatch, "changeConstraint", "maxForce")
    assert ENGINE.run(heavy, BY_CONSTRAINT, 0.01, steps).outcome == "diverged"


#: Hangs at rest, so that its pivot bears its weight alone: 9 kN along the world's z.
HANGING = """
mass = 1e3
inertia = [10.0, 20.0, 25.0]
com = [0.0, 0.0, -1.0]
"""
AT_REST = """
quaternion_wxyz = [1.0, 0.0, 0.0, 0.0]
omega_body = [0.0, 0.0, 0.0]
"""
DOWN = "[effects.gravity]\nacceleration = [0.0, 0.0, -9.0]\n"
HANGS = scene("hangs", body=HANGING, start=AT_REST, effects=PIVOT + DOWN)
#: s, of which it bears 500 N s.
BORNE = 500 / 9e3


@each_case(("timestep", "falls"), [(0.999 * BORNE, False), (1.001 * BORNE, True)])
def test_a_rigid_bodys_gives_way_beyond_500_newton_seconds_a_step(
    timestep: float, falls: bool
) -> None:
    """So that a scene in which it would is not run."""
    with opened(HANGS, MAXIMAL, timestep) as session:
        session.advance(100)
        speed = np.linalg.norm(session.read_state().velocity_world)
    # It falls with the thousandth of its weight that is not borne.
    assert speed == pytest.approx(9.0 * 1e-3 / 1.001 * 100 * timestep if falls else 0.0, abs=1e-6)
    run = ENGINE.run(HANGS, MAXIMAL, timestep, np.arange(3))
    assert run.outcome == ("unsupported" if falls else "ok")
    assert ("bears at most 500 N s a step" in run.reason) == falls


def test_a_pivot_that_gives_way_in_first_steps_is_no_other_equation_of_motion() -> None:
    """Of a top of a thousand kilometres it does at any timestep that a run could have."""
    assert physics_in_words(ENGINE, library_scene("megametre-top"), MAXIMAL) == ""


#: m r² / I of the slender one: by so much its constraint is stiffer along its arm than across.
STIFFNESS = 500
SLENDER = """
mass = 1.0
inertia = [1e-3, 2e-3, 2.5e-3]
com = [0.3, 0.4, 0.5]
"""


def slip(method: Method) -> float:
    """Velocity that the first step leaves where the pivot was as it began, over the com's."""
    slender = scene("slender", body=SLENDER, effects=PIVOT + SKEW_GRAVITY)
    with opened(slender, method) as session:
        arm_world = session.read_state().com_world
        session.advance(1)
        velocity_world, omega_world = p.getBaseVelocity(session.world.body, session.client)
        left_over = np.array(velocity_world) - np.cross(omega_world, arm_world)
        return float(np.linalg.norm(left_over) / np.linalg.norm(velocity_world))


@pytest.mark.parametrize("method", [BY_CONSTRAINT, MAXIMAL], ids=lambda method: method.name)
def test_a_constraint_is_solved_to_round_off(method: Method) -> None:
    assert slip(method) <= STIFFNESS * EPS


@pytest.mark.parametrize("method", [BY_CONSTRAINT, MAXIMAL], ids=lambda method: method.name)
def test_by_the_default_solver_it_is_not(method: Method, monkeypatch: pytest.MonkeyPatch) -> None:
    leave_out(monkeypatch, "setPhysicsEngineParameter", "constraintSolverType")
    # Of the order of what gravity gains in a step: it is hardly solved at all.
    assert slip(method) > TIMESTEP
