"""Faults of public reports, and invented ones, are named: docs/measured/recorded-motions.md."""

import numpy as np
import pytest
from invented_faults import INVENTED, free
from planted_motions import exactly, rates_of
from reported_faults import FAULTS, FREE, TENSOR, Fault, euler, judged, named, recorded, turning

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("fault", [*FAULTS, *INVENTED], ids=lambda one: f"{one.report} {one.what}")
def test_a_planted_fault_is_named_and_no_other(fault: Fault) -> None:
    found = judged(*fault.motion(), fault.timestep)
    assert fault.is_named(named(found))
    # A known integrator that makes the scene's motion is no fault.
    assert found.is_another == (not found.made_by)


def test_a_verdict_says_of_what_order_and_timestep() -> None:
    damped = recorded(*turning(FREE, lambda R, omega: euler(TENSOR)(R, omega) - 0.1 * omega))
    found = judged(FREE, damped, 1e-4)
    assert found.is_beyond
    assert found.verdict == (
        "beyond what a method of order 1 makes of the exact motion at a timestep of 0.0001 s"
    )


@pytest.mark.parametrize("timestep", [1e-4, None])
def test_an_integrators_noise_is_none_of_a_log(timestep: float | None) -> None:
    """Interpolated states are off by some 1e-12, otherwise from each sample to the next."""
    found = judged(FREE, recorded(*turning(FREE, euler(TENSOR))), timestep)
    assert found.measured is None
    assert not found.is_another


def test_a_sample_that_is_off_is_told_from_a_jump() -> None:
    one = free(12)
    arrays = exactly(one, rates_of(one))
    arrays["omega"][90] += 0.1
    (words,) = judged(one.scenario, arrays, 1e-4).explained_by
    assert words.startswith("the sample at t = 1.8 s is off by ")
    assert words.endswith("° and 0.173 rad/s: leave it out")
    # From there on everything is turned.
    arrays = exactly(one, rates_of(one))
    arrays["q"][90:] = arrays["q"][90:, [1, 0, 3, 2]] * [-1, 1, -1, 1]
    found = judged(one.scenario, arrays, 1e-4)
    (words,) = found.explained_by
    assert words.startswith("at t = 1.8 s it jumps, by 180° and ")
    assert found.is_beyond


def test_what_jumps_at_more_than_a_tenth_of_samples_does_not_jump() -> None:
    one = free(12)
    arrays = exactly(one, rates_of(one))
    arrays["omega"][::9] += 0.1
    assert not any(
        "jumps" in words or "is off" in words
        for words in judged(one.scenario, arrays, 1e-4).explained_by
    )


def test_the_largest_of_many_noises_is_no_jump() -> None:
    """Noise as large as what a method may be off at some samples is beyond it."""
    one = free(12)
    arrays, chance = exactly(one, rates_of(one)), np.random.default_rng(5)
    of_method = judged(one.scenario, arrays, None)
    assert not of_method.is_another
    arrays["omega"] += chance.normal(0, 2e-3, arrays["omega"].shape)
    assert judged(one.scenario, arrays, None).explained_by == ()
