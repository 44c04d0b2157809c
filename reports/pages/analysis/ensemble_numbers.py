"""Statistics of a method over an ensemble: which members finished, and their errors."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from ....scenarios import FloatArray
from ...results.records import Pair
from ...results.sweep_records import PlacedRow
from .map_marks import is_coloured
from .measures import FIRST, Measure

#: Quantiles that are shown, as order statistics: each is the error of some member.
QUANTILES = {"p50": 0.5, "p95": 0.95, "p99": 0.99, "largest": 1.0}
ATTITUDE, OMEGA, *_ = FIRST


@dataclass(frozen=True, eq=False)
class Members:
    """The members that a method was run on.

    Attributes
    ----------
    points : in the members' order; members that it cannot simulate are left out
    """

    pair: Pair
    points: tuple[PlacedRow, ...]

    @property
    def finished(self) -> tuple[PlacedRow, ...]:
        """The members whose runs finished."""
        return tuple(point for point in self.points if is_coloured(point))

    def errors(self, measure: Measure) -> FloatArray:
        """A measure of the finished members, ascending."""
        return _known(measure, self.finished)

    def quantiles(self, measure: Measure) -> tuple[float | None, ...] | None:
        """The values at `QUANTILES`, from the best member to the worst; None without any.

        One is None where it would be the largest itself: p99 needs 100 members.
        """
        values = _known(measure, self.points)
        if not len(values):
            return None
        sign = -1 if measure.more_is_better else 1
        shares = list(QUANTILES.values())
        found = sign * np.quantile(sign * values, shares, method="inverted_cdf")
        is_own = [q in (0.5, 1.0) or math.ceil(q * len(values)) < len(values) for q in shares]
        return tuple(float(v) if own else None for v, own in zip(found, is_own, strict=True))

    def worst(self, count: int) -> tuple[PlacedRow, ...]:
        """The worst members: those that did not finish, earliest first, then by the error of ω."""
        return tuple(sorted(self.points, key=_badness)[:count])


def _known(measure: Measure, points: Iterable[PlacedRow]) -> FloatArray:
    values = (measure.of(point) for point in points)
    return np.sort(np.array([value for value in values if value is not None], dtype=float))


def _badness(point: PlacedRow) -> tuple[int, float]:
    if is_coloured(point):
        return 1, -(OMEGA.of(point) or 0.0)
    return 0, point.stopped_at if point.stopped_at is not None else 0.0


def members_of(points: Iterable[PlacedRow], pairs: Iterable[Pair]) -> list[Members]:
    """Sorted by method; members that an engine cannot simulate, or was not run on, are left out."""
    run = [point for point in points if point.simulated]
    return [Members(pair, tuple(point for point in run if point.pair == pair)) for pair in pairs]
