"""Tilt and angular velocity over time, how far runs are from the exact ones, and lines of runs.

On pages the script draws the lines, from the motions that the page carries: a figure has axes, and
which line belongs in which panel (`overlays`). In pictures, `with_runs` draws them.
"""

import math
from collections.abc import Callable, Iterable, Iterator
from typing import Any

import numpy as np

from ....scenarios import FloatArray, Trajectory
from ...harness.defects import LEAST_ROUNDING
from ...results.results import SceneResult
from ..analysis.report_data import Compared, SceneRuns
from .axis_path import curve
from .drawn_body import DrawnBody, dense_motion, drawn_body
from .plot import (
    Figure,
    Panel,
    Range,
    Trace,
    claimed,
    drawing,
    error_range,
    exact_look,
    line,
    method_style,
)

#: Number of samples of the exact motion over the window.
SAMPLES = 4000
#: rad; where the azimuth jumps by more between samples, the axis has passed the vertical.
JUMP = np.pi / 2

Lines = Callable[[Trajectory, dict[str, Any], DrawnBody], FloatArray]


def with_runs(figure: Figure, scene: SceneRuns, runs: Iterable[Compared]) -> Figure:
    """Add to a figure the exact motion and the runs, which on pages the script draws."""
    overlays = figure.get("overlays", [])
    drawn = [trace for overlay in overlays for trace in _drawn(overlay, scene, list(runs))]
    return {"data": [*figure["data"], *drawn], "layout": figure["layout"]}


def _drawn(overlay: dict[str, Any], scene: SceneRuns, runs: list[Compared]) -> Iterator[Trace]:
    if "exact" in overlay:
        is_whole = overlay["exact"] == "exact"
        exact = scene.outline(scene.end, SAMPLES) if is_whole else dense_motion(scene)
        yield _line(overlay, scene, exact, exact_look())
    for run in runs:
        style = method_style(run.runs.label, run.runs.style)
        if overlay["kind"] in ERRORS:
            errors = ERRORS[overlay["kind"]](run)
            yield line(run.motion.t, errors, overlay["panel"], **style)
        else:
            yield _line(overlay, scene, run.motion, style)


def _line(
    overlay: dict[str, Any], scene: SceneRuns, motion: Trajectory, style: dict[str, Any]
) -> Trace:
    values = MOTIONS[overlay["kind"]](motion, overlay, drawn_body(scene.exact))
    if "panel" not in overlay:
        return curve(values, style)
    x, y = (motion.t, values) if values.ndim == 1 else values.T
    return line(x, y, overlay["panel"], **style)


def _tilt(motion: Trajectory, _: dict[str, Any], body: DrawnBody) -> FloatArray:
    tips = motion.to_world(body.axis_body)
    across = np.linalg.norm(np.cross(tips, body.up_world), axis=1)
    return np.asarray(np.degrees(np.arctan2(across, tips @ body.up_world)))


def _on_ellipsoid(motion: Trajectory, overlay: dict[str, Any], _: DrawnBody) -> FloatArray:
    points = motion.omega_body @ np.array(overlay["matrix"]).T
    near = np.linalg.norm(points, axis=1) <= overlay["within"]
    return np.where(near[:, None], points, np.nan)


def _axis(motion: Trajectory, overlay: dict[str, Any], body: DrawnBody) -> FloatArray:
    return np.asarray(motion.to_world(body.axis_body) @ np.array(overlay["matrix"]).T)


def _unrolled(motion: Trajectory, overlay: dict[str, Any], body: DrawnBody) -> FloatArray:
    x, y, up = _axis(motion, overlay, body).T
    azimuth, tilt = np.unwrap(np.arctan2(y, x)), np.arctan2(np.hypot(x, y), up)
    jumps = np.abs(np.diff(azimuth, prepend=azimuth[:1])) > JUMP
    return np.asarray(np.degrees(np.column_stack([np.where(jumps, np.nan, azimuth), tilt])))


MOTIONS: dict[str, Lines] = {
    "tilt": _tilt,
    "omega": lambda motion, overlay, _: motion.omega_body[:, overlay["component"]],
    "omega_body": _on_ellipsoid,
    "omega_world": lambda motion, overlay, _: (
        motion.to_world(motion.omega_body) @ np.array(overlay["matrix"]).T
    ),
    "axis": _axis,
    "axis_unrolled": _unrolled,
}
ERRORS: dict[str, Callable[[Compared], FloatArray]] = {
    "attitude_error": lambda run: np.degrees(run.series["attitude"]),
    "omega_error": lambda run: run.series["omega"],
    "defect": lambda run: run.defect,
}


TILT, DIFFERENCE = ((0.0, 1.0), (0.52, 1.0)), ((0.0, 1.0), (0.0, 0.42))
#: Degrees; a tilt that changes less is drawn with this margin.
STEADY = 0.5
#: Margin above and below a component of ω, as a fraction of the largest ω.
STEADY_RATE = 0.05
AXES = ("₁", "₂", "₃")


def tilt_figure(scene: SceneRuns) -> Figure:
    """β(t), and below it the angle between each run's attitude and the exact one."""
    exact, body = scene.exact.solution.trajectory, drawn_body(scene.exact)
    cosine = np.clip(exact.to_world(body.axis_body) @ body.up_world, -1.0, 1.0)
    tilt = np.degrees(np.arccos(cosine))
    room = max(STEADY, float(np.ptp(tilt)) / 4)
    low, high = max(0.0, float(tilt.min()) - room), min(180.0, float(tilt.max()) + room)
    floor = math.degrees(scene.exact.solution.uncertainty.attitude)
    curves = [np.degrees(run.series["attitude"]) for run in scene.compared]
    panels = [
        Panel("", "β, °", "Tilt", False, (low, high), _window(scene.exact), domain=TILT),
        Panel(
            "t, s",
            "off by, °",
            "Attitude error",
            y_range=_errors(curves, floor),
            x_range=_window(scene.exact),
            log_y=True,
            floor=floor,
            domain=DIFFERENCE,
        ),
    ]
    tilt_lines = {"kind": "tilt", "panel": 1, "exact": "exact"}
    figure = drawing(
        [], panels, 500, tilt_lines, {"kind": "attitude_error", "panel": 2, "noticed": True}
    )
    figure["layout"]["xaxis2"]["matches"] = "x"
    return figure


def omega_figures(scene: SceneRuns) -> list[Figure]:
    """The three components of ω in body axes, and how far the vector is from the exact one."""
    solved, runs = scene.exact, scene.compared
    figures = [_component(solved, k) for k in range(3)]
    curves = [run.series["omega"] for run in runs]
    axes = "‖Δω‖ / max ‖ω‖", "Difference"
    drawn = _over_time(solved, "omega_error", axes, curves, solved.solution.uncertainty.omega)
    return [*figures, drawn]


def defect_figure(scene: SceneRuns) -> Figure:
    """The largest defect of any signal, interval by interval."""
    curves = [run.defect for run in scene.compared]
    return _over_time(scene.exact, "defect", ("relative, or rad", ""), curves, LEAST_ROUNDING)


def _over_time(
    solved: SceneResult, kind: str, axes: tuple[str, str], curves: list[FloatArray], floor: float
) -> Figure:
    """One panel of errors, with a title of its axis and a heading."""
    y_range, x_range = _errors(curves, floor), _window(solved)
    panel = Panel("t, s", *axes, y_range=y_range, x_range=x_range, log_y=True, floor=floor)
    return drawing([], [panel], HEIGHT, {"kind": kind, "panel": 1})


HEIGHT = 300


def _component(solved: SceneResult, k: int) -> Figure:
    exact = solved.solution.trajectory.omega_body
    omega = exact[:, k]
    room = float(np.linalg.norm(exact, axis=1).max()) * STEADY_RATE
    panel = Panel(
        "t, s",
        f"ω{AXES[k]}, rad/s",
        f"ω{AXES[k]}",
        y_range=(float(omega.min()) - room, float(omega.max()) + room),
        x_range=_window(solved),
    )
    overlay = {"kind": "omega", "component": k, "panel": 1, "exact": "exact"}
    return drawing([], [panel], HEIGHT, overlay)


def _window(solved: SceneResult) -> Range:
    return 0.0, float(solved.solution.trajectory.t[-1])


def _errors(curves: list[FloatArray], floor: float) -> Range:
    return error_range([claimed(curve, floor) for curve in curves], floor)
