"""Runs no better than no motion have the cause `lost`; runs with ordinary errors do not."""

from collections.abc import Callable
from copy import copy
from dataclasses import replace

import numpy as np
import pytest
from library_scenes import library_scene
from scene_texts import FAST_TOP
from scipy.spatial.transform import Rotation
from spincheck.engines import Run, engines
from spincheck.reference import solve
from spincheck.reports.harness.comparison import rows
from spincheck.reports.harness.comparison.rows import row_of
from spincheck.reports.harness.timesteps.ladder import single
from spincheck.reports.results.records import Key
from spincheck.scenarios import Trajectory, error_series, loads

HEAVY, FREE = loads(FAST_TOP, "top"), library_scene("tennis-racket")
THROWN = library_scene("hammer")


def exact_motion_of(scenario) -> Trajectory:
    return solve(scenario, scenario.times).trajectory


def no_better_than_rest(scenario, motion: Trajectory, exact: Trajectory) -> str:
    series = error_series(scenario, motion, exact)
    return rows.no_better_than_rest(scenario, motion, exact, series)


def turned_aside(exact: Trajectory, angle: float) -> Trajectory:
    """The whole motion, turned about a level axis of the world: all but attitude and L alike."""
    turn = Rotation.from_rotvec([angle, 0.0, 0.0])
    return replace(
        exact,
        q_world_body_wxyz=(turn * exact.R_world_body).as_quat(scalar_first=True),
        com_world=turn.apply(np.array(exact.com_world)),
        velocity_world=turn.apply(np.array(exact.velocity_world)),
    )


def still(exact: Trajectory) -> Trajectory:
    """A body that does not move."""
    return replace(
        exact,
        q_world_body_wxyz=np.tile(exact.q_world_body_wxyz[0], (len(exact.t), 1)),
        omega_body=0 * exact.omega_body,
        com_world=np.tile(exact.com_world[0], (len(exact.t), 1)),
        velocity_world=0 * exact.velocity_world,
    )


def earlier(exact: Trajectory, samples: int) -> Trajectory:
    """The motion, that many samples late."""
    names = ("q_world_body_wxyz", "omega_body", "com_world", "velocity_world")
    return replace(exact, **{name: np.roll(getattr(exact, name), samples, 0) for name in names})


@pytest.mark.parametrize("scenario", [HEAVY, FREE, THROWN], ids=lambda scenario: scenario.name)
def test_a_body_that_never_moves_is_lost_and_the_exact_motion_is_not(scenario):
    exact = exact_motion_of(scenario)
    assert no_better_than_rest(scenario, exact, exact) == ""
    words = no_better_than_rest(scenario, still(exact), exact)
    assert words.startswith("lost: ω is off by 1 times its size")


#: rad; L turned by more than 60° is further off than its size.
@pytest.mark.parametrize(("angle", "is_lost"), [(0.9 * np.pi / 3, False), (1.1 * np.pi / 3, True)])
def test_a_motion_whose_L_points_elsewhere_is_lost(angle, is_lost):
    exact = exact_motion_of(FREE)
    words = no_better_than_rest(FREE, turned_aside(exact, angle), exact)
    assert ("L is off by" in words) == is_lost


def test_a_single_flip_out_of_time_is_not_lost():
    exact = exact_motion_of(FREE)
    late = earlier(exact, 20)
    apart = np.linalg.norm(late.omega_body - exact.omega_body, axis=1)
    assert apart[len(apart) // 2 :].max() > np.linalg.norm(exact.omega_body, axis=1).max()
    assert "ω" not in no_better_than_rest(FREE, late, exact)


def test_a_body_thrown_another_way_is_lost():
    exact = exact_motion_of(THROWN)
    start = exact.com_world[0]
    elsewhere = replace(exact, com_world=start - (exact.com_world - start))
    assert "com is off by" in no_better_than_rest(THROWN, elsewhere, exact)


def test_what_does_not_turn_is_not_lost_by_rounding():
    still_scene = loads(FAST_TOP.replace("40.0]", "0.0]").replace("30.0", "0.0"), "upright")
    exact = exact_motion_of(still_scene)
    rounded = replace(exact, omega_body=exact.omega_body + np.finfo(float).eps)
    assert no_better_than_rest(still_scene, rounded, exact) == ""


def row(method: str, timestep: float, scene=HEAVY, changed: Callable[[Run], Run] = copy):
    mujoco, rung = engines()["mujoco"], single(timestep, scene.times)
    run = mujoco.run(scene, mujoco.method(method), timestep, rung.sample_steps)
    solution = solve(scene, rung.sample_steps * timestep)
    return row_of(scene, Key("top", "mujoco", method), "1", rung, changed(run), solution)


def test_an_implicit_rule_that_is_stable_and_lost_has_not_survived_and_does_with_small_steps():
    """Its energy is conserved to a fifth, and its axis points the other way in the end."""
    calm = row("implicit", 1e-2)
    assert (calm.outcome, calm.cause, calm.without_skill) == ("ok", "lost", True)
    assert calm.errors is not None
    assert calm.errors.energy < 0.5
    assert not calm.survived
    calm = row("implicit", 1e-4)
    assert (calm.outcome, calm.cause, calm.survived) == ("ok", "", True)


def test_an_energy_of_terms_too_large_for_a_double_is_absurd():
    """And no warning of numpy reaches the user."""

    def blown_up(run: Run) -> Run:
        spins = np.array(run.trajectory.spins)
        spins[-1] = -1e200
        return replace(run, trajectory=replace(run.trajectory, spins=spins))

    scene = library_scene("gyroscope-in-its-frame")
    assert row("RK4", 1e-3, scene).outcome == "ok"
    blown = row("RK4", 1e-3, scene, blown_up)
    assert (blown.outcome, blown.cause) == ("diverged", "energy")
