"""Marks of the points of a map that have no error to colour them by.

Colour shows the error of runs that finished. Everything else is a sign on the bare page, so that it
is distinguishable without colours.
"""

from collections.abc import Iterable
from dataclasses import dataclass

from ....engines import Cause, Outcome
from ...results.sweep_records import PlacedRow

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


def is_coloured(point: PlacedRow) -> bool:
    """Whether a point has an error of a whole run."""
    return point.outcome == "ok" and point.errors is not None


def marks(points: Iterable[PlacedRow]) -> dict[tuple[Outcome, Cause], Mark]:
    """A mark for every outcome and cause among the points that have no colour."""
    kinds = {(point.outcome, point.cause) for point in points if not is_coloured(point)}
    marks_by_end = {}
    for outcome, signs in SIGNS.items():
        causes = sorted(cause for of, cause in kinds if of == outcome)
        for k, cause in enumerate(causes):
            sign = signs[min(k, len(signs) - 1)]
            marks_by_end[outcome, cause] = Mark(outcome, cause, sign, COLOURS[outcome])
    return marks_by_end
