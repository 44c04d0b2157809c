"""A figure of how the errors of an ensemble are distributed, with a curve for each method."""

from collections.abc import Mapping, Sequence
from html import escape

import numpy as np

from ....scenarios import FloatArray
from ...results.records import Pair
from ..analysis.measures import Measure, Members
from ..analysis.trace_style import TraceStyle
from .plot import Figure, Panel, Trace, drawing, line, method_style

HEIGHT = 250
#: Margins of the axes: a factor below the least and above the largest error; and percent below 0
#: and above 100.
BESIDE_ERRORS, PERCENT_MARGIN = 2.0, 3.0
#: Largest error on the axis, relative or in degrees. Much larger ones, of runs that blew up but
#: finished, would compress the curves.
LARGEST = 180.0


def distribution(
    members: Sequence[Members],
    trace_styles: Mapping[Pair, TraceStyle],
    measure: Measure,
) -> Figure:
    """Return a figure of how the errors of an ensemble's members are distributed.

    Each method has a curve of the percentage of members whose error is at most the abscissa. It
    ends at the percentage of members whose runs finished. At least one error must be above 0.

    Parameters
    ----------
    members : the runs of each method
    trace_styles : how the curve of each method is drawn
    measure : the error, such as the attitude error in degrees
    """
    traces = []
    outermost = []
    for of_method in members:
        errors = of_method.errors(measure)
        errors = errors[errors > 0]
        if not len(errors):
            continue
        exact = len(of_method.finished) - len(errors)
        risen = 100 * (exact + np.arange(len(errors) + 1)) / len(of_method.points)
        label = " ".join(of_method.pair)
        x = np.concatenate([errors[:1], errors])
        said = "%{y:.3g} % within %{x:.2e}"
        traces.append(_steps(x, risen, label, trace_styles[of_method.pair], said))
        outermost += [float(errors[0]), float(errors[-1])]
    x_range = min(outermost) / BESIDE_ERRORS, min(max(outermost), LARGEST) * BESIDE_ERRORS
    panel = Panel(
        measure.title,
        "% of members within it",
        log_x=True,
        x_range=x_range,
        y_range=(-PERCENT_MARGIN, 100 + PERCENT_MARGIN),
    )
    return drawing(traces, [panel], HEIGHT)


def _steps(x: FloatArray, y: FloatArray, label: str, style: TraceStyle, said: str) -> Trace:
    """Return a curve that rises by a step at the error of each member.

    Parameters
    ----------
    x, y : abscissas at which the curve rises, and the heights that it rises to, (n,) each
    label : engine and method, whose curve it is
    style : how the curve is drawn
    said : text that the page shows where a reader points at the curve
    """
    drawn = method_style(label, style)
    drawn["line"] = drawn["line"] | {"shape": "hv"}
    return line(x, y, 1, **drawn, hovertemplate=f"{escape(label)}<br>{said}<extra></extra>")
