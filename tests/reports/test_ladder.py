"""Ladders come from the motion, and all rungs share their sample times."""

from itertools import pairwise

import numpy as np
import pytest
from spincheck.reports.ladder import COARSEST_TURN, MAX_STEPS, MIN_RUNGS, ladder, single
from spincheck.scenarios import Trajectory


def spinning(speed: float, duration: float = 3.0, samples: int = 31) -> Trajectory:
    times = np.linspace(0.0, duration, samples)
    q = np.tile([1.0, 0, 0, 0], (samples, 1))
    omega = np.tile([0.0, 0, speed], (samples, 1))
    return Trajectory(times, q, omega, 0 * omega, 0 * omega)


@pytest.mark.parametrize("speed", [1e-3, 1.0, 40.0, 1e4])
def test_the_coarsest_step_turns_the_body_no_further_than_it_should(speed):
    assert ladder(spinning(speed))[0].timestep * speed <= COARSEST_TURN * (1 + 1e-12)


@pytest.mark.parametrize("speed", [1e-3, 7.0, 40.0])
def test_every_rung_is_sampled_at_the_same_times_to_the_last_bit(speed):
    rungs = ladder(spinning(speed))
    times = [rung.sample_steps * rung.timestep for rung in rungs]
    assert all(np.array_equal(times[0], other) for other in times)


def test_samples_are_those_of_the_window():
    truth = spinning(7.0)
    rung = ladder(truth)[0]
    assert np.allclose(rung.sample_steps * rung.timestep, truth.t, rtol=1e-15)


def test_timesteps_are_halved_exactly():
    rungs = ladder(spinning(40.0))
    assert all(b.timestep == a.timestep / 2 for a, b in pairwise(rungs))


def test_the_budget_of_steps_is_used_and_kept():
    finest = ladder(spinning(40.0))[-1].steps
    assert MAX_STEPS / 2 < finest <= MAX_STEPS


def test_a_fast_spin_still_has_enough_rungs_for_a_trend():
    assert len(ladder(spinning(1e8))) == MIN_RUNGS


def test_a_single_timestep_is_sampled_at_the_nearest_whole_steps():
    rung = single(0.007, np.linspace(0, 1, 11))
    assert rung.sample_steps.tolist() == [0, 14, 29, 43, 57, 71, 86, 100, 114, 129, 143]


def test_a_timestep_longer_than_the_window_is_refused():
    with pytest.raises(ValueError, match="'timestep' must be shorter than the window"):
        single(3.0, np.linspace(0, 1, 11))
