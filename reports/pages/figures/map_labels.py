"""Places the labels of a map's lines: on their lines, and away from each other."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from ....scenarios import FloatArray

#: Number of positions tried along a line.
TRIED = 24
#: Ratio of width to height of a panel, and of a label.
BREADTH = 1.3
#: Margin, as a fraction of a panel: a label closer to its edge would be cut.
MARGIN = 0.07
#: A label further than this from every other is far enough.
FAR_ENOUGH = 0.3


@dataclass(frozen=True)
class Placed:
    """A label in a panel, and its centre in the panel's coordinates."""

    text: str
    x: float
    y: float


def place(
    labels: Sequence[tuple[str, Sequence[FloatArray]]], spans: Sequence[tuple[float, float]]
) -> list[Placed]:
    """Choose a position for each label, as far from the previous ones as its lines allow.

    Parameters
    ----------
    labels : texts, and the curves on which each may be placed, (n, 2)
    spans : lowest and highest x, and y, of the panel
    """
    taken: list[tuple[float, float]] = []
    placed = []
    for text, curves in labels:
        longest = max(curves, key=len)
        step = max(1, len(longest) // TRIED)
        tried = [(_part(x, spans[0]), _part(y, spans[1])) for x, y in longest[::step]]
        best = max(tried, key=lambda at: _room(at, taken))
        taken.append(best)
        x, y = (low + part * (high - low) for part, (low, high) in zip(best, spans, strict=True))
        placed.append(Placed(text, x, y))
    return placed


def _part(value: float, span: tuple[float, float]) -> float:
    low, high = span
    return (float(value) - low) / (high - low)


def _room(at: tuple[float, float], taken: Sequence[tuple[float, float]]) -> tuple[bool, float]:
    """Sort key of a position: inside the margin first, then distance to the nearest label."""
    inside = all(MARGIN <= part <= 1 - MARGIN for part in at)
    nearest = min(
        (math.hypot(BREADTH * (at[0] - x) / 2, at[1] - y) for x, y in taken), default=FAR_ENOUGH
    )
    return inside, min(nearest, FAR_ENOUGH)
