"""The path of a top's axis on the unit sphere: nutation and precession, drawn."""

import numpy as np

from ....scenarios import FloatArray, Scenario, Trajectory
from ...results.store import SceneResult
from ..analysis.report_data import Compared
from . import solid
from .plot import (
    Figure,
    Panel,
    Range,
    exact_look,
    layout,
    line,
    method_style,
    padded,
    start_dot,
    thinned,
)

GLOBE = ((0.0, 0.3), (0.0, 1.0))
FROM_ABOVE = ((0.36, 0.62), (0.0, 1.0))
UNROLLED = ((0.71, 1.0), (0.0, 1.0))
#: Degrees of azimuth unrolled at first; more is there to be dragged into view.
ONE_TURN = 360.0
#: Room around the path as seen from above, as a factor.
MARGIN = 1.1
#: A smaller path, in radians, is drawn as the point it is.
NARROWEST = 1e-6
#: Degrees; where the azimuth jumps by more between samples, the axis has passed the vertical.
JUMP = 90.0
#: Degrees; a tilt that changes less is steady, and is framed with this room on either side.
STEADY, STEADY_ROOM = 1e-6, 0.5


def axis_path(found: SceneResult, compared: tuple[Compared, ...]) -> Figure:
    """On the sphere, from above, and unrolled into azimuth and tilt."""
    axis_body, R_upright_world = _axis_body(found.scenario), _upright(found.scenario)

    def tips(motion: Trajectory) -> FloatArray:
        """Where the axis points, (n, 3): two level components and up."""
        axis_world = motion.to_world(axis_body)
        return np.asarray(axis_world[thinned(len(motion.t))] @ R_upright_world.T)

    exact = tips(found.solution.trajectory)
    curves = [(exact, exact_look())] + [
        (tips(run.motion), method_style(run.runs.label, run.runs.look)) for run in compared
    ]
    traces = solid.surface(np.ones(3), ("x", "y", "up"))
    for points, look in curves:
        traces.append(solid.curve(points, look))
        traces.append(line(points[:, 0], points[:, 1], 1, **look))
        azimuth, tilt = _unrolled(points)
        traces.append(line(_broken(azimuth), tilt, 2, **look))
    azimuth, tilt = _unrolled(exact)
    traces += [
        solid.dot(exact[0]),
        start_dot(exact[0, 0], exact[0, 1], 1),
        start_dot(azimuth[0], tilt[0], 2),
    ]
    figure: Figure = {"data": traces, "layout": layout([_panels(exact)], height=460)}
    figure["layout"]["scene"] = solid.view(np.ones(3), exact.mean(axis=0), GLOBE)
    return figure


def _panels(exact: FloatArray) -> list[Panel]:
    widest = MARGIN * max(float(np.abs(exact[:, :2]).max()), NARROWEST)
    azimuth, tilt = _unrolled(exact)
    if np.ptp(tilt) < STEADY:
        tilt = tilt[:1] + np.array([-1.0, 1.0]) * STEADY_ROOM
    low, high = padded(tilt)
    return [
        Panel(
            x_title="level component, x",
            y_title="level component, y",
            heading="From above",
            x_range=(-widest, widest),
            y_range=(-widest, widest),
            equal_scales=True,
            domain=FROM_ABOVE,
        ),
        # Upside down: where the axis is higher, its tilt is smaller.
        Panel(
            x_title="azimuth α, °",
            y_title="tilt β from the upward vertical, °",
            heading="Unrolled",
            x_range=_first_turn(azimuth),
            y_range=(high, low),
            domain=UNROLLED,
        ),
    ]


def _broken(azimuth: FloatArray) -> FloatArray:
    """With a gap at every jump."""
    jumps = np.abs(np.diff(azimuth, prepend=azimuth[:1])) > JUMP
    return np.where(jumps, np.nan, azimuth)


def _first_turn(azimuth: FloatArray) -> Range:
    """All of the azimuths, or one turn from the start on."""
    if np.ptp(azimuth) <= ONE_TURN:
        return padded(azimuth)
    onwards = np.sign(azimuth[-1] - azimuth[0]) or 1.0
    return padded(azimuth[0] + np.array([0.0, onwards * ONE_TURN]))


def _axis_body(scenario: Scenario) -> FloatArray:
    """From the pivot to the com; the third body axis where they coincide, (3,)."""
    length = float(np.linalg.norm(scenario.body.com))
    return scenario.body.com / length if length else np.array([0.0, 0.0, 1.0])


def _upright(scenario: Scenario) -> FloatArray:
    """World components to two level components and up; up is −g, or z without gravity, (3, 3)."""
    gravity_world = scenario.gravity_world
    size = float(np.linalg.norm(gravity_world))
    up = -gravity_world / size if size else np.array([0.0, 0.0, 1.0])
    return frame_about(up)


def frame_about(third: FloatArray) -> FloatArray:
    """Rows e1, e2, e3 of a right-handed frame with e3 given; x and y themselves for z, (3, 3)."""
    first = np.eye(3)[np.argmin(np.abs(third))]
    first = first - (first @ third) * third
    first /= np.linalg.norm(first)
    return np.vstack([first, np.cross(third, first), third])


def _unrolled(tips: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Azimuth and tilt, degrees."""
    azimuth = np.unwrap(np.arctan2(tips[:, 1], tips[:, 0]))
    tilt = np.arctan2(np.hypot(tips[:, 0], tips[:, 1]), tips[:, 2])
    return np.degrees(azimuth), np.degrees(tilt)
