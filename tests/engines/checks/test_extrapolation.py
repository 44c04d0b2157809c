"""Limits of gains that are no power series: known no better than what finer steps show."""

import numpy as np
import pytest
from spincheck.engines.checks.extrapolation import Gains, extrapolated

#: Gains of steps of PhysX' TGS in single precision, settled on a pivot, in the largest terms: the
#: mean of four repeats and their standard deviation. Down to 0.5 s they follow a line to −4e-4,
#: which finer ones leave for 0.
MEANS = (3.0139e-3, 2.6210e-3, 1.4695e-3, 5.1561e-4, 3.4779e-5, 2.4803e-5, -8.7807e-5)
DEVIATIONS = (1.30e-4, 1.16e-4, 6.42e-5, 3.13e-5, 2.06e-5, 4.82e-5, 2.41e-5)
TIMESTEPS = 4.17 / 2.0 ** np.arange(len(MEANS))
#: Of four repeats, with a mean of 0 and a standard deviation of 1.
PATTERN = np.array([-1.0, 1.0, -1.0, 1.0])


@pytest.fixture
def gains() -> Gains:
    repeats = np.array(MEANS)[:, None] + np.outer(DEVIATIONS, PATTERN)
    values = np.zeros((len(MEANS), len(PATTERN), 1, 4, 3))
    values[..., 0, 1, 0] = repeats
    return Gains(TIMESTEPS, values, np.full((len(MEANS), 1, 4), 1e-8))


def test_a_limit_that_finer_steps_leave_is_known_no_better_than_they_are_off(gains: Gains) -> None:
    limit, known_to = extrapolated(gains)
    assert np.abs(limit).max() <= known_to[0, 1]


def test_the_limit_of_a_power_series_is_known_to_its_noise() -> None:
    """What is left at h = 0 is found, many times larger than what it is known to."""
    series = 1e-3 + 0.2 * TIMESTEPS + 0.1 * TIMESTEPS**2
    values = np.zeros((len(series), len(PATTERN), 1, 4, 3))
    values[..., 0, 1, 0] = series[:, None] + 1e-7 * PATTERN
    limit, known_to = extrapolated(Gains(TIMESTEPS, values, np.full((len(series), 1, 4), 1e-9)))
    assert abs(limit[0, 1, 0] - 1e-3) <= known_to[0, 1] <= 1e-4
