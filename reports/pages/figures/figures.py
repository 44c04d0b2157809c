"""All figures of a scene, in reading order, and the figure of a heavy top's effective potential."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ....reference.effect_terms import nutates
from ....reference.heavy_symmetric_top import (
    HeavySymmetricTop,
    effective_potential,
    heavy_symmetric_top,
    nutation_bounds,
)
from ....reference.rotational_problem import rotational_problem
from ....scenarios import FloatArray, Scenario
from ..analysis.report_data import SceneRuns
from .axis_path import axis_path, polhode
from .drawn_body import drawn_body
from .gain_figures import BAND, OFF, gain_figures
from .ladder_figures import convergence, work_precision
from .plot import INK, REFERENCE_WIDTH, Figure, Panel, Range, drawing, line
from .signal_figures import defect_figure, omega_figures, tilt_figure

#: How far beyond the turning points V_eff is drawn, as a multiple of the distance between them; and
#: the least such extension, rad.
BEYOND, NARROWEST = 0.6, math.radians(1.0)
#: Number of points of the curve of V_eff.
POINTS = 160
#: Height above E′ up to which V_eff is drawn, in depths of the well; and the depth, as a fraction
#: of the range of V_eff, below which all of V_eff is drawn, as for steady precession.
ABOVE, SHALLOW = 1.2, 0.05
#: Margin below the bottom of V_eff, as a fraction of the height that is drawn.
BELOW = 0.12
_ABOVE_LINE = {"yanchor": "bottom", "showarrow": False}


def potential(scenario: Scenario) -> Figure | None:
    """Return a figure of the effective potential V_eff over the tilt, with E′ and turning points.

    E′ = E − p_γ²/2 I₃ is the energy E without that of the spin about the symmetry axis; about this
    axis, p_γ is the angular momentum and I₃ the moment of inertia. None is returned unless the
    motion is the nutation of a heavy symmetric top.
    """
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
    """Return a figure of a top's effective potential V_eff over the tilt.

    The energy E′ is a level line, on which the turning points are marked.

    Parameters
    ----------
    tilts, heights : tilts, degrees, and V_eff at these tilts, J, (n,) each
    ends : tilts of the turning points, degrees, (2,)
    """
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
    """Return the range of the vertical axis, J, from below the bottom of V_eff to above E′.

    If E′ is hardly above the bottom, the range ends at the largest finite V_eff.

    Parameters
    ----------
    heights : the effective potential V_eff, J, (n,); some values may be infinite
    energy : the energy E′ at which the tilt moves in that potential, J
    """
    bottom, highest = float(heights.min()), float(heights[np.isfinite(heights)].max())
    depth = energy - bottom
    if depth > SHALLOW * (highest - bottom):
        highest = min(highest, energy + ABOVE * depth)
    return bottom - BELOW * (highest - bottom), highest


@dataclass(frozen=True, eq=False)
class Titled:
    """Figures that a page places side by side if there is room, with their title and caption.

    Attributes
    ----------
    name : name by which links and tests refer to the figures
    title : the line above the figures
    caption : what is drawn and what to look for
    parts : the figures
    """

    name: str
    title: str
    caption: str
    parts: Sequence[Figure]


Section = Literal["signals", "steps", "ladder", "geometry"]


def figures(scene: SceneRuns) -> dict[Section, list[Titled]]:
    """Return all figures for which a scene has data, by the section of the page that shows them."""
    if scene.solved is None:
        return {"signals": [], "steps": [], "ladder": [], "geometry": []}
    return {
        "signals": list(_signals(scene)),
        "steps": list(_steps(scene)),
        "ladder": list(_ladder(scene)),
        "geometry": list(_geometry(scene)),
    }


def _signals(scene: SceneRuns) -> Iterator[Titled]:
    """Yield the figures of tilt, ω and defects over time."""
    up = drawn_body(scene.exact).up_means
    yield Titled(
        "tilt",
        "β(t), and where it goes wrong",
        f"Above: the tilt of the body's axis from {up}. Below: the angle between the attitude of "
        "each run and the exact one; a dot marks where it first exceeds 1°. Grey: the "
        "reference's uncertainty, below which nothing is claimed.",
        [tilt_figure(scene)],
    )
    yield Titled(
        "omega",
        "ω(t)",
        "In body axes. The exact solution is the thick line.",
        omega_figures(scene),
    )
    yield Titled(
        "defect",
        "Defect: which intervals go wrong",
        "What a run does from one of its samples to the next, beside the exact motion from the "
        "same sample: the largest over all signals, in their errors' norms. What went wrong "
        "before does not count. Grey: round-off.",
        [defect_figure(scene)],
    )


def _steps(scene: SceneRuns) -> Iterator[Titled]:
    """Yield the figures of the gains of single steps, if any are to be drawn."""
    if parts := gain_figures(scene):
        yield Titled(
            "gains",
            "What a step gains, against its length",
            "How far a single step ends from the exact motion, a second, relative to the largest "
            "terms of the equations of motion, from the state that fits least. Band: what longer "
            f"steps predict, ± {BAND:g} standard deviations. A method that converges stays in its "
            "band, down to the noise; one that does not leaves it, mostly for a constant. Rings: "
            f"gains more than {OFF:.2g} standard deviations off.",
            parts,
        )


def _ladder(scene: SceneRuns) -> Iterator[Titled]:
    """Yield the figures of errors against timestep and against cost."""
    rows = [row for runs in scene.methods for row in runs.rows]
    if any(row.errors for row in rows):
        yield Titled(
            "convergence",
            "Convergence: error against timestep",
            "Every run. Rings: stock timesteps. Dotted: the slopes of the declared orders of "
            "accuracy. The strip below holds the runs that have no error: × diverged, ▽ failed. "
            "Grey: the reference's uncertainty.",
            convergence(scene),
        )
    if any(row.errors and row.seconds_per_step for row in rows):
        yield Titled(
            "cost",
            "Work–precision: error against cost",
            "The same runs by what they cost: CPU seconds of native stepping a simulated second. "
            "Further down and further left is better; compare methods along a horizontal line. "
            "Rings: stock timesteps. Light steps: the Pareto front, the runs more accurate than "
            "all cheaper ones.",
            work_precision(scene),
        )


def _geometry(scene: SceneRuns) -> Iterator[Titled]:
    """Yield the figures of the paths of the axis and of ω, and of V_eff, where they apply."""
    if not scene.exact.scenario.constraint.is_free:
        yield Titled(
            "axis",
            "Path of the axis",
            "Where the body's axis points, as a path on the unit sphere (to be turned), from "
            "above, and unrolled into azimuth and tilt, where nutation shows as waves, cusps or "
            "loops. A dot marks the start. Framed on the exact path; a double click shows all.",
            axis_path(scene),
        )
    traced = polhode(scene)
    if traced:
        yield Titled(
            "polhode",
            "Polhode and herpolhode",
            "Left: the tip of ω in the body's principal axes, on Poinsot's ellipsoid of the "
            "largest rotational energy. Right: the same tip in space, seen along the initial "
            "angular momentum. Of a free body the polhode is closed; a run that leaves it has the "
            "wrong energy or angular momentum. A dot marks the start.",
            traced,
        )
    well = potential(scene.exact.scenario)
    if well is not None:
        yield Titled(
            "potential",
            "Effective potential",
            "What is left of the motion once p_α and p_γ are constant: the tilt β moves in the "
            "well V_eff at the height E′ = E − p_γ²/2 I₃, between the two turning points.",
            [well],
        )
