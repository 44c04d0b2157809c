"""A calm run that has nothing to do with the scene's motion is lost; one that errs is not."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from spincheck.engines import engines
from spincheck.reference import solve
from spincheck.reports.harness.comparison import row_of
from spincheck.reports.harness.ladder import single
from spincheck.reports.harness.without_skill import no_better_than_rest
from spincheck.reports.results.records import Key
from spincheck.scenarios import Trajectory, find, load, loads

TOP = """
spincheck = 1
title = "A fast top"
source = "made up"
[body]
mass = 1.0
inertia = [0.02, 0.02, 0.01]
com = [0.0, 0.0, 0.1]
[start]
euler_zyz_deg = [0.0, 30.0, 0.0]
omega_body = [0.0, 0.0, 40.0]
[effects.gravity]
acceleration = [0.0, 0.0, -9.81]
[effects.pivot]
[window]
duration = 5.0
samples = 101
"""
HEAVY, FREE = loads(TOP, "top"), load(find(["tennis-racket"])[0])
THROWN = load(find(["hammer"])[0])


def truth_of(scenario) -> Trajectory:
    return solve(scenario, scenario.times).trajectory


def turned_aside(truth: Trajectory, angle: float) -> Trajectory:
    """The whole motion, turned about a level axis of the world: all but attitude and L alike."""
    turn = Rotation.from_rotvec([angle, 0.0, 0.0])
    return replace(
        truth,
        q_world_body_wxyz=(turn * truth.R_world_body).as_quat(scalar_first=True),
        com_world=turn.apply(np.array(truth.com_world)),
        velocity_world=turn.apply(np.array(truth.velocity_world)),
    )


def still(truth: Trajectory) -> Trajectory:
    """A body that never limit_increments."""
    return replace(
        truth,
        q_world_body_wxyz=np.tile(truth.q_world_body_wxyz[0], (len(truth.t), 1)),
        omega_body=0 * truth.omega_body,
        com_world=np.tile(truth.com_world[0], (len(truth.t), 1)),
        velocity_world=0 * truth.velocity_world,
    )


def earlier(truth: Trajectory, samples: int) -> Trajectory:
    """The motion, that many samples late."""
    names = ("q_world_body_wxyz", "omega_body", "com_world", "velocity_world")
    return replace(truth, **{name: np.roll(getattr(truth, name), samples, 0) for name in names})


@pytest.mark.parametrize("scenario", [HEAVY, FREE, THROWN], ids=lambda scenario: scenario.name)
def test_the_truth_is_not_lost(scenario):
    assert no_better_than_rest(scenario, truth_of(scenario), truth_of(scenario)) == ""


@pytest.mark.parametrize("scenario", [HEAVY, FREE, THROWN], ids=lambda scenario: scenario.name)
def test_a_body_that_never_moves_is_lost(scenario):
    truth = truth_of(scenario)
    assert no_better_than_rest(scenario, still(truth), truth).startswith(
        "lost: ω is off by 1 times its size"
    )


#: rad; L turned by more than 60° is further off than its size.
@pytest.mark.parametrize(("angle", "is_lost"), [(0.9 * np.pi / 3, False), (1.1 * np.pi / 3, True)])
def test_a_motion_whose_L_points_elsewhere_is_lost(angle, is_lost):
    truth = truth_of(FREE)
    assert (
        "L is off by" in no_better_than_rest(FREE, turned_aside(truth, angle), truth)
    ) == is_lost


def test_a_single_flip_out_of_time_is_not_lost():
    truth = truth_of(FREE)
    late = earlier(truth, 20)
    apart = np.linalg.norm(late.omega_body - truth.omega_body, axis=1)
    assert apart[len(apart) // 2 :].max() > np.linalg.norm(truth.omega_body, axis=1).max()
    assert "ω" not in no_better_than_rest(FREE, late, truth)


def test_a_body_thrown_another_way_is_lost():
    truth = truth_of(THROWN)
    start = truth.com_world[0]
    elsewhere = replace(truth, com_world=start - (truth.com_world - start))
    assert "com is off by" in no_better_than_rest(THROWN, elsewhere, truth)


def test_what_does_not_turn_in_truth_is_not_lost_by_rounding():
    still_scene = loads(TOP.replace("40.0]", "0.0]").replace("30.0", "0.0"), "upright")
    truth = truth_of(still_scene)
    rounded = replace(truth, omega_body=truth.omega_body + np.finfo(float).eps)
    assert no_better_than_rest(still_scene, rounded, truth) == ""


def row(method: str, timestep: float):
    mujoco, rung = engines()["mujoco"], single(timestep, HEAVY.times)
    run = mujoco.run(HEAVY, mujoco.method(method), timestep, rung.sample_steps)
    solution = solve(HEAVY, rung.sample_steps * timestep)
    return row_of(HEAVY, Key("top", "mujoco", method), "1", rung, run, solution)


def test_an_implicit_rule_that_is_stable_and_lost_has_not_survived():
    """Its energy is conserved to a fifth, and its axis points the other way in the end."""
    found = row("implicit", 1e-2)
    assert (found.outcome, found.cause, found.lost) == ("ok", "lost", True)
    assert found.errors is not None
    assert found.errors.energy < 0.5
    assert not found.survived


def test_the_same_rule_with_small_steps_survives():
    found = row("implicit", 1e-4)
    assert (found.outcome, found.cause, found.survived) == ("ok", "", True)
