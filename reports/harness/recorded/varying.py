"""Whether one number of the equations changes in time, as where a torque comes late.

The number is fitted to each interval of a recording by itself.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.special import chdtri

from ....scenarios import FloatArray
from ...results.change_words import KINDS
from ..explaining.fit import NOT_FINITE
from ..explaining.hypothesis import Change
from ..explaining.search import LEFT, LEVEL, SAME, largest_of_noise
from .intervals import Intervals

#: Steps of a fit, and the step of a scaled number from which a slope is taken.
STEPS, SMALL = 3, 1e-5
#: Changes are fitted that leave no more than this fraction in one step; and so many may explain
#: the same motion, at most, for them to be named.
PROMISING, MOST_ALIKE = 0.5, 2
#: Least correlation of ranks with time at which a number is said to go one way.
ONE_WAY = 0.9
#: Numbers closer to the scene's than this, in sizes, are its own.
OWN = 1e-3


class Varying(NamedTuple):
    """A number that changes in time, in words, and what is left with it, (S, 6)."""

    words: str
    rest: FloatArray


def varying(data: Intervals, changes: Sequence[Change], among: int) -> Varying | None:
    """Return the number that, changing in time, explains a motion; None if none does.

    Parameters
    ----------
    changes : of which each has one number or more; those with one are tried
    among : how many changes have been tried already
    """
    single = [one for one in changes if len(one.scales) == 1]
    (unchanged,) = data.deviations([data.base])
    count = unchanged.size
    enough = max(largest_of_noise(count), LEFT**2 * float(np.mean(unchanged**2)))
    by_chance = float(chdtri(len(unchanged), LEVEL / (among + len(single))))
    # No method's error, and no chance, makes one number explain all six of an interval so well.
    exactly = SAME**2 * float(np.mean(unchanged**2))
    parts = [data.rows([k]) for k in range(len(unchanged))]
    found = []
    for change in single:
        numbers, rest = _fit(data, parts, change, unchanged)
        left = float(np.mean(rest**2))
        is_seen = left <= exactly or data.chi2_decrease(unchanged, rest) > by_chance
        if left <= enough and is_seen:
            found.append((left, change, numbers, rest))
    best = min((left for left, *_ in found), default=0.0)
    near = min(1.0, exactly) if best <= exactly else 1.0
    alike = [one for one in found if one[0] <= max(near, best / LEFT)]
    if not 0 < len(alike) <= MOST_ALIKE:
        return None
    words = ", or ".join(_in_words(data.t, *one[1:3]) for one in alike)
    return Varying(f"it moves as if {words}", min(alike, key=lambda one: one[0])[3])


def _fit(
    data: Intervals, parts: Sequence[Intervals], change: Change, unchanged: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the number of each interval, (S,), and what is left with them, (S, 6)."""
    numbers, size = np.zeros(len(parts)), float(change.scales[0])
    both = [change.apply(data.base, np.array([step * size])) for step in (0, SMALL)]
    rest, stepped = _clipped(data.deviations(both))
    slopes = (stepped - rest) / SMALL
    for _ in range(STEPS):
        squares = np.maximum(np.sum(slopes**2, axis=1), 1 / NOT_FINITE)
        numbers = numbers - size * np.sum(slopes * rest, axis=1) / squares
        rest = _off(parts, change, numbers)
        if np.mean(rest**2) > PROMISING * np.mean(unchanged**2):
            break
    return numbers, rest


def _off(parts: Sequence[Intervals], change: Change, numbers: FloatArray) -> FloatArray:
    """Return what is left of each interval with its own number, (S, 6)."""
    off = [
        part.deviations([change.apply(part.base, number[None])])[0]
        for part, number in zip(parts, numbers, strict=True)
    ]
    return _clipped(np.vstack(off))


def _clipped(off: FloatArray) -> FloatArray:
    """Return what is left, with `NOT_FINITE` in place of what is larger or no number."""
    return np.clip(np.nan_to_num(off, nan=NOT_FINITE), -NOT_FINITE, NOT_FINITE)


def _in_words(t: FloatArray, change: Change, numbers: FloatArray) -> str:
    """Return in words how a change's number varies with time, or that it is the same throughout.

    Parameters
    ----------
    t : when each number was found, s, (S,)
    numbers : (S,)
    """
    same = {_of(change, number) for number in numbers}
    if len(same) == 1:
        return same.pop()
    splits = [_spread(numbers[:k]) + _spread(numbers[k:]) for k in range(1, len(numbers))]
    k = 1 + int(np.argmin(splits))
    before, after = np.median(numbers[:k]), np.median(numbers[k:])
    if min(splits) <= LEFT**2 * _spread(numbers):
        words = [_of(change, before), _of(change, after)]
        return f"{words[0]} until t = {t[k - 1]:.4g} s, and from then on {words[1]}"
    ranks = numbers.argsort().argsort()
    if abs(np.corrcoef(np.arange(len(t)), ranks)[0, 1]) >= ONE_WAY:
        at = 0, len(t) // 2, len(t) - 1
        return ", ".join(f"at t = {t[i]:.4g} s {_of(change, numbers[i])}" for i in at)
    least, largest = (_of(change, one) for one in (numbers.min(), numbers.max()))
    return f"in turns {least} and {largest}, and what is between"


def _of(change: Change, number: float) -> str:
    """Return a change with one number in words, to four digits."""
    if abs(number) < OWN * change.scales[0]:
        return "all were as in the scene"
    rounded = float(f"{number:.3g}")
    return KINDS[change.kind].words(change.explanation(np.array([rounded])).numbers)


def _spread(numbers: FloatArray) -> float:
    """Return the sum of squares about the mean."""
    return float(np.sum((numbers - np.mean(numbers)) ** 2))
