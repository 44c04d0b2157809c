"""Statistics of a method over an ensemble: which members finished, and their errors."""

from dataclasses import dataclass

import numpy as np

from ....scenarios import FloatArray
from ...results.records import Pair
from ...results.sweep_records import PointResult
from .map_marks import is_coloured

#: Quantiles that are shown, as order statistics: each is the error of some member.
QUANTILES = {"p50": 0.5, "p95": 0.95, "p99": 0.99, "largest": 1.0}


@dataclass(frozen=True, eq=False)
class Members:
    """The members that a method was run on.

    Attributes
    ----------
    points : in the members' order; members without a valid scene are left out
    """

    pair: Pair
    points: tuple[PointResult, ...]

    @property
    def finished(self) -> tuple[PointResult, ...]:
        """The members whose runs finished."""
        return tuple(point for point in self.points if is_coloured(point))

    def errors(self, signal: str) -> FloatArray:
        """Errors of finished members, ascending; in ω at least the reference's uncertainty."""
        errors = []
        for point in self.finished:
            assert point.errors is not None
            error = point.errors[signal]
            errors.append(max(error, point.reference_uncertainty) if signal == "omega" else error)
        return np.sort(np.array(errors, dtype=float))

    def quantiles(self, signal: str) -> tuple[float, ...] | None:
        """The errors at `QUANTILES`; infinite of a member that did not finish; None without any."""
        unfinished = len(self.points) - len(self.finished)
        errors = np.append(self.errors(signal), np.full(unfinished, np.inf))
        if not len(errors):
            return None
        shares = list(QUANTILES.values())
        return tuple(np.quantile(errors, shares, method="inverted_cdf").tolist())

    def worst(self, count: int) -> tuple[PointResult, ...]:
        """The worst members: those that did not finish, earliest first, then by the error of ω."""
        return tuple(sorted(self.points, key=_badness)[:count])


def _badness(point: PointResult) -> tuple[int, float]:
    if is_coloured(point) and point.errors is not None:
        return 1, -point.errors.omega
    return 0, point.stopped_at if point.stopped_at is not None else 0.0


def members_of(points: tuple[PointResult, ...], pairs: list[Pair]) -> list[Members]:
    """Sorted by method; members that an engine cannot simulate, or was not run on, are left out."""
    return [
        Members(
            pair,
            tuple(
                point
                for point in points
                if (point.key.engine, point.key.method) == pair
                and point.outcome in ("ok", "diverged", "failed")
            ),
        )
        for pair in pairs
    ]
