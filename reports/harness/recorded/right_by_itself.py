"""Logs of which the attitudes, ω, or the states at other times, are the scene's by themselves."""

import numpy as np
from scipy.special import chdtrc, chdtri

from ....reference.following import follow
from ....scenarios import FloatArray
from ....scenarios.rotation import norms
from ..explaining.search import LEFT, LEVEL
from .clamps import TINY
from .columns import EACH, SATURATES
from .digits import where
from .intervals import apart
from .log import Log

#: Part of the distance of samples by which a state is followed to see where it leads.
SMALL = 1e-3
#: Standard deviations of noise that the rates differ by, at most, which a gyroscope saturates at.
SATURATED = 2.0
#: That attitudes, or ω, alone are the scene's.
ATTITUDE_ALONE = "the attitudes are those of the scene, but the recorded ω is not"
OMEGA_ALONE = "ω is that of the scene, but the attitudes are not"


def uneven_times(log: Log, unchanged: FloatArray) -> list[str]:
    """Return the sentence that each state is the scene's at another time, within noise, if it is.

    By how much each is late is fitted, as if the motion were straight for so long. Noise that is
    not stated is no noise if nearly all of it is along the motion.

    Parameters
    ----------
    unchanged : what the scene's own equations leave of the log, in units of its noise, (m,)
    """
    (made,) = log.made([log.base], log.t)
    small = SMALL * float(np.median(np.diff(log.t)))
    later = follow(log.base.equations, made, np.full((len(made), 1), small))[:, 0]
    slopes = (apart(made, later) / np.repeat(log.noise, 3))[:, : log.measured] / small
    rest = unchanged.reshape(len(made), -1)
    late = np.sum(slopes * rest, axis=1) / np.maximum(np.sum(slopes**2, axis=1), TINY)
    left = rest - late[:, None] * slopes
    before, after = float(np.sum(rest**2)), float(np.sum(left**2))
    # Where all are late alike, it is no matter of each time.
    is_even = abs(float(np.mean(late))) > float(np.std(late))
    is_noise = is_even or bool(chdtrc(rest.size, before) > LEVEL)
    is_along = bool(chdtrc(rest.size - len(late), after) > LEVEL)
    if not log.is_stated:
        is_noise, is_along = is_even, after < LEFT**2 * before
    if is_noise or not is_along:
        return []
    return [
        f"the times are off by {float(np.std(late)):.2g} s, standard deviation, and by "
        f"{float(np.abs(late).max()):.2g} s at most: each state is the scene's of such a time"
    ]


def right_by_itself(log: Log, unchanged: FloatArray) -> list[str]:
    """Return the sentence that either attitude or ω is the scene's, within noise, if one is.

    If less than half of the samples of the other are off, it says which. The parameters are those
    of `uneven_times`.
    """
    if not log.has_omega:
        return []
    squares = log.squares(unchanged)
    is_right = chdtrc(3 * len(log.t), squares) > LEVEL
    if is_right.all() or not is_right.any():
        return []
    words, wrong = (ATTITUDE_ALONE, 1) if is_right[0] else (OMEGA_ALONE, 0)
    each = norms(unchanged.reshape(-1, 3)).reshape(-1, 2)[:, wrong]
    samples = np.flatnonzero(each**2 > chdtri(3, LEVEL / len(each)))
    if bound := _saturates_at(log, unchanged) if is_right[0] else 0.0:
        words += f": {SATURATES.format(EACH, bound, np.degrees(bound))}"
    if 0 < 2 * len(samples) < len(each):
        off = float(log.noise[wrong] * each.max())
        size = f"{off:.3g} rad/s" if wrong else f"{np.degrees(off):.3g}°"
        words += f" {where(log.t, samples)}, by up to {size}"
    return [words]


def _saturates_at(log: Log, unchanged: FloatArray) -> float:
    """Return the rate, rad/s, that is recorded where the exact ω is faster; 0 if none is."""
    omega, noise = log.states[:, 4:], log.noise[1]
    rest = unchanged.reshape(-1, 2, 3)[:, 1]
    is_off = rest**2 > chdtri(1, LEVEL / rest.size)
    speeds, is_slower = np.abs(omega[is_off]), rest[is_off] * omega[is_off] < 0
    is_cut = len(speeds) > 1 and is_slower.all() and np.std(speeds) < SATURATED * noise
    return float(np.mean(speeds)) if is_cut else 0.0
