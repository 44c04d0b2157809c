"""The lines of runs in pictures; on pages a script draws them from the motions."""

from collections.abc import Callable, Iterable, Iterator
from typing import Any

import numpy as np

from ....reference import ExactMotion
from ....scenarios import FloatArray, Trajectory
from ..analysis.report_data import Compared, SceneRuns
from .dense_motion import dense_motion
from .drawn_body import DrawnBody, drawn_body
from .plot import Figure, Trace, exact_look, line, method_style
from .solid import curve

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
        exact = _exact(scene) if overlay["exact"] == "exact" else dense_motion(scene)
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


def _exact(scene: SceneRuns) -> Trajectory:
    end = float(scene.exact.solution.trajectory.t[-1])
    return ExactMotion(scene.exact.scenario).outline(np.linspace(0.0, end, SAMPLES))


def _tilt(motion: Trajectory, _: dict[str, Any], body: DrawnBody) -> FloatArray:
    tips = motion.to_world(body.axis_body)
    across = np.linalg.norm(np.cross(tips, body.up_world), axis=1)
    return np.asarray(np.degrees(np.arctan2(across, tips @ body.up_world)))


def _component(motion: Trajectory, overlay: dict[str, Any], _: DrawnBody) -> FloatArray:
    return np.asarray(motion.omega_body[:, overlay["component"]])


def _on_ellipsoid(motion: Trajectory, overlay: dict[str, Any], _: DrawnBody) -> FloatArray:
    points = motion.omega_body @ np.array(overlay["matrix"]).T
    near = np.linalg.norm(points, axis=1) <= overlay["within"]
    return np.where(near[:, None], points, np.nan)


def _omega_world(motion: Trajectory, overlay: dict[str, Any], _: DrawnBody) -> FloatArray:
    return np.asarray(motion.to_world(motion.omega_body) @ np.array(overlay["matrix"]).T)


def _axis(motion: Trajectory, overlay: dict[str, Any], body: DrawnBody) -> FloatArray:
    return np.asarray(motion.to_world(body.axis_body) @ np.array(overlay["matrix"]).T)


def _unrolled(motion: Trajectory, overlay: dict[str, Any], body: DrawnBody) -> FloatArray:
    x, y, up = _axis(motion, overlay, body).T
    azimuth, tilt = np.unwrap(np.arctan2(y, x)), np.arctan2(np.hypot(x, y), up)
    jumps = np.abs(np.diff(azimuth, prepend=azimuth[:1])) > JUMP
    return np.asarray(np.degrees(np.column_stack([np.where(jumps, np.nan, azimuth), tilt])))


MOTIONS: dict[str, Lines] = {
    "tilt": _tilt,
    "omega": _component,
    "omega_body": _on_ellipsoid,
    "omega_world": _omega_world,
    "axis": _axis,
    "axis_unrolled": _unrolled,
}
ERRORS: dict[str, Callable[[Compared], FloatArray]] = {
    "attitude_error": lambda run: np.degrees(run.series["attitude"]),
    "omega_error": lambda run: run.series["omega"],
    "defect": lambda run: run.defect,
}
