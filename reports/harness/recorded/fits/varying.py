"""Finds a parameter of the equations that varies in time, such as a torque that sets in late.

The parameter is fitted to each interval between two samples by itself.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.special import chdtri

from .....scenarios import FloatArray
from ....results.change_words import KINDS
from ...explaining.fit import NOT_FINITE
from ...explaining.hypothesis import SMALL, Change
from ...explaining.search import LEFT, SAME, SIGNIFICANCE, largest_of_noise
from ..samples.intervals import Intervals

#: Number of iterations of a fit.
STEPS = 3
#: The fit of a change is continued if an iteration leaves at most this fraction of the mean square
#: of the residuals. The most changes that are named if they explain a motion equally well.
PROMISING, MOST_ALIKE = 0.5, 2
#: Least correlation of ranks with time at which a parameter is said to be monotonic.
ONE_WAY = 0.9
#: Parameters below this, in units of their scale, count as zero.
OWN = 1e-3


class Varying(NamedTuple):
    """A parameter of the equations that explains a motion because it varies in time.

    Attributes
    ----------
    words : a sentence on how it varies. If several parameters explain the motion equally well, the
        sentence says how each of them would vary
    rest : the residuals of S intervals with the best parameter, in units of `Intervals.scale`,
        (S, 6)
    """

    words: str
    rest: FloatArray


def varying(data: Intervals, changes: Sequence[Change], among: int) -> Varying | None:
    """Return the parameter that explains a motion because it varies in time; None if none does.

    It is also None if more than `MOST_ALIKE` parameters explain the motion equally well.

    Parameters
    ----------
    data : the intervals of the motion
    changes : changes of the equations, of which those with exactly one parameter are tried
    among : the number of changes that have been tried before, for Bonferroni's correction
    """
    single = [one for one in changes if len(one.scales) == 1]
    (unchanged,) = data.deviations(data.base[None])
    count = unchanged.size
    enough = max(largest_of_noise(count), LEFT**2 * float(np.mean(unchanged**2)))
    by_chance = float(chdtri(len(unchanged), SIGNIFICANCE / (among + len(single))))
    # One parameter cannot explain all six residuals of each interval so well by chance, nor if they
    # are a method's error.
    exactly = SAME**2 * float(np.mean(unchanged**2))
    parts = [data.rows([k]) for k in range(len(unchanged))]
    found = []
    for change in single:
        numbers, rest = _fit(data, parts, change, unchanged)
        square = float(np.mean(rest**2))
        decrease = data.chi2_decrease(unchanged, rest)
        if square <= enough and (square <= exactly or decrease > by_chance):
            found.append((square, change, numbers, rest))
    best = min((square for square, *_ in found), default=0.0)
    near = min(1.0, exactly) if best <= exactly else 1.0
    alike = [one for one in found if one[0] <= max(near, best / LEFT)]
    if not 0 < len(alike) <= MOST_ALIKE:
        return None
    words = ", or ".join(_in_words(data.t, *one[1:3]) for one in alike)
    return Varying(f"it moves as if {words}", min(alike, key=lambda one: one[0])[3])


def _fit(
    data: Intervals, parts: Sequence[Intervals], change: Change, unchanged: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Fit the one parameter of a change to each interval by itself.

    The iteration ends early if the mean square of the residuals exceeds `PROMISING` times that
    without the change.

    Parameters
    ----------
    data : all intervals together
    parts : the S intervals of `data`, one by one
    change : a change with one parameter
    unchanged : the residuals without the change, (S, 6)

    Returns
    -------
    The parameters of the last iteration, (S,), and the residuals with them, (S, 6)
    """
    numbers, size = np.zeros(len(parts)), float(change.scales[0])
    rest, stepped = _clip(data.deviations(change.around(data.base, data.first(change))))
    slopes = (stepped - rest) / SMALL
    for _ in range(STEPS):
        squares = np.maximum(np.sum(slopes**2, axis=1), 1 / NOT_FINITE)
        numbers = numbers - size * np.sum(slopes * rest, axis=1) / squares
        rest = _residuals(parts, change, numbers)
        if np.mean(rest**2) > PROMISING * np.mean(unchanged**2):
            break
    return numbers, rest


def _residuals(parts: Sequence[Intervals], change: Change, numbers: FloatArray) -> FloatArray:
    """Return the residuals of S intervals, (S, 6), each with its own parameter of `numbers`, (S,).

    The intervals are given one by one in `parts`.
    """
    each = change.apply(parts[0].base.repeated(len(parts)), numbers[:, None])
    residuals = [part.deviations(each[[k]])[0] for k, part in enumerate(parts)]
    return _clip(np.vstack(residuals))


def _clip(residuals: FloatArray) -> FloatArray:
    """Return residuals, limited to ± `NOT_FINITE`, with `NOT_FINITE` in place of nan."""
    return np.clip(np.nan_to_num(residuals, nan=NOT_FINITE), -NOT_FINITE, NOT_FINITE)


def _in_words(t: FloatArray, change: Change, numbers: FloatArray) -> str:
    """Return in words how a change's parameter varies with time, or its value if it is constant.

    Parameters
    ----------
    t : times of the ends of S intervals, s, (S,)
    change : a change with one parameter
    numbers : the parameter in each interval, (S,)
    """
    same = {_change_in_words(change, parameter) for parameter in numbers}
    if len(same) == 1:
        return same.pop()
    splits = [_spread(numbers[:k]) + _spread(numbers[k:]) for k in range(1, len(numbers))]
    k = 1 + int(np.argmin(splits))
    before, after = np.median(numbers[:k]), np.median(numbers[k:])
    if min(splits) <= LEFT**2 * _spread(numbers):
        words = [_change_in_words(change, before), _change_in_words(change, after)]
        return f"{words[0]} until t = {t[k - 1]:.4g} s, and from then on {words[1]}"
    ranks = numbers.argsort().argsort()
    if abs(np.corrcoef(np.arange(len(t)), ranks)[0, 1]) >= ONE_WAY:
        at = 0, len(t) // 2, len(t) - 1
        return ", ".join(f"at t = {t[i]:.4g} s {_change_in_words(change, numbers[i])}" for i in at)
    least, largest = (_change_in_words(change, one) for one in (numbers.min(), numbers.max()))
    return f"in turns {least} and {largest}, and what is between"


def _change_in_words(change: Change, parameter: float) -> str:
    """Return in words what a change makes different from the scene, given its one parameter.

    The words name the parameter, to three digits. If the parameter is nearly zero, they say that
    all was as in the scene.
    """
    if abs(parameter) < OWN * change.scales[0]:
        return "all were as in the scene"
    rounded = float(f"{parameter:.3g}")
    return KINDS[change.kind].words(change.explanation(np.array([rounded])).numbers)


def _spread(numbers: FloatArray) -> float:
    """Return the sum of the squares of the deviations of numbers from their mean."""
    return float(np.sum((numbers - np.mean(numbers)) ** 2))
