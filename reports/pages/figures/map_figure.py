"""A map as a figure: one panel a method on common axes, colour the error of ω, lines by theory."""

import math
from collections.abc import Iterator, Sequence
from html import escape
from typing import Any

import numpy as np

from ....scenarios import FloatArray
from ....scenarios.vary import TIMESTEP
from ...results.records import Pair, Row
from ..analysis.map_grid import Grid, place_of, places, with_unit
from ..analysis.measures import FIRST, HORIZON, Mark, is_coloured, marks
from ..analysis.wording import ended, number, power_of_ten
from .map_axes import cell_side, columns_of, edges, panels
from .map_bounds import Bound, bounds_of
from .plot import GROUND, INK, Figure, Trace, axis_suffix, packed

#: Perceptually uniform, and the same to all kinds of colour vision (Nathaniel Smith & Stéfan van
#: der Walt, matplotlib 2.0): equal ratios of errors look equally far apart.
COLOURS = "Viridis"
#: Upper end of the colour scale: an error of 1 is as large as the motion itself.
NOTHING_RIGHT = 1.0
#: Size of a sign, as a fraction of the smaller side of a cell, and its limits in px.
SIGN_PART, SMALLEST_SIGN, LARGEST_SIGN = 0.62, 3.0, 8.0
#: Largest number of points with full hover texts; for more, the page would have many megabytes, and
#: the pointer shows only the error or the meaning of the sign.
MOST_HOVER_TEXTS = 1600
LINE_WIDTH, CASING_WIDTH, LABEL_SIZE = 1.6, 4.0, 10


def map_figure(grid: Grid) -> Figure:
    """All methods of a map."""
    signs = marks(grid.result.points)
    legend = _legend(grid, signs)
    traces = [*legend]
    labels: list[dict[str, Any]] = []
    cell = cell_side(grid.shape, columns_of(len(grid.methods)))
    for k, pair in enumerate(grid.methods, start=1):
        traces += _errors(grid, pair, k)
        traces += _signs(grid, pair, k, signs, cell)
        traces += _lines(grid, pair, k)
        labels += _labels(grid, pair, k)
    made = panels(grid, len(legend))
    made["coloraxis"] = _colour_axis(_least(grid))
    made["annotations"] += labels
    return {"data": traces, "layout": made}


def _least(grid: Grid) -> float:
    """Lower end of the colour scale: a power of ten below all errors, not below the uncertainty."""
    errors = [_claimed(point) for point in grid.result.points if is_coloured(point)]
    positive = [error for error in errors if 0 < error < math.inf]
    return float(math.floor(math.log10(min(positive, default=1e-1))))


def _claimed(point: Row) -> float:
    assert point.errors is not None
    return max(point.errors.omega, point.reference_uncertainty)


def _colour_axis(low: float) -> dict[str, Any]:
    high = math.log10(NOTHING_RIGHT)
    low = min(low, high - 1)
    step = max(1, math.ceil((high - low) / 8))
    ticks = list(range(int(high), int(low) - 1, -step))
    return {
        "colorscale": COLOURS,
        "cmin": low,
        "cmax": high,
        "colorbar": {
            "title": {"text": "ω error,<br>relative", "side": "top"},
            "tickvals": ticks,
            "ticktext": [f"≥ {NOTHING_RIGHT:g}" if k == high else power_of_ten(k) for k in ticks],
            "thickness": 14,
            "outlinewidth": 0,
            "x": 1.012,
            "xpad": 0,
        },
    }


def _errors(grid: Grid, pair: Pair, k: int) -> Iterator[Trace]:
    shown = {n: point for n, point in grid.points[pair].items() if is_coloured(point)}
    if not shown:
        return
    values = np.full(grid.shape, math.nan)
    texts = [[""] * grid.shape[1] for _ in range(grid.shape[0])]
    for (row, column), point in shown.items():
        error = _claimed(point)
        values[row, column] = math.log10(error) if 0 < error < math.inf else math.nan
        texts[row][column] = _hover_text(grid, point)
    across, up = grid.axes
    yield {
        "type": "heatmap",
        "x": packed(edges(across)),
        "y": packed(edges(up)),
        "z": _packed_grid(values),
        "text": texts,
        "hovertemplate": _hover(pair),
        "hoverongaps": False,
        "coloraxis": "coloraxis",
        "xaxis": f"x{axis_suffix(k)}",
        "yaxis": f"y{axis_suffix(k)}",
        "showlegend": False,
    }


def _signs(grid: Grid, pair: Pair, k: int, signs: dict[Any, Mark], cell: float) -> Iterator[Trace]:
    size = min(max(SIGN_PART * cell, SMALLEST_SIGN), LARGEST_SIGN)
    by_mark: dict[Mark, list[Row]] = {}
    for point in grid.points[pair].values():
        if not is_coloured(point):
            by_mark.setdefault(signs[point.outcome, point.cause], []).append(point)
        elif grid.is_cut(point):
            by_mark.setdefault(HORIZON, []).append(point)
    across, up = grid.axes
    for mark, points in by_mark.items():
        yield {
            "type": "scatter",
            "mode": "markers",
            "x": packed(np.array([place_of(across, grid.result.at(one)[0]) for one in points])),
            "y": packed(np.array([place_of(up, grid.result.at(one)[1]) for one in points])),
            "marker": _marker(mark, SMALLEST_SIGN if mark is HORIZON else size),
            "text": [_hover_text(grid, point) for point in points],
            "hovertemplate": _hover(pair),
            "xaxis": f"x{axis_suffix(k)}",
            "yaxis": f"y{axis_suffix(k)}",
            "showlegend": False,
        }


def _marker(mark: Mark, size: float) -> dict[str, Any]:
    return {
        "symbol": mark.symbol,
        "size": size,
        "color": mark.colour,
        "line": {"color": mark.colour, "width": 1.2},
    }


def _hover_text(grid: Grid, point: Row) -> str:
    """The hover text of a point, below the method's name."""
    if math.prod(grid.shape) > MOST_HOVER_TEXTS:
        return f"ω error {_claimed(point):.0e}" if is_coloured(point) else escape(_ended(point))
    at = (
        with_unit(axis, value) for axis, value in zip(grid.axes, grid.result.at(point), strict=True)
    )
    chosen = not any(axis.path == TIMESTEP for axis in grid.axes) and point.timestep
    said = FIRST if point.errors else ()
    lines = [
        ", ".join(at) + (f", timestep {point.timestep:.4g} s" if chosen else ""),
        *(f"{one.title}: {number(n)}" for one in said if (n := one.of(point)) is not None),
        "the reference is known no further" if grid.is_cut(point) else "",
        "" if point.outcome == "ok" else _ended(point),
        point.reason,
    ]
    return "<br>".join(escape(line) for line in lines if line)


def _hover(pair: Pair) -> str:
    return f"{escape(' '.join(pair))}<br>%{{text}}<extra></extra>"


def _ended(point: Row) -> str:
    return ended(point) + (f" ({point.cause})" if point.cause else "")


def drawn_bounds(grid: Grid, pair: Pair) -> list[tuple[Bound, FloatArray, FloatArray]]:
    """The bounds that cross a method's panel, the values whose zeros they are, and points of them.

    The points, (n, 2), are in the coordinates of the axes, from left to right.
    """
    x, y = (places(axis) for axis in grid.axes)
    drawn = []
    for bound in bounds_of(grid.methods[pair], grid.stock_timesteps.get(pair[0])):
        values = grid.evaluated(bound.value)
        points = np.vstack([_crossings(x, y, values), _crossings(y, x, values.T)[:, ::-1]])
        if len(points):
            drawn.append((bound, values, points[np.lexsort(points.T[::-1])]))
    return drawn


def _crossings(x: FloatArray, y: FloatArray, values: FloatArray) -> FloatArray:
    """Where linear interpolation along y between neighbouring nodes is zero, (n, 2)."""
    low, high = values[:-1], values[1:]
    rows, columns = at = np.nonzero(((low < 0) != (high < 0)) & np.isfinite(low + high))
    part = low[at] / (low[at] - high[at])
    return np.column_stack([x[columns], y[rows] + part * np.diff(y)[rows]])


def _lines(grid: Grid, pair: Pair, k: int) -> Iterator[Trace]:
    """Lines visible on every colour: in the text's colour, on broader ones in the page's."""
    across, up = (places(axis) for axis in grid.axes)
    for bound, values, _ in drawn_bounds(grid, pair):
        for colour, width, dash in ((GROUND, CASING_WIDTH, "solid"), (INK, LINE_WIDTH, bound.dash)):
            yield {
                "type": "contour",
                "x": packed(across),
                "y": packed(up),
                "z": _packed_grid(values),
                "autocontour": False,
                "contours": {"coloring": "none", "start": 0, "end": 0, "size": 1},
                "line": {"color": colour, "width": width, "dash": dash},
                "hoverinfo": "skip",
                "xaxis": f"x{axis_suffix(k)}",
                "yaxis": f"y{axis_suffix(k)}",
                "showscale": False,
                "showlegend": False,
            }


def _labels(grid: Grid, pair: Pair, k: int) -> Iterator[dict[str, Any]]:
    """A word on each line: on the first a small part of the way along it, on the last a large one.

    So lines that cross or run together have their words apart.
    """
    drawn = drawn_bounds(grid, pair)
    for rank, (bound, _, points) in enumerate(drawn, start=1):
        x, y = points[rank * len(points) // (len(drawn) + 1)].tolist()
        yield {
            "text": bound.label,
            "x": x,
            "y": y,
            "xref": f"x{axis_suffix(k)}",
            "yref": f"y{axis_suffix(k)}",
            "showarrow": False,
            "font": {"size": LABEL_SIZE, "color": INK},
            "bgcolor": GROUND,
            "opacity": 0.9,
            "borderpad": 1,
        }


def _packed_grid(values: FloatArray) -> dict[str, str]:
    return packed(values) | {"shape": ", ".join(map(str, values.shape))}


def _legend(grid: Grid, signs: dict[Any, Mark]) -> list[Trace]:
    """Legend entries for every sign and every kind of line in the panels."""
    nowhere: dict[str, Any] = {
        "type": "scatter",
        "x": [None],
        "y": [None],
        "hoverinfo": "skip",
        "showlegend": True,
    }
    shown = [*signs.values(), *([HORIZON] if any(map(grid.is_cut, grid.result.points)) else [])]
    dashes = {bound.label: bound.dash for bound in legend_of_bounds(grid)}
    return [
        nowhere
        | {"mode": "markers", "marker": _marker(mark, LARGEST_SIGN), "name": escape(mark.label)}
        for mark in shown
    ] + [
        nowhere
        | {"mode": "lines", "line": {"color": INK, "width": LINE_WIDTH, "dash": dash}, "name": name}
        for name, dash in dashes.items()
    ]


def legend_of_bounds(grid: Grid) -> Sequence[Bound]:
    """Legend entries of the lines, each once."""
    by_meaning: dict[str, Bound] = {}
    for pair in grid.methods:
        by_meaning |= {bound.meaning: bound for bound, *_ in drawn_bounds(grid, pair)}
    return list(by_meaning.values())
