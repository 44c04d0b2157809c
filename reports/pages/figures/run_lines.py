"""The lines of runs that a page's script draws from its motions, for pictures without a script."""

from collections.abc import Callable, Iterable, Iterator
from typing import Any

import numpy as np

from ....reference import ExactMotion
from ....scenarios import FloatArray, Trajectory
from ..analysis.report_data import Compared, SceneRuns
from .drawn_body import DrawnBody, drawn_body
from .plot import Figure, Trace, exact_look, line, method_style
from .solid import curve

#: Of the exact motion over the whole window.
SAMPLES = 4000

Lines = Callable[[Trajectory, dict[str, Any], DrawnBody], FloatArray]


def with_runs(figure: Figure, scene: SceneRuns, runs: Iterable[Compared]) -> Figure:
    """The same with the exact motion and the runs where the figure leaves them to the script."""
    overlays = figure.get("overlays", [])
    drawn = [trace for overlay in overlays for trace in _drawn(overlay, scene, list(runs))]
    return {"data": [*figure["data"], *drawn], "layout": figure["layout"]}


def _drawn(overlay: dict[str, Any], scene: SceneRuns, runs: list[Compared]) -> Iterator[Trace]:
    assert scene.solved is not None, "figures are of solved scenes"
    body, panel = drawn_body(scene.solved), overlay.get("panel", 1)
    if overlay.get("exact"):
        end = float(scene.solved.solution.trajectory.t[-1])
        exact = ExactMotion(scene.solved.scenario).outline(np.linspace(0.0, end, SAMPLES))
        yield line(exact.t, MOTIONS[overlay["kind"]](exact, overlay, body), panel, **exact_look())
    for run in runs:
        style = method_style(run.runs.label, run.runs.style)
        if overlay["kind"] in ERRORS:
            yield line(run.motion.t, ERRORS[overlay["kind"]](run), panel, **style)
            continue
        values = MOTIONS[overlay["kind"]](run.motion, overlay, body)
        if values.ndim == 1:
            yield line(run.motion.t, values, panel, **style)
        elif "panel" in overlay:
            yield line(values[:, 0], values[:, 1], panel, **style)
        else:
            yield curve(values, style)


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
    return np.asarray(np.degrees(np.column_stack([azimuth, tilt])))


MOTIONS: dict[str, Lines] = {
    "tilt": _tilt,
    "omega": _component,
    "omega_body": _on_ellipsoid,
    "omega_world": _omega_world,
    "axis": _axis,
    "axis_unrolled": _unrolled,
}
ERRORS: dict[str, Callable[[Compared], FloatArray]] = {
    "attitude_error": lambda run: np.degrees(run.series.attitude),
    "omega_error": lambda run: run.series.omega,
}
