"""Ladders come from the motion, and all rungs share their sample times."""

from itertools import pairwise

import numpy as np
import pytest
from spincheck.reports.harness.timesteps.ladder import (
    COARSEST_TURN,
    EXCESS,
    LARGEST_TURN,
    LEAST_RUNGS,
    LEAST_STEPS,
    MAX_STEPS,
    MIN_RUNGS,
    Ladder,
    ladder,
    single,
)
from spincheck.scenarios import Window

#: Quotients of times, and products of them.
ROUNDING = 8 * np.finfo(float).eps


def ladder_of(
    fastest_rate: float, duration: float = 3.0, samples: int = 31, max_steps: int = MAX_STEPS
) -> Ladder:
    return ladder(Window(duration=duration, samples=samples), fastest_rate, samples, max_steps)


@pytest.mark.parametrize("fastest_rate", [1e-3, 1.0, 40.0, 1e4])
def test_the_coarsest_step_turns_the_body_no_further_than_it_should(fastest_rate):
    turn = ladder_of(fastest_rate).rungs[0].timestep * fastest_rate
    assert turn <= COARSEST_TURN * (1 + ROUNDING)


@pytest.mark.parametrize("fastest_rate", [0.0, 1e-3, 3.0, 7.0, 40.0])
def test_every_rung_is_sampled_at_the_windows_times_alike_to_the_last_bit(fastest_rate):
    """Timesteps above the ladder meet some of them."""
    whole = ladder_of(fastest_rate)
    assert np.allclose(whole.times, np.linspace(0, 3.0, 31), rtol=ROUNDING)
    assert {rung.every for rung in whole.rungs} == {1}
    assert whole.above
    for rung in [*whole.rungs, *whole.above]:
        assert np.array_equal(rung.sample_steps * rung.timestep, whole.times[:: rung.every])


def test_timesteps_are_halved_exactly_and_above_doubled_up_to_half_a_turn():
    whole = ladder_of(40.0)
    steps = [rung.timestep for rung in [*whole.above[::-1], *whole.rungs]]
    assert all(fine == coarse / 2 for coarse, fine in pairwise(steps))
    assert LARGEST_TURN / 2 < steps[0] * 40.0 <= LARGEST_TURN


@pytest.mark.parametrize("fastest_rate", [0.0, 0.01, 1.0])
def test_runs_above_are_of_enough_steps_to_show_a_blow_up(fastest_rate):
    steps = ladder_of(fastest_rate).above[-1].steps
    assert steps >= LEAST_STEPS
    assert fastest_rate or steps < 2 * LEAST_STEPS


def test_the_budget_of_steps_is_used_and_kept():
    """A small one is exceeded for a verdict, but not by much."""
    assert MAX_STEPS / 2 < ladder_of(40.0).rungs[-1].steps <= MAX_STEPS
    steps = [rung.steps for rung in ladder_of(40.0, max_steps=2000).rungs]
    assert len(steps) == LEAST_RUNGS
    assert 2000 < steps[-1] <= EXCESS * 2000
    assert len(ladder_of(40.0, max_steps=500).rungs) < LEAST_RUNGS


@pytest.mark.parametrize("fastest_rate", [2e4, 1e5])
def test_rungs_that_take_too_many_steps_are_left_out(fastest_rate):
    whole = ladder_of(fastest_rate)
    rungs = [*whole.rungs, *whole.above]
    assert len(whole.rungs) < MIN_RUNGS
    assert whole.least_steps >= 3.0 * fastest_rate / COARSEST_TURN * (1 - ROUNDING)
    assert rungs
    assert all(rung.steps <= MAX_STEPS for rung in rungs)


@pytest.mark.parametrize("fastest_rate", [1e9, 1e300, np.inf])
def test_where_nothing_fits_there_is_no_ladder_but_its_cost(fastest_rate):
    whole = ladder_of(fastest_rate)
    assert (whole.rungs, whole.above) == ((), ())
    assert whole.least_steps > MAX_STEPS
    unsampled = ladder(Window(duration=3.0, samples=31), 1.0, samples=1)
    assert (unsampled.rungs, unsampled.above, unsampled.least_steps) == ((), (), 0)


def test_windows_of_any_length_have_the_same_ladder_and_one_of_one_step_a_full_one():
    wanted = [rung.steps for rung in ladder_of(40.0, 1.0).rungs]
    for duration in (1e-12, 1e12):
        assert [rung.steps for rung in ladder_of(40.0 / duration, duration).rungs] == wanted
    whole = ladder_of(1e-3, 1e-3, samples=2)
    assert whole.rungs[0].steps == 1
    assert len(whole.rungs) > MIN_RUNGS


def test_samples_as_close_as_steps_are_thinned_to_leave_room_for_a_ladder():
    whole = ladder_of(1.0, 10.0, samples=500_001)
    assert len(whole.rungs) >= MIN_RUNGS
    assert whole.rungs[0].timestep <= COARSEST_TURN
    assert whole.times[-1] == pytest.approx(10.0, rel=1e-3)


def test_a_ladder_is_cut_where_the_exact_motion_ends():
    whole = ladder_of(3.0).until(7)
    for rung in [*whole.rungs, *whole.above]:
        assert np.array_equal(rung.sample_steps * rung.timestep, whole.times[:: rung.every])
        assert rung.steps * rung.timestep <= whole.times[-1]
    assert whole.until(1).rungs == ()


def test_a_single_timestep_is_sampled_at_the_nearest_whole_steps():
    rung = single(0.007, np.linspace(0, 1, 11))
    assert rung.sample_steps.tolist() == [0, 14, 29, 43, 57, 71, 86, 100, 114, 129, 143]
    with pytest.raises(ValueError, match="'timestep' must be shorter than the window"):
        single(3.0, np.linspace(0, 1, 11))
    with pytest.raises(ValueError, match="more steps than"):
        single(1e-12, np.linspace(0, 1e12, 11))
