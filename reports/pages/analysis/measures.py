"""Measures of runs, and their quantiles over an ensemble."""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from ....scenarios import SIGNAL, FloatArray
from ...results.records import Pair, Row

#: Factor from rad to degrees.
DEGREES = SIGNAL["attitude"].shown


@dataclass(frozen=True)
class Measure:
    """A number that is shown of each run, such as its attitude error in degrees.

    Attributes
    ----------
    title : name with its unit
    of : function that returns the number of a run; None if it is not known. A run that did not
        finish has the worst possible number, or the number of the part up to where it ended
    more_is_better : whether larger numbers are better
    """

    title: str
    of: Callable[[Row], float | None]
    more_is_better: bool = False


def _attitude(row: Row) -> float | None:
    """Return a run's attitude error, degrees; inf if it did not finish, None if unknown."""
    if row.errors is None:
        return math.inf
    off = row.errors.attitude * DEGREES
    return None if math.isnan(off) else off


def _turns(row: Row) -> float | None:
    """Return the number of turns of the motion until a run's attitude is off by 1°.

    For a run that did not finish and was never off by 1°, it is the number of turns up to its end;
    0 if not known. For a run that finished, it is inf if never off by 1°, None if not known.
    """
    if row.turns is None:
        return None if row.errors else 0.0
    if row.turns_within_1deg is not None:
        return row.turns_within_1deg
    return math.inf if row.errors else row.turns


def _a_turn(row: Row) -> float | None:
    """Return the attitude error that a turn adds, degrees; None if it is not known.

    It is inf for a run that did not finish.
    """
    if row.errors is None:
        return math.inf
    return None if row.attitude_a_turn is None else row.attitude_a_turn * DEGREES


ATTITUDE = Measure(SIGNAL["attitude"].error_title, _attitude)
TURNS = Measure("turns until the attitude is 1° off", _turns, True)
A_TURN = Measure("attitude error a turn, °", _a_turn)
#: Quantiles that are shown. Each is an order statistic: the value of one of the members.
QUANTILES = {"p50": 0.5, "p95": 0.95, "p99": 0.99, "largest": 1.0}


@dataclass(frozen=True, eq=False)
class Members:
    """The runs of one method on the members of an ensemble.

    Attributes
    ----------
    pair : engine and method
    points : the runs, in the order of the members; members that the method cannot simulate are
        left out
    """

    pair: Pair
    points: tuple[Row, ...]

    @property
    def finished(self) -> tuple[Row, ...]:
        """The runs that finished, which are those with errors."""
        return tuple(point for point in self.points if point.errors is not None)

    def errors(self, measure: Measure) -> FloatArray:
        """Return the values of a measure for the k finished runs of which it is known, (k,).

        The values are in ascending order.
        """
        return _known(measure, self.finished)

    def quantiles(self, measure: Measure) -> tuple[float | None, ...] | None:
        """Return a measure's values at `QUANTILES`, from the median to the worst.

        p95 and p99 are None if there are so few members that they are the worst value itself: p99
        needs 100 members. None is returned in place of all values if none is known.
        """
        values = _known(measure, self.points)
        if not len(values):
            return None
        sign = -1 if measure.more_is_better else 1
        shares = list(QUANTILES.values())
        found = sign * np.quantile(sign * values, shares, method="inverted_cdf")
        is_own = [q in (0.5, 1.0) or math.ceil(q * len(values)) < len(values) for q in shares]
        return tuple(float(v) if own else None for v, own in zip(found, is_own, strict=True))


def _known(measure: Measure, points: Iterable[Row]) -> FloatArray:
    """Return the values of a measure for the k runs of which it is known, ascending, (k,)."""
    values = (measure.of(point) for point in points)
    return np.sort(np.array([value for value in values if value is not None], dtype=float))


def members_of(points: Iterable[Row], pairs: Iterable[Pair]) -> list[Members]:
    """Return the runs of each method on the members of an ensemble that it can simulate.

    Parameters
    ----------
    points : the runs of all methods
    pairs : the methods, as pairs of engine and method
    """
    run = [point for point in points if point.simulated]
    return [Members(pair, tuple(point for point in run if point.pair == pair)) for pair in pairs]
