"""The errors of an ensemble as empirical distributions, one curve a method."""

from collections.abc import Mapping, Sequence
from html import escape

import numpy as np

from ...results.records import Pair
from ..analysis.ensemble_numbers import Members
from ..analysis.measures import Measure
from ..analysis.trace_style import TraceStyle
from .plot import Figure, Panel, drawing, line, method_style

HEIGHT, LOW = 480, 250
#: Margins: a factor beside the outermost errors, and percent beside 0 and 100.
BESIDE, MARGIN = 2.0, 3.0
#: Largest error drawn, relative or in degrees; a blow-up that finished would compress the axis.
LARGEST = 180.0


def distribution(
    members: Sequence[Members],
    trace_styles: Mapping[Pair, TraceStyle],
    measure: Measure,
    height: int = HEIGHT,
) -> Figure:
    """Percentage of all members of which a measure is at most so much.

    A curve ends at the percentage that finished; at least one member did.
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
        hover = f"{escape(label)}<br>%{{y:.3g}} % within %{{x:.2e}}<extra></extra>"
        x = np.concatenate([errors[:1], errors])
        # By steps: the error of a member is where the curve rises.
        style = method_style(label, trace_styles[of_method.pair])
        style |= {"hovertemplate": hover, "line": style["line"] | {"shape": "hv"}}
        traces.append(line(x, risen, 1, **style))
        outermost += [float(errors[0]), float(errors[-1])]
    x_range = min(outermost) / BESIDE, min(max(outermost), LARGEST) * BESIDE
    panel = Panel(
        measure.title,
        "% of members within it",
        log_x=True,
        x_range=x_range,
        y_range=(-MARGIN, 100 + MARGIN),
    )
    return drawing(traces, [panel], height)
