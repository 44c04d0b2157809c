"""The figures of a scene, in the order they are read."""

from collections.abc import Iterator
from dataclasses import dataclass
from html import escape

import numpy as np

from ....scenarios import FloatArray
from ...results.store import SceneResult
from ..analysis.report_data import Compared, SceneRuns
from ..analysis.wording import number
from .axis_path import axis_path
from .ladder_figures import convergence, work_precision
from .plot import (
    Figure,
    Panel,
    Trace,
    claimed,
    error_range,
    exact_look,
    layout,
    line,
    method_style,
    padded,
    peaks,
    thinned,
)
from .polhode import polhode
from .potential import potential

AXES = ("₁", "₂", "₃")


@dataclass(frozen=True, eq=False)
class Titled:
    """A figure with the words around it.

    Attributes
    ----------
    name : for links and tests
    title : one line above
    caption : what is drawn and what to look for
    """

    name: str
    title: str
    caption: str
    figure: Figure


def figures(scene: SceneRuns) -> list[Titled]:
    """Every figure that the scene has data for."""
    return list(_figures(scene))


def _figures(scene: SceneRuns) -> Iterator[Titled]:
    found, compared = scene.found, scene.compared
    if found is None:
        return
    yield Titled(
        "omega",
        "Angular velocity",
        "Above: ω in body axes, the exact solution in a thick line, each method's finest finished "
        "run over it. Below: how far each run is from the exact one at every sample. Grey: the "
        "reference's own uncertainty, below which nothing is claimed.",
        omega_figure(found, compared),
    )
    yield from _path_figures(found, compared)
    if compared:
        yield Titled(
            "errors",
            "Errors along the run",
            "Attitude, angular momentum and energy of each method's finest run against the exact "
            "ones. A run that was not finished ends where it stopped.",
            errors_figure(found, compared),
        )
    if any(row.errors for runs in scene.methods for row in runs.rows):
        yield Titled(
            "convergence",
            "Error against timestep",
            "Every run. Dotted: the slopes of the declared orders of accuracy. A cross marks a run "
            "that diverged, with its error up to there. Grey: the reference's uncertainty.",
            convergence(scene),
        )
    if any(row.errors and row.seconds_per_step for runs in scene.methods for row in runs.rows):
        yield Titled(
            "cost",
            "Error against cost",
            "The same runs by what they cost: CPU seconds of native stepping a simulated second. "
            "Further down and further left is better; compare methods along a horizontal line. "
            "Light steps: the Pareto front, the runs more accurate than all cheaper ones.",
            work_precision(scene),
        )


def _path_figures(found: SceneResult, compared: tuple[Compared, ...]) -> Iterator[Titled]:
    if found.scenario.has_pivot:
        yield Titled(
            "axis",
            "Path of the axis",
            "Where the body's axis points, as a path on the unit sphere: turned freely, from "
            "above, and unrolled into azimuth and tilt, where nutation shows as waves, cusps or "
            "loops. A dot marks the start. Framed on the exact path; a double click shows all.",
            axis_path(found, compared),
        )
    else:
        traced = polhode(found, compared)
        if traced is not None:
            yield Titled(
                "polhode",
                "Polhode and herpolhode",
                "Left: the tip of ω in the body's principal axes, on Poinsot's ellipsoid of equal "
                "energy; a run that leaves the exact curve has the wrong energy or angular "
                "momentum. Right: the same tip in space, seen along the initial angular "
                "momentum. A dot marks the start.",
                traced,
            )
    well = potential(found.scenario)
    if well is not None:
        yield Titled(
            "potential",
            "Effective potential",
            "What is left of the motion once p_α and p_γ are constant: the tilt β moves in the "
            "well V_eff at the height E′ = E − p_γ²/2 I₃, between the two turning points.",
            well,
        )


def omega_figure(found: SceneResult, compared: tuple[Compared, ...]) -> Figure:
    """ω(t) by component, and below it the difference of every run from the truth."""
    truth = found.solution.trajectory
    floor = found.solution.uncertainty.omega
    base = float(np.linalg.norm(truth.omega_body, axis=1).max()) or 1.0
    kept = thinned(len(truth.t))
    traces = [
        line(
            truth.t[kept],
            truth.omega_body[kept, k],
            k + 1,
            **exact_look(),
        )
        for k in range(3)
    ]
    curves: list[FloatArray] = []
    for run in compared:
        shown = thinned(len(run.motion.t))
        off = np.abs(run.motion.omega_body - run.truth.omega_body) / base
        for k in range(3):
            omega = run.motion.omega_body[shown, k]
            traces.append(_method_line(run, omega, k + 1, "%{y:.5g} rad/s"))
            curves.append(claimed(peaks(off[:, k]), floor))
            traces.append(_method_line(run, curves[-1], k + 4, "off by %{y:.2e}"))
    y_range = error_range(curves, floor)
    x_range = (0.0, float(truth.t[-1]))
    above = [
        Panel("", f"ω{AXES[k]}, rad/s", y_range=padded(truth.omega_body[:, k]), x_range=x_range)
        for k in range(3)
    ]
    below = [
        Panel("t, s", f"|Δω{AXES[k]}| / max ‖ω‖", "", False, y_range, x_range, True, floor)
        for k in range(3)
    ]
    return {"data": traces, "layout": layout([above, below], height=640)}


def errors_figure(found: SceneResult, compared: tuple[Compared, ...]) -> Figure:
    """Attitude, L and energy errors along each method's finest run."""
    limits = found.solution.uncertainty
    signals = {
        "attitude": "attitude error, rad",
        "angular_momentum": "‖ΔL‖ / max ‖L‖",
        "energy": "|ΔE| / base",
    }
    headings = ("Attitude", "Angular momentum", "Energy")
    traces: list[Trace] = []
    panels = []
    series = [run.series(found) for run in compared]
    x_range = (0.0, float(found.solution.trajectory.t[-1]))
    for k, (signal, y_title) in enumerate(signals.items(), start=1):
        floor = float(getattr(limits, signal))
        curves = [claimed(peaks(getattr(errors, signal)), floor) for errors in series]
        traces += [
            _method_line(run, curve, k, "off by %{y:.2e}")
            for run, curve in zip(compared, curves, strict=True)
        ]
        y_range = error_range(curves, floor)
        panels.append(Panel("t, s", y_title, headings[k - 1], False, y_range, x_range, True, floor))
    return {"data": traces, "layout": layout([panels], height=430)}


def _method_line(run: Compared, y: FloatArray, k: int, said: str) -> Trace:
    """A thinned line of one run over time, in the method's look."""
    shown = thinned(len(run.motion.t))
    where = f"{escape(run.runs.label, quote=False)}, timestep {number(run.row.timestep)} s"
    hover = {"hovertemplate": f"{where}<br>t = %{{x:.4g}} s<br>{said}<extra></extra>"}
    # A single sample makes no line.
    mode = {"mode": "markers"} if len(shown) == 1 else {}
    return line(
        run.motion.t[shown], y, k, **method_style(run.runs.label, run.runs.look) | hover | mode
    )
