"""A pivot as a constraint: accuracy of its solution, and when it gives way."""

import numpy as np
import pybullet as p
import pytest
from case_loops import each_case
from library_scenes import library_scene
from pybullet_planted import (
    BY_CONSTRAINT,
    ENGINE,
    MAXIMAL,
    TIMESTEP,
    leave_out,
    opened,
)
from spincheck.engines import Method
from spincheck.engines.checks.faults import Bounds, faults
from spincheck.reports.harness.measuring.examine import physics_in_words
from spincheck.suite.contract_scenes import PIVOT, SCENES, SKEW_GRAVITY, scene

EPS = np.finfo(float).eps


# Constraints


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
