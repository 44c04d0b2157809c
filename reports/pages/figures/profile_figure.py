"""Performance profiles as step curves, one figure an error."""

from collections.abc import Mapping, Sequence

import numpy as np

from ....scenarios import SIGNAL
from ...results.records import Pair
from ..analysis.profiles import Profile
from ..analysis.trace_style import TraceStyle
from ..analysis.wording import number
from .plot import Figure, Panel, Range, Trace, drawing, line, method_style

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
