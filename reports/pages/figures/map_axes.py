"""Layout of a map's panels on common axes: positions, ticks, and edges of cells."""

import math
from collections.abc import Iterator
from html import escape
from typing import Any

import numpy as np

from ....scenarios import FloatArray
from ....scenarios.vary import Axis
from ..analysis.map_grid import Grid, axis_title, places
from .plot import Panel, axis_suffix, layout

#: Panels side by side, px high, and the px around them for titles, legend and colour bar.
ACROSS, PANEL_HEIGHT = 4, 215
ABOVE, BELOW, LEFT, RIGHT = 36, 62, 66, 92
#: A line of the legend, px, and the entries that one holds.
LEGEND_LINE, LEGEND_ACROSS = 20, 4
GAP_ACROSS, GAP_DOWN = 0.022, 44
#: px, the page width that is assumed.
WIDTH = 1216


def panels(grid: Grid, entries: int) -> dict[str, Any]:
    """Layout with a panel for each method, above a legend of so many entries."""
    count = len(grid.methods)
    columns = columns_of(count)
    below = BELOW + LEGEND_LINE * math.ceil(entries / LEGEND_ACROSS)
    panel_titles = list(titles(grid, count, columns))
    made = layout(
        [
            Panel(x_title, y_title, escape(" ".join(pair)), domain=area)
            for pair, area, (x_title, y_title) in zip(
                grid.methods, domains(count, columns), panel_titles, strict=True
            )
        ],
        ABOVE + below + _inside(count, columns),
    )
    for k, outer in enumerate(panel_titles, start=1):
        for letter, axis, title in zip("xy", grid.axes, outer, strict=True):
            made[f"{letter}axis{axis_suffix(k)}"] |= shared(axis, bool(title))
            if k > 1:
                made[f"{letter}axis{axis_suffix(k)}"]["matches"] = letter
    made["margin"] = {"l": LEFT, "r": RIGHT, "t": ABOVE, "b": below}
    made["legend"] = {
        "orientation": "h",
        "yref": "container",
        "y": 0,
        "yanchor": "bottom",
        "x": 0,
        "itemclick": False,
        "itemdoubleclick": False,
    }
    return made


def columns_of(count: int) -> int:
    """Number of panels side by side."""
    return min(ACROSS, count)


def cell_side(shape: tuple[int, int], columns: int) -> float:
    """The smaller side of a cell, px, of a map of so many rows and columns of cells."""
    rows, across = shape
    panel = (WIDTH - LEFT - RIGHT) * (1 - GAP_ACROSS * (columns - 1)) / columns
    return min(panel / across, PANEL_HEIGHT / rows)


def _inside(count: int, columns: int) -> int:
    """Height of that many panels with the gaps between them, px."""
    rows = math.ceil(count / columns)
    return rows * PANEL_HEIGHT + (rows - 1) * GAP_DOWN


def domains(count: int, columns: int) -> Iterator[tuple[tuple[float, float], tuple[float, float]]]:
    """Left and right, bottom and top of each panel, in fractions of the figure."""
    wide = (1 - GAP_ACROSS * (columns - 1)) / columns
    inside = _inside(count, columns)
    for k in range(count):
        row, column = divmod(k, columns)
        left = column * (wide + GAP_ACROSS)
        top = 1 - row * (PANEL_HEIGHT + GAP_DOWN) / inside
        bottom = max(top - PANEL_HEIGHT / inside, 0.0)
        yield (left, min(left + wide, 1.0)), (bottom, min(top, 1.0))


def titles(grid: Grid, count: int, columns: int) -> Iterator[tuple[str, str]]:
    """Titles of the axes at the outer panels, nothing at the others."""
    across, up = (escape(axis_title(axis)) for axis in grid.axes)
    for k in range(count):
        yield across if k + columns >= count else "", up if k % columns == 0 else ""


def shared(axis: Axis, outer: bool) -> dict[str, Any]:
    """Settings that the panels' axes share; only the outer ones show numbers."""
    outermost = edges(axis)
    return {
        "range": [float(outermost[0]), float(outermost[-1])],
        "showticklabels": outer,
        "showgrid": False,
        **_ticks(axis),
    }


def _ticks(axis: Axis) -> dict[str, Any]:
    """Ticks at powers of ten if the coordinate is an exponent; else Plotly's own."""
    if not axis.logarithmic:
        return {}
    low, high = math.log10(axis.values[0]), math.log10(axis.values[-1])
    # One tick for each decade, more if there are less than two decades.
    digits = (1,) if high - low >= 2 else (1, 2, 5)
    values = [
        (power + math.log10(digit), digit * 10.0**power)
        for power in range(math.floor(low), math.ceil(high) + 1)
        for digit in digits
    ]
    inside = [(at, value) for at, value in values if low - 1e-9 <= at <= high + 1e-9]
    return {
        "tickmode": "array",
        "tickvals": [at for at, _ in inside],
        "ticktext": [f"{value:g}" for _, value in inside],
    }


def edges(axis: Axis) -> FloatArray:
    """Where cells meet: halfway between values, and as far beyond the outermost."""
    at = places(axis)
    middles = (at[1:] + at[:-1]) / 2
    return np.concatenate([[2 * at[0] - middles[0]], middles, [2 * at[-1] - middles[-1]]])
