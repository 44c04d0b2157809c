"""What is said of runs in numbers: measures, marks of a map's points, quantiles of an ensemble."""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from ....engines import Cause, Outcome
from ....scenarios import SIGNAL, SIGNALS, FloatArray, Signal
from ...results.records import Pair, Row

#: Degrees a rad.
DEGREES = SIGNAL["attitude"].shown


@dataclass(frozen=True)
class Measure:
    """A number of a run, as people read it.

    Attributes
    ----------
    of : the number; of a run that did not come to its end the worst there is; None if it has none
    more_is_better : whether the largest number is of the best run
    """

    name: str
    title: str
    of: Callable[[Row], float | None]
    more_is_better: bool = False


def _error_in(signal: Signal) -> Measure:
    def error(row: Row) -> float | None:
        if row.errors is None:
            return math.inf
        least = row.reference_uncertainty if signal.name == "omega" else 0.0
        size = row.errors[signal.name]
        return None if math.isnan(size) else max(size, least) * signal.shown

    return Measure(signal.name, signal.error_title, error)


def _turns(row: Row) -> float | None:
    if row.turns is None:
        return None if row.errors else 0.0
    if row.turns_within_1deg is not None:
        return row.turns_within_1deg
    return math.inf if row.errors else row.turns


def _a_turn(row: Row) -> float | None:
    if row.errors is None:
        return math.inf
    return None if row.attitude_a_turn is None else row.attitude_a_turn * DEGREES


_OF_ERRORS = {signal.name: _error_in(signal) for signal in SIGNALS}
TURNS = Measure("turns_within_1deg", "turns until the attitude is 1° off", _turns, True)
A_TURN = Measure("attitude_a_turn", "attitude error a turn, °", _a_turn)
#: Those that are shown first, and the others.
FIRST = (_OF_ERRORS["attitude"], _OF_ERRORS["omega"], TURNS, A_TURN)
MEASURES = (*FIRST, *(measure for measure in _OF_ERRORS.values() if measure not in FIRST))


#: Signs for each outcome, for its causes in alphabetical order; the last for all further causes.
SIGNS: dict[Outcome, tuple[str, ...]] = {
    "diverged": ("x-thin", "cross-thin", "asterisk", "y-up", "y-down"),
    "failed": ("square-open", "diamond-open", "triangle-up-open"),
    "unsupported": ("circle-open", "line-ne", "line-ew", "hexagon-open"),
    "ok": ("circle", "hexagon"),
}
#: Colours that stand out by 3 : 1 on white and on near-black alike.
COLOURS: dict[Outcome, str] = {
    "diverged": "#d63f4c",
    "failed": "#b04fc4",
    "unsupported": "#7d8794",
    "ok": "#9a6b3f",
}
#: What is said of points that no run was made at.
_NOT_RUN = {"scene": "no scene", "timestep": "not run: timestep"}


@dataclass(frozen=True)
class Mark:
    """A sign, and what it stands for; names as Plotly has them."""

    outcome: Outcome
    cause: str
    symbol: str
    colour: str

    @property
    def label(self) -> str:
        """As in `diverged: not finite`."""
        if self.outcome == "ok":
            return self.cause or "no error known"
        if self.outcome == "unsupported" and self.cause in _NOT_RUN:
            return _NOT_RUN[self.cause]
        return f"{self.outcome}: {self.cause}" if self.cause else self.outcome


#: On a coloured cell: the error of the part of the window in which the exact motion is known.
HORIZON = Mark("ok", "compared up to the reference's horizon", "diamond-tall", "#9a6b3f")


def is_coloured(point: Row) -> bool:
    """Whether a point has an error of a whole run."""
    return point.errors is not None


def marks(points: Iterable[Row]) -> dict[tuple[Outcome, Cause], Mark]:
    """A mark for every outcome and cause among the points that have no colour."""
    kinds = {(point.outcome, point.cause) for point in points if not is_coloured(point)}
    marks_by_end = {}
    for outcome, signs in SIGNS.items():
        causes = sorted(cause for of, cause in kinds if of == outcome)
        for k, cause in enumerate(causes):
            sign = signs[min(k, len(signs) - 1)]
            marks_by_end[outcome, cause] = Mark(outcome, cause, sign, COLOURS[outcome])
    return marks_by_end


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
    points: tuple[Row, ...]

    @property
    def finished(self) -> tuple[Row, ...]:
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

    def worst(self, count: int) -> tuple[Row, ...]:
        """The worst members: those that did not finish, earliest first, then by the error of ω."""
        return tuple(sorted(self.points, key=_badness)[:count])


def _known(measure: Measure, points: Iterable[Row]) -> FloatArray:
    values = (measure.of(point) for point in points)
    return np.sort(np.array([value for value in values if value is not None], dtype=float))


def _badness(point: Row) -> tuple[int, float]:
    if is_coloured(point):
        return 1, -(OMEGA.of(point) or 0.0)
    return 0, point.stopped_at if point.stopped_at is not None else 0.0


def members_of(points: Iterable[Row], pairs: Iterable[Pair]) -> list[Members]:
    """Sorted by method; members that an engine cannot simulate, or was not run on, are left out."""
    run = [point for point in points if point.simulated]
    return [Members(pair, tuple(point for point in run if point.pair == pair)) for pair in pairs]
