"""Limits of gains that are no power series: known no better than what finer steps show."""

import numpy as np
from spincheck.engines.checks.extrapolation import Gains, extrapolated

#: Gains of I ω, 1e-3 of the largest terms, of four repeats of a step of PhysX' TGS in single
#: precision on a top of a thousand kilometres, with timesteps halved from 4.17 s on. Down to 0.5 s
#: they follow a line to −0.6, which finer ones leave for 0.
LEAVING = [
    [-5.6435, -5.4440, -6.3379, -6.2174],
    [-3.0536, -2.9548, -3.2676, -3.2255],
    [-1.7668, -1.7216, -1.8952, -1.8796],
    [-0.6594, -0.6478, -0.7308, -0.7154],
    [-0.0234, -0.0142, -0.0568, -0.0505],
    [-0.1577, 0.0180, 0.0523, 0.0004],
    [0.1325, 0.1528, 0.1074, 0.0895],
]
TIMESTEPS = 4.17 / 2.0 ** np.arange(len(LEAVING))


def limit_of(gains: np.ndarray) -> tuple[float, float]:
    """Limit of gains of one quantity, (J, R), and what it is known to."""
    values = np.zeros((*gains.shape, 1, 4, 3))
    values[:, :, 0, 1, 0] = gains
    limit, known_to = extrapolated(Gains(TIMESTEPS, values, np.full((len(gains), 1, 4), 1e-8)))
    return float(limit[0, 1, 0]), float(known_to[0, 1])


def test_a_limit_that_finer_steps_leave_is_known_no_better_than_they_are_off() -> None:
    limit, known_to = limit_of(1e-3 * np.array(LEAVING))
    assert abs(limit) <= known_to


def test_the_limit_of_a_power_series_is_known_to_its_noise() -> None:
    series = 1e-3 + 0.2 * TIMESTEPS + 0.1 * TIMESTEPS**2
    limit, known_to = limit_of(series[:, None] + 1e-7 * np.array([-1.0, 1.0, -1.0, 1.0]))
    assert abs(limit - 1e-3) <= known_to <= 1e-2 * limit
