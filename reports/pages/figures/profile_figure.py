"""Step curves: performance profiles, and the errors of an ensemble, one curve a method."""

from collections.abc import Mapping, Sequence
from html import escape

import numpy as np

from ....scenarios import SIGNAL, FloatArray
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
    said = "within %{x:.3g} times the cheapest<br>on %{y:.0%} of scenes"
    traces = []
    for pair, ratios in profile.ratios.items():
        factors = sorted({1.0, *ratios, x_range[1]})
        risen = np.array([profile.fraction(pair, factor) for factor in factors])
        traces.append(_steps(np.array(factors), risen, " ".join(pair), drawn[pair], said))
    return drawing(traces, [panel], 460)


def _steps(x: FloatArray, y: FloatArray, label: str, style: TraceStyle, said: str) -> Trace:
    """A curve that rises by steps, at each of which a member or a scene is."""
    drawn = method_style(label, style)
    drawn["line"] = drawn["line"] | {"shape": "hv"}
    return line(x, y, 1, **drawn, hovertemplate=f"{escape(label)}<br>{said}<extra></extra>")
