"""Finds logs of which only part is the scene's motion: attitude, ω, or all but the times."""

import numpy as np
from scipy.special import chdtrc, chdtri

from .....reference.deviations import apart
from .....reference.following import follow
from .....scenarios import FloatArray
from .....scenarios.rotation import norms
from ...explaining.search import LEFT, SIGNIFICANCE
from ..samples.clamps import TINY
from ..samples.columns import EACH, SATURATES
from ..samples.digits import where
from .log import Log

#: Step of the finite difference for rates of change, in units of the time between samples.
SMALL = 1e-3
#: Largest standard deviation of the wrong values of ω if a gyroscope saturates, in standard
#: deviations of noise.
SATURATED = 2.0
#: Sentences that the attitudes alone, or ω alone, are the scene's.
ATTITUDE_ALONE = "the attitudes are those of the scene, but the recorded ω is not"
OMEGA_ALONE = "ω is that of the scene, but the attitudes are not"


def uneven_times(log: Log, unchanged: FloatArray) -> list[str]:
    """Return a list of the sentence that each state is the exact one at another time, within noise.

    The list is empty if the states are not, or if all are late by about the same time. The time of
    each state is fitted to first order. If noise is not stated, other times must explain nearly all
    of the deviations.

    Parameters
    ----------
    log : the n samples
    unchanged : their deviations from the exact motion, in standard deviations of noise: three of
        attitude and, if it was recorded, three of ω for each sample, (6 n,) or (3 n,)
    """
    (made,) = log.made(log.base[None], log.t)
    step = SMALL * float(np.median(np.diff(log.t)))
    later = follow(log.base, made, np.full((len(made), 1), step))[:, 0]
    slopes = (apart(made, later) / np.repeat(log.noise, 3))[:, : log.measured] / step
    residuals = unchanged.reshape(len(made), -1)
    late = np.sum(slopes * residuals, axis=1) / np.maximum(np.sum(slopes**2, axis=1), TINY)
    remaining = residuals - late[:, None] * slopes
    before, after = float(np.sum(residuals**2)), float(np.sum(remaining**2))
    # If all states are late by about the same time, the times are not uneven.
    is_even = abs(float(np.mean(late))) > float(np.std(late))
    is_noise = is_even or bool(chdtrc(residuals.size, before) > SIGNIFICANCE)
    is_along = bool(chdtrc(residuals.size - len(late), after) > SIGNIFICANCE)
    if not log.is_stated:
        is_noise, is_along = is_even, after < LEFT**2 * before
    if is_noise or not is_along:
        return []
    return [
        f"the times are off by {float(np.std(late)):.2g} s, standard deviation, and by "
        f"{float(np.abs(late).max()):.2g} s at most: each state is the scene's of such a time"
    ]


def right_by_itself(log: Log, unchanged: FloatArray) -> list[str]:
    """Return a list of the sentence that only attitude, or only ω, is exact within noise.

    The list is empty if both or neither are, or if ω was not recorded. If the other quantity is
    wrong at fewer than half of all samples, the sentence names these. If ω is wrong because a
    gyroscope saturates, the sentence says so.

    Parameters
    ----------
    log : the n samples
    unchanged : their deviations from the exact motion, in standard deviations of noise: three of
        attitude and, if it was recorded, three of ω for each sample, (6 n,) or (3 n,)
    """
    if not log.has_omega:
        return []
    (squares,) = log.squares(unchanged[None])
    is_right = chdtrc(3 * len(log.t), squares) > SIGNIFICANCE
    if is_right.all() or not is_right.any():
        return []
    words, wrong = (ATTITUDE_ALONE, 1) if is_right[0] else (OMEGA_ALONE, 0)
    each = norms(unchanged.reshape(-1, 3)).reshape(-1, 2)[:, wrong]
    samples = np.flatnonzero(each**2 > chdtri(3, SIGNIFICANCE / len(each)))
    if bound := _saturates_at(log, unchanged) if is_right[0] else 0.0:
        words += f": {SATURATES.format(EACH, bound, np.degrees(bound))}"
    if 0 < 2 * len(samples) < len(each):
        deviation = float(log.noise[wrong] * each.max())
        size = f"{deviation:.3g} rad/s" if wrong else f"{np.degrees(deviation):.3g}°"
        words += f" {where(log.t, samples)}, by up to {size}"
    return [words]


def _saturates_at(log: Log, unchanged: FloatArray) -> float:
    """Return the rate, rad/s, at which a gyroscope seems to saturate; 0 if it does not.

    It does if all wrong components of ω are too small, and nearly equal in size.

    Parameters
    ----------
    log : the n samples
    unchanged : their deviations from the exact motion, in standard deviations of noise: three of
        attitude and, if it was recorded, three of ω for each sample, (6 n,) or (3 n,)
    """
    omega, noise = log.states[:, 4:], log.noise[1]
    residuals = unchanged.reshape(-1, 2, 3)[:, 1]
    is_wrong = residuals**2 > chdtri(1, SIGNIFICANCE / residuals.size)
    speeds, is_slower = np.abs(omega[is_wrong]), residuals[is_wrong] * omega[is_wrong] < 0
    is_cut = len(speeds) > 1 and is_slower.all() and np.std(speeds) < SATURATED * noise
    return float(np.mean(speeds)) if is_cut else 0.0
