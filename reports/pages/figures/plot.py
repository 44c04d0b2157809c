"""Figures as dictionaries in Plotly's JSON format: panels, lines and shading.

Plain dictionaries, unlike Plotly's objects, are made in milliseconds. The page's script replaces
`INK`, `WIRE` and `GROUND` by colours for a light or a dark page.
"""

import base64
import math
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....scenarios import FloatArray
from ..analysis.trace_style import TraceStyle

Trace = dict[str, Any]
Figure = dict[str, Any]
#: Values at the two ends of an axis: lower and upper, or left and right.
Range = tuple[float, float]

#: Largest number of samples of a line: more would not be visible.
MOST_SAMPLES = 400
#: Placeholders for the colours of text, of wire frames and of the page.
INK, WIRE, GROUND = "ink", "wire", "ground"
#: Largest error for which an axis of errors has room: larger ones are blow-ups.
OFF_THE_CHART = 1e2
#: Values of this size and above are left out, as browsers fail to draw them.
BEYOND_DRAWING = 1e30
#: Largest number of labels on a log axis.
LOG_LABELS = 8
REFERENCE_WIDTH, METHOD_WIDTH = 5.0, 1.6
EPS = float(np.finfo(float).eps)
#: Margin around values, as a fraction of their range.
PADDING = 0.08
#: The domain of a panel that is the only one of its figure: left and right, bottom and top.
WHOLE = ((0.0, 1.0), (0.0, 1.0))
FLOOR_COLOUR = "rgba(128,128,128,0.22)"


@dataclass(frozen=True)
class Panel:
    """One pair of axes of a figure.

    Attributes
    ----------
    x_title, y_title, heading : titles of the axes, and text above the panel
    log_x, log_y : whether an axis is logarithmic
    y_range, x_range : values at the two ends of an axis; None to show all values
    floor : the reference's uncertainty, below which the panel is shaded; None for no shading
    equal_scales : whether both axes have the same scale
    domain : left and right, and bottom and top, as fractions of the figure
    """

    x_title: str
    y_title: str
    heading: str = ""
    log_x: bool = False
    y_range: Range | None = None
    x_range: Range | None = None
    log_y: bool = False
    floor: float | None = None
    equal_scales: bool = False
    domain: tuple[Range, Range] = WHOLE


def drawing(
    traces: Sequence[Trace], panels: Sequence[Panel], height: int, *overlays: dict[str, Any]
) -> Figure:
    """Return a figure that consists of panels.

    Parameters
    ----------
    traces : curves and points, in Plotly's format
    panels : the pairs of axes, in the order in which traces and overlays count them
    height : height of the figure, pixels
    overlays : descriptions of curves that the page's script adds, from the motions that the page
        carries
    """
    figure: Figure = {"data": traces, "layout": layout(panels, height)}
    return figure | {"overlays": list(overlays)} if overlays else figure


def square(titles: tuple[str, str, str], widest: float) -> Panel:
    """Return a square panel with the origin in its middle.

    Parameters
    ----------
    titles : titles of the axes x and y, and of the panel
    widest : largest absolute value shown on each axis
    """
    reach = (-widest, widest)
    return Panel(*titles, x_range=reach, y_range=reach, equal_scales=True)


def layout(panels: Sequence[Panel], height: int) -> dict[str, Any]:
    """Return Plotly's layout of a figure of panels, whose height is in pixels."""
    made: dict[str, Any] = {"height": height, "shapes": [], "annotations": []}
    for k, panel in enumerate(panels, start=1):
        suffix, (across, down) = axis_suffix(k), panel.domain
        made[f"xaxis{suffix}"] = {
            "domain": across,
            "anchor": f"y{suffix}",
            **_axis(panel.x_title, panel.log_x, panel.x_range),
        }
        made[f"yaxis{suffix}"] = {
            "domain": down,
            "anchor": f"x{suffix}",
            **_axis(panel.y_title, panel.log_y, panel.y_range),
        }
        if panel.equal_scales:
            made[f"yaxis{suffix}"]["scaleanchor"] = f"x{suffix}"
        if panel.heading:
            made["annotations"].append(heading(panel.heading, across[0], down[1]))
        if panel.floor is not None and panel.y_range is not None:
            floor = min(panel.floor, panel.y_range[1])
            made["shapes"].append(_floor_shading(suffix, panel.y_range[0], floor))
    return made


def axis_suffix(k: int) -> str:
    """Return what Plotly writes behind x or y for the k-th axis: k, but nothing for the first."""
    return "" if k == 1 else str(k)


def line(x: FloatArray, y: FloatArray, k: int, **properties: Any) -> Trace:
    """Return Plotly's trace of a line in the k-th panel, counted from 1.

    Parameters
    ----------
    x, y : abscissas and ordinates of its points, (n,) each
    properties : further properties of the trace
    """
    suffix = axis_suffix(k)
    return {
        "type": "scatter",
        "mode": "lines",
        "x": packed(x),
        "y": packed(y),
        "xaxis": f"x{suffix}",
        "yaxis": f"y{suffix}",
        "showlegend": False,
        **properties,
    }


def method_style(label: str, style: TraceStyle) -> dict[str, Any]:
    """Return the style of a method's line, as properties of Plotly's trace.

    The page shows and hides all lines of a method by their `legendgroup`.
    """
    return {
        "mode": "lines",
        "line": {"color": style.colour, "width": METHOD_WIDTH, "dash": style.dash},
        # Plotly interprets some HTML, so labels are escaped.
        "name": escape(label, quote=False),
        "legendgroup": label,
        "hoverinfo": "name",
    }


def start_dot(x: float, y: float, k: int) -> Trace:
    """Return a dot at (x, y) that marks a motion's start, in the k-th panel, counted from 1."""
    marker = {"color": INK, "size": 8}
    return line(np.array([x]), np.array([y]), k, mode="markers", marker=marker, hoverinfo="skip")


def heading(text: str, x: float, y: float) -> dict[str, Any]:
    """Return Plotly's annotation for a panel's heading, at x and y as fractions of the figure."""
    return {
        "text": f"<b>{text}</b>",
        "x": x,
        "y": y,
        "xref": "paper",
        "yref": "paper",
        "xanchor": "left",
        "yanchor": "bottom",
        "yshift": 4,
        "showarrow": False,
    }


def packed(values: FloatArray) -> dict[str, str]:
    """Return an array, (n,), in the form in which Plotly reads it: base64, in single precision.

    Values of the size `BEYOND_DRAWING` and above become NaN, which Plotly draws as gaps.
    """
    drawable = np.where(np.abs(values) < BEYOND_DRAWING, values, np.nan)
    single = np.ascontiguousarray(drawable, dtype="<f4")
    return {"dtype": "f4", "bdata": base64.b64encode(single.tobytes()).decode("ascii")}


def thinned(n: int, most: int = MOST_SAMPLES) -> NDArray[np.intp]:
    """Return the indices of at most `most` of n samples, evenly spread from first to last."""
    return np.unique(np.linspace(0, n - 1, min(n, most)).astype(np.intp))


def claimed(errors: FloatArray, floor: float) -> FloatArray:
    """Return errors, (n,), as they are drawn: raised to the reference's uncertainty if below it.

    Infinite errors become NaN, for which Plotly draws a gap.

    Parameters
    ----------
    floor : the uncertainty, in the unit of the errors
    """
    raised = np.maximum(errors, floor)
    return np.where(np.isfinite(raised), raised, np.nan)


def error_range(curves: Sequence[FloatArray], floor: float) -> Range:
    """Return the range of an axis of errors: from half the uncertainty to above the largest error.

    The upper end is at most twice `OFF_THE_CHART`. If the uncertainty is zero or not finite, the
    range is from `EPS` to 1.

    Parameters
    ----------
    curves : the errors of each curve, some of which may be NaN or infinite
    floor : uncertainty of the reference, in the unit of the errors
    """
    if not 0 < floor < math.inf:
        # A signal whose exact value is zero, such as L of a body at rest, has no relative error.
        return EPS, 1.0
    finite = [curve[np.isfinite(curve)] for curve in curves]
    highest = max((float(curve.max()) for curve in finite if len(curve)), default=floor)
    return floor / 2, 2 * min(max(highest, 10 * floor), OFF_THE_CHART)


def padded(values: FloatArray) -> Range:
    """Return the range of values, (n,), with a margin on both sides, so that it is never empty."""
    low, high = float(values.min()), float(values.max())
    margin = (high - low or abs(high) or 1.0) * PADDING
    return low - margin, high + margin


def _axis(title: str, logarithmic: bool, limits: Range | None) -> dict[str, Any]:
    """Return Plotly's settings of an axis.

    Parameters
    ----------
    limits : values at the two ends of the axis; None to show all values
    """
    axis: dict[str, Any] = {
        "title": {"text": title},
        "zeroline": False,
        "exponentformat": "power",
    }
    if logarithmic:
        # Plotly draws powers of ten a quarter larger than other labels.
        axis |= {"type": "log", "dtick": 1, "tickfont": {"size": 10}}
    if limits and logarithmic:
        low, high = (math.log10(limit) for limit in limits)
        axis["range"] = [low, high]
        axis["dtick"] = max(1, math.ceil((high - low) / LOG_LABELS))
    elif limits:
        axis["range"] = list(limits)
    return axis


def _floor_shading(suffix: str, bottom: float, floor: float) -> dict[str, Any]:
    """Return a grey band from the bottom of a panel up to the uncertainty.

    Parameters
    ----------
    suffix : number of the panel's axes, from `axis_suffix`
    bottom, floor : lower and upper end of the band, in the unit of the y axis
    """
    return {
        "type": "rect",
        "layer": "below",
        "xref": f"x{suffix} domain",
        "yref": f"y{suffix}",
        "x0": 0,
        "x1": 1,
        "y0": bottom,
        "y1": floor,
        "fillcolor": FLOOR_COLOUR,
        "line": {"width": 0},
    }
