"""A defect shows what a run does in an interval, whatever came before it."""

from dataclasses import replace

import numpy as np
import pytest
from library_scenes import library_scene
from planted import HALFWAY, METHOD, HeunSession, SpunUpFromHalfwaySession, planted
from spincheck.engines import Engine
from spincheck.reference import ExactMotion
from spincheck.reports.harness.comparison.defects import LEAST_ROUNDING, NOISE, defects, turns_made
from spincheck.scenarios import Trajectory
from spincheck.scenarios.scenario import started_at

EPS = float(np.finfo(float).eps)
BOOK = library_scene("book-middle-axis")
INTERVALS = 20
TIMES = np.arange(INTERVALS + 1) / 16
EXACT = ExactMotion(BOOK).outline(TIMES)


def run(engine: Engine, steps: int) -> Trajectory:
    """A run of so many steps an interval."""
    made = engine.run(BOOK, METHOD, TIMES[1] / steps, steps * np.arange(INTERVALS + 1))
    assert made.outcome == "ok", made.reason
    return made.trajectory


def series(motion: Trajectory) -> np.ndarray:
    """Defects of a run, (intervals, signals)."""
    return defects(BOOK, motion, EXACT).series.distances


def test_the_exact_motion_has_none_but_rounding():
    found = defects(BOOK, EXACT, EXACT)
    assert found.series.distances.max() < 16 * EPS
    assert found.summary(INTERVALS, EPS)["omega"].floor < 64 * NOISE
    np.testing.assert_array_equal(found.t, TIMES[1:])


def test_errors_made_before_are_no_defects():
    """Another motion of the same body is exact too, however far it is from that of the scene."""
    omega = -BOOK.start.omega_body[[2, 0, 1]]
    other = started_at(BOOK, [0.0, 0.6, 0.0, 0.8], omega, np.zeros(3), np.zeros(3))
    motion = ExactMotion(other).outline(TIMES)
    assert np.abs(motion.omega_body - EXACT.omega_body).max() > np.abs(EXACT.omega_body).max()
    assert series(motion).max() < 16 * EPS
    opposite = replace(motion, q_world_body_wxyz=-motion.q_world_body_wxyz)
    np.testing.assert_array_equal(series(opposite), series(motion))


def test_defects_shrink_at_the_order_of_the_method():
    coarse, fine = (series(run(planted(HeunSession), steps)).max(axis=0) for steps in (16, 32))
    turning = ["omega", "attitude", "angular_momentum"]
    for name, ratio in zip(turning, coarse[:3] / fine[:3], strict=True):
        assert ratio == pytest.approx(2**METHOD.order, rel=0.1), name


def test_a_fault_is_seen_in_the_intervals_in_which_it_acts():
    late = defects(BOOK, run(planted(SpunUpFromHalfwaySession), 64), EXACT)
    honest = series(run(planted(HeunSession), 64)).max()
    of_omega = late.series["omega"]
    early = late.t <= HALFWAY
    assert of_omega[early].max() <= honest
    # In an interval the spin grows by 1e-2 of itself a second.
    assert of_omega[~early].min() == pytest.approx(1e-2 * TIMES[1], rel=0.5)
    summary = late.summary(64 * INTERVALS, EPS)["omega"]
    assert summary.at > HALFWAY
    assert summary.p50 <= summary.p95 <= summary.max == of_omega.max()


def test_the_floor_grows_with_roundings_and_their_size():
    found = defects(BOOK, EXACT, EXACT)
    floors = [
        found.summary(steps, ulp)["omega"].floor
        for steps, ulp in [(INTERVALS, EPS), (10_000 * INTERVALS, EPS), (INTERVALS, 2.0**-23)]
    ]
    assert floors[1] / floors[0] == pytest.approx(100, rel=0.5)
    assert floors[2] / floors[0] == pytest.approx(2.0**-23 / NOISE)


def test_a_motion_of_too_many_turns_is_not_followed():
    far = library_scene("million-turns")
    times = far.times[:4]
    exact = ExactMotion(far).outline(times)
    assert defects(far, exact, exact) is None
    assert defects(BOOK, EXACT.until(1), EXACT) is None


def test_the_error_a_turn_is_of_the_time_in_which_a_body_moves():
    """One that stops after a third of the window errs as much a turn as one that goes on."""
    going = run(planted(HeunSession), 16)
    stops = INTERVALS // 3
    kept = np.minimum(np.arange(INTERVALS + 1), stops)
    at_rest = (np.arange(INTERVALS + 1) > stops)[:, None]
    stopped = replace(
        going,
        q_world_body_wxyz=going.q_world_body_wxyz[kept],
        omega_body=np.where(at_rest, 0.0, going.omega_body),
    )
    usual = turns_made(EXACT).mean()
    before, of_stopped = (
        defects(BOOK, motion, EXACT).attitude_a_turn(motion, usual)
        for motion in (going.until(stops + 1), stopped)
    )
    assert np.median(series(stopped)[:, 1]) < LEAST_ROUNDING
    assert of_stopped == pytest.approx(before, rel=0.5)
    resting = replace(stopped, omega_body=np.zeros((INTERVALS + 1, 3)))
    assert defects(BOOK, resting, EXACT).attitude_a_turn(resting, usual) is None
