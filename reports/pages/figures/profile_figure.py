"""Step curves: performance profiles, and the errors of an ensemble, one curve a method."""

from collections.abc import Mapping, Sequence
from html import escape

import numpy as np

from ....scenarios import SIGNAL
from ...results.records import Pair
from ..analysis.cost_to_reach import Profile
from ..analysis.measures import Measure, Members
from ..analysis.trace_style import TraceStyle
from ..analysis.wording import number
from .plot import Figure, Panel, Range, Trace, drawing, line, method_style

HEIGHT, LOW = 480, 250
#: Margins: a factor beside the outermost errors, and percent beside 0 and 100.
BESIDE_ERRORS, PERCENT_MARGIN = 2.0, 3.0
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
    x_range = min(outermost) / BESIDE_ERRORS, min(max(outermost), LARGEST) * BESIDE_ERRORS
    panel = Panel(
        measure.title,
        "% of members within it",
        log_x=True,
        x_range=x_range,
        y_range=(-PERCENT_MARGIN, 100 + PERCENT_MARGIN),
    )
    return drawing(traces, [panel], height)


#: Margin beside the largest factor of the log axis, as a factor.
BESIDE = 1.5
#: Range of the fraction, slightly wider than 0 to 1, so that no curve is drawn on the frame.
FRACTIONS: Range = (-0.03, 1.03)


def profile_figures(
    profiles: Sequence[Profile], drawn: Mapping[Pair, TraceStyle]
) -> tuple[Figure, ...]:
    """Fraction of scenes solved against the factor by which the cheapest method is exceeded."""
    largest = max((r[-1] for p in profiles for r in p.ratios.values() if r), default=1.0)
    x_range = (1.0, largest * BESIDE)
    return tuple(_figure(profile, drawn, x_range) for profile in profiles)


def _figure(profile: Profile, drawn: Mapping[Pair, TraceStyle], x_range: Range) -> Figure:
    heading = f"{SIGNAL[profile.signal]}: error up to {number(profile.level, 1)}"
    x_title = "cost over the cheapest method's, τ"
    panel = Panel(x_title, "fraction of scenes", heading, True, FRACTIONS, x_range)
    return drawing(_steps(profile, drawn, x_range[1]), [panel], 460)


def _steps(profile: Profile, drawn: Mapping[Pair, TraceStyle], end: float) -> list[Trace]:
    traces = []
    for pair, ratios in profile.ratios.items():
        factors = sorted({1.0, *ratios, end})
        label = " ".join(pair)
        style = method_style(label, drawn[pair])
        style["line"] = style["line"] | {"shape": "hv"}
        hover = f"{label}<br>within %{{x:.3g}} times the cheapest<br>on %{{y:.0%}} of scenes"
        traces.append(
            line(
                np.array(factors),
                np.array([profile.fraction(pair, factor) for factor in factors]),
                1,
                **style | {"hovertemplate": f"{hover}<extra></extra>"},
            )
        )
    return traces
