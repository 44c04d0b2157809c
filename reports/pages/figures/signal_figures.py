"""Figures of tilt and angular velocity over time, and of the errors of runs.

The page's script draws the lines, from the motions that the page carries. A figure made here only
has axes, and states which line belongs in which panel (`overlays`).
"""

import math

import numpy as np

from ....scenarios import FloatArray
from ...harness.comparison.defects import LEAST_ROUNDING
from ...results.results import SceneResult
from ..analysis.report_data import SceneRuns
from .drawn_body import drawn_body
from .plot import (
    Figure,
    Panel,
    Range,
    claimed,
    drawing,
    error_range,
)

#: Domains (`Panel.domain`) of the panel of tilt, and of the panel of attitude errors below it.
TILT, DIFFERENCE = ((0.0, 1.0), (0.52, 1.0)), ((0.0, 1.0), (0.0, 0.42))
#: Least margin below and above the tilt in its panel, degrees.
STEADY = 0.5
#: Margin above and below a component of ω, as a fraction of the largest ω.
STEADY_RATE = 0.05
AXES = ("₁", "₂", "₃")


def tilt_figure(scene: SceneRuns) -> Figure:
    """Return a figure of the tilt β(t) in one panel, and of attitude errors in a panel below it."""
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
    """Return a figure of each component of ω, body axes, and one of the error of ω."""
    solved, runs = scene.exact, scene.compared
    figures = [_component(solved, k) for k in range(3)]
    curves = [run.series["omega"] for run in runs]
    axes = "‖Δω‖ / max ‖ω‖", "Difference"
    drawn = _over_time(solved, "omega_error", axes, curves, solved.solution.uncertainty.omega)
    return [*figures, drawn]


def defect_figure(scene: SceneRuns) -> Figure:
    """Return a figure of the largest defect in any signal over each interval between samples."""
    curves = [run.defect for run in scene.compared]
    return _over_time(scene.exact, "defect", ("relative, or rad", ""), curves, LEAST_ROUNDING)


def _over_time(
    solved: SceneResult, kind: str, axes: tuple[str, str], curves: list[FloatArray], floor: float
) -> Figure:
    """Return a figure with one panel of errors against time.

    Parameters
    ----------
    kind : which curves the page's script draws
    axes : title of the axis of errors, and heading of the panel
    curves : the errors of each run at its samples, which determine the range of the axis
    floor : the reference's uncertainty, or what rounding may cause, in the unit of the errors
    """
    y_range, x_range = _errors(curves, floor), _window(solved)
    panel = Panel("t, s", *axes, y_range=y_range, x_range=x_range, log_y=True, floor=floor)
    return drawing([], [panel], HEIGHT, {"kind": kind, "panel": 1})


HEIGHT = 300


def _component(solved: SceneResult, k: int) -> Figure:
    """Return a figure of the k-th component of ω, body axes, over time."""
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
    """Return the range of the time axis, s: from 0 to the last time of the exact motion."""
    return 0.0, float(solved.solution.trajectory.t[-1])


def _errors(curves: list[FloatArray], floor: float) -> Range:
    """Return the range of an axis of errors, from half of `floor` to above the largest error.

    Parameters
    ----------
    curves : the errors of each run at its samples
    floor : the least error that is drawn
    """
    return error_range([claimed(curve, floor) for curve in curves], floor)
