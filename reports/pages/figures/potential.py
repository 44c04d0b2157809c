"""The heavy symmetric top as a particle in a well: V_eff(β) and the line of its energy."""

import math

import numpy as np

from ....reference.heavy_symmetric_top import (
    HeavySymmetricTop,
    effective_potential,
    heavy_symmetric_top,
    nutation_bounds,
)
from ....reference.rotational_problem import rotational_problem
from ....reference.symmetry import nutates
from ....scenarios import FloatArray, Scenario
from .plot import INK, REFERENCE_WIDTH, Figure, Panel, Range, drawing, line

#: The well is drawn this far beyond the turning points, in its widths; smallest width drawn.
BEYOND, NARROWEST = 0.6, math.radians(1.0)
POINTS = 160
#: V_eff is drawn up to this many depths of the well above E′; the depth is taken to be at least
#: this fraction of what is drawn, as steady precession has no depth.
ABOVE, SHALLOW = 1.2, 0.05
#: Margin below the bottom, as a fraction of the height.
BELOW = 0.12
_ABOVE_LINE = {"yanchor": "bottom", "showarrow": False}


def potential(scenario: Scenario) -> Figure | None:
    """V_eff over the tilt with E′ and the turning points; None for any other motion."""
    problem = rotational_problem(scenario)
    top = heavy_symmetric_top(problem)
    if top is None or not nutates(problem):
        return None
    low, high = nutation_bounds(top)
    margin = max(BEYOND * (high - low), NARROWEST)
    tilts = np.linspace(max(0.0, low - margin), min(math.pi, high + margin), POINTS)
    heights = effective_potential(top, tilts)
    return _well(top, np.degrees(tilts), heights, np.degrees([low, high]))


def _well(
    top: HeavySymmetricTop, tilts: FloatArray, heights: FloatArray, ends: FloatArray
) -> Figure:
    """Draw V_eff, J, over the tilt, degrees, and E′ between the turning points."""
    energy, lowest = float(top.E_prime), int(np.argmin(heights))
    level, sides = np.full(2, energy), tilts[[0, -1]]
    traces = [
        line(tilts, heights, 1, line={"color": INK, "width": 2}, name="V_eff"),
        line(ends, level, 1, line={"color": INK, "width": REFERENCE_WIDTH}),
        line(ends, level, 1, mode="markers", marker={"color": INK, "size": 9}),
        line(sides, level, 1, line={"color": INK, "width": 1, "dash": "dot"}, name="E′"),
    ]
    panel = Panel(
        x_title="tilt β from the upward vertical, °",
        y_title="V<sub>eff</sub>, J",
        x_range=(float(tilts[0]), float(tilts[-1])),
        y_range=_heights(heights, energy),
    )
    bottom = {"x": float(tilts[lowest]), "y": float(heights[lowest])}
    right = {"x": float(tilts[-1]), "y": energy, "xanchor": "right"}
    figure = drawing(traces, [panel], 400)
    figure["layout"]["annotations"] += [
        {"text": "E′", **right, **_ABOVE_LINE},
        {"text": "V<sub>eff</sub>", **bottom, **_ABOVE_LINE},
    ]
    return figure


def _heights(heights: FloatArray, energy: float) -> Range:
    """The heights from below the bottom to above E′; at its poles V_eff may be infinite."""
    bottom, highest = float(heights.min()), float(heights[np.isfinite(heights)].max())
    depth = energy - bottom
    if depth > SHALLOW * (highest - bottom):
        highest = min(highest, energy + ABOVE * depth)
    return bottom - BELOW * (highest - bottom), highest
