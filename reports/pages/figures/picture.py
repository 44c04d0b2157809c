"""Figures as files (SVG, PNG, PDF): matplotlib draws what the report's pages show.

matplotlib is an optional dependency; without it the import of this module fails.
"""

import base64
import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Canvas

from ....scenarios import FloatArray
from .plot import GROUND, INK, WIRE, Figure, Trace, axis_suffix

#: Size, in inches, of one of several figures side by side; pixels an inch of a PNG.
WIDTH, PIXELS_AN_INCH = 6.4, 150
#: Parts of a figure beside each other, at most.
MOST_COLUMNS = 3
#: Inches, of an entry of the legend.
LEGEND_WIDTH = 2.4
#: Of a page's pixels.
PAGE_PIXELS_AN_INCH = 100
COLOURS = {INK: "#1b1f24", WIRE: "#c3c9d0", GROUND: "#ffffff"}
DASHES: dict[str, Any] = {
    "solid": "-",
    "dash": "--",
    "dot": ":",
    "dashdot": "-.",
    "longdash": (0, (8, 3)),
}
MARKERS = {
    "circle": "o",
    "square": "s",
    "diamond": "D",
    "triangle-up": "^",
    "triangle-down": "v",
    "cross": "P",
    "x-thin": "x",
    "star": "*",
    "pentagon": "p",
    "triangle-left": "<",
}
#: Points of matplotlib in a pixel of Plotly.
POINTS = 0.72


def write_picture(parts: Sequence[Figure], title: str, path: Path) -> None:
    """Draw figures one below the other, or side by side if there are two or three.

    Raises
    ------
    ValueError
        If matplotlib writes no files with such an ending.
    OSError
        If the file cannot be written.
    """
    rows = math.ceil(len(parts) / MOST_COLUMNS)
    columns = math.ceil(len(parts) / rows)
    height = parts[0]["layout"]["height"] / PAGE_PIXELS_AN_INCH
    # The same figure gives the same bytes.
    with mpl.rc_context({"svg.hashsalt": "spincheck", "svg.fonttype": "none", "font.size": 9}):
        canvas = Canvas(figsize=(WIDTH * columns, height * rows), layout="constrained")
        grid = canvas.subfigures(rows, columns, squeeze=False)
        for cell, part in zip(grid.flat, parts, strict=False):
            _draw(cell, part)
        canvas.suptitle(title, fontsize=11)
        _legend(canvas, parts)
        undated = {"Date": None} if path.suffix == ".svg" else {}
        canvas.savefig(path, dpi=PIXELS_AN_INCH, metadata=undated)


def _draw(cell: Any, part: Figure) -> None:
    layout = part["layout"]
    if "scene" in layout:
        axes = cell.add_subplot(projection="3d")
        axes.set_axis_off()
        eye = layout["scene"]["camera"]["eye"]
        azimuth = math.degrees(math.atan2(eye["y"], eye["x"]))
        up = math.degrees(math.atan2(eye["z"], math.hypot(eye["x"], eye["y"])))
        axes.view_init(elev=up, azim=azimuth)
        for trace in part["data"]:
            axes.plot(*(_values(trace[axis]) for axis in "xyz"), **_style(trace))
        axes.set_box_aspect([layout["scene"]["aspectratio"][axis] for axis in "xyz"], zoom=1.5)
        return
    panels = [k for k in (1, 2) if f"xaxis{axis_suffix(k)}" in layout]
    heights = [np.diff(layout[f"yaxis{axis_suffix(k)}"]["domain"])[0] for k in panels]
    drawn = cell.subplots(len(panels), 1, height_ratios=heights, squeeze=False)[:, 0]
    for k, axes in zip(panels, drawn, strict=True):
        suffix = axis_suffix(k)
        traces = [t for t in part["data"] if t["xaxis"] == f"x{suffix}"]
        _panel(axes, layout, suffix, traces)


def _panel(axes: Axes, layout: dict[str, Any], suffix: str, traces: list[Trace]) -> None:
    for trace in traces:
        x, y = _values(trace["x"]), _values(trace["y"])
        if "fill" in trace:
            axes.fill(x, y, color=trace["fillcolor"], linewidth=0)
        else:
            axes.plot(x, y, **_style(trace))
    for name, spec in (("x", layout[f"xaxis{suffix}"]), ("y", layout[f"yaxis{suffix}"])):
        limits = spec.get("range")
        if spec.get("type") == "log":
            getattr(axes, f"set_{name}scale")("log")
            limits = [10**limit for limit in limits] if limits else None
        if limits:
            getattr(axes, f"set_{name}lim")(*limits)
        getattr(axes, f"set_{name}label")(_plain(spec["title"]["text"]))
        if not spec.get("showticklabels", True):
            getattr(axes, f"{name}axis").set_ticks([])
    for shape in layout["shapes"]:
        if shape["yref"] == f"y{suffix}":
            axes.axhspan(shape["y0"], shape["y1"], color="0.85", zorder=0)
    if "scaleanchor" in layout[f"yaxis{suffix}"]:
        axes.set_aspect("equal", adjustable="box")
    axes.grid(color="0.92")
    axes.spines[["top", "right"]].set_visible(False)
    domain = layout[f"yaxis{suffix}"]["domain"][1]
    for note in layout["annotations"]:
        if note.get("yref") == "paper" and note["y"] == domain:
            axes.set_title(_plain(note["text"]), loc="left", fontsize=9, fontweight="bold")


def _style(trace: Trace) -> dict[str, Any]:
    line_format, marker = trace.get("line", {}), trace.get("marker", {})
    colour = line_format.get("color") or marker.get("color")
    colour = colour if str(colour).startswith("#") else COLOURS.get(str(colour), "#808080")
    mode, symbol = trace.get("mode", "lines"), str(marker.get("symbol", "circle"))
    style: dict[str, Any] = {
        "color": colour,
        "linestyle": DASHES[line_format.get("dash", "solid")] if "lines" in mode else "none",
        "linewidth": POINTS * line_format.get("width", 1.0),
    }
    if line_format.get("shape") == "hv":
        style["drawstyle"] = "steps-post"
    if "markers" in mode:
        style |= {
            "marker": MARKERS[symbol.removesuffix("-open")],
            "markersize": POINTS * marker.get("size", 6),
        }
        if symbol.endswith("-open"):
            style["markerfacecolor"] = "none"
    return style


def _legend(canvas: Canvas, parts: Sequence[Figure]) -> None:
    """The legend: each method once, and the exact motion."""
    shown: dict[str, dict[str, Any]] = {}
    for part in parts:
        for trace in part["data"]:
            name = "exact" if trace.get("name") == "exact" else trace.get("legendgroup")
            if name and "lines" in trace.get("mode", "lines") and "fill" not in trace:
                shown.setdefault(name, _style(trace))
    lines = [mpl.lines.Line2D([], [], label=name, **style) for name, style in shown.items()]
    if lines:
        columns = max(2, int(canvas.get_figwidth() / LEGEND_WIDTH))
        canvas.legend(handles=lines, loc="outside lower center", ncols=columns, frameon=False)


def _values(packed: dict[str, str]) -> FloatArray:
    return np.frombuffer(base64.b64decode(packed["bdata"]), dtype="<f4").astype(float)


def _plain(text: str) -> str:
    """Text without Plotly's markup."""
    return re.sub(r"<[^>]*>", "", text)
