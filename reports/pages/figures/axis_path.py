"""Figures of paths in space: of a top's axis on the unit sphere, and of the tip of ω (Poinsot)."""

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from ....reference.rotational_problem import rotational_problem
from ....scenarios import FloatArray, Trajectory
from ..analysis.report_data import SceneRuns
from .drawn_body import axis_body, dense_motion
from .plot import (
    INK,
    WIRE,
    Figure,
    Panel,
    Range,
    Trace,
    drawing,
    packed,
    padded,
    square,
    start_dot,
)

#: Number of circles of latitude and number of half circles of longitude that show a surface; number
#: of points on each.
LATITUDES, LONGITUDES, POINTS = 5, 8, 25
#: Length of the drawn axes, in semi-axes of the surface.
STICK_OUT = 1.18
#: Half side of the 3-D plot, in which the names of the axes have room, in semi-axes of the surface.
EDGE = 1.3
#: Distance of the eye from the middle of the plot, in the unit of Plotly's camera.
EYE_DISTANCE = 1.25
#: Smallest vertical component of the eye's direction, so that the curve is seen from above.
LEAST_HEIGHT = 0.45


def _surface(semi_axes: FloatArray, names: tuple[str, str, str]) -> list[Trace]:
    """Return the traces of an ellipsoid's wire frame and of its three axes.

    Parameters
    ----------
    semi_axes : semi-axes of the ellipsoid along x, y and z, (3,)
    names : names of the axes
    """
    wires = [*_latitudes(), *_longitudes()]
    gap = np.full((1, 3), np.nan)
    net = np.vstack([piece for wire in wires for piece in (wire, gap)]) * semi_axes
    spokes = (
        np.vstack(
            [
                piece
                for k in range(3)
                for piece in (np.zeros((1, 3)), STICK_OUT * np.eye(3)[k : k + 1], gap)
            ]
        )
        * semi_axes
    )
    labels = [text for name in names for text in ("", name, "")]
    return [
        _trace(net, mode="lines", line={"color": WIRE, "width": 1}),
        _trace(
            spokes,
            mode="lines+text",
            text=labels,
            line={"color": WIRE, "width": 3},
            textfont={"color": INK},
        ),
    ]


def _on_surface(
    semi_axes: FloatArray,
    names: tuple[str, str, str],
    points: FloatArray,
    height: int,
    overlay: dict[str, Any],
) -> Figure:
    """Return a figure of an ellipsoid and its axes, with the first point of a curve on it.

    The page's script draws the curve itself. Here its points only determine where it starts, and
    from which side the ellipsoid is seen.

    Parameters
    ----------
    semi_axes : semi-axes of the ellipsoid along x, y and z, in the unit of `points`, (3,)
    names : names of the three axes, written at their ends
    points : points of the curve, (n, 3)
    height : height of the figure, pixels
    overlay : which curve the script draws, from `_overlay`
    """
    start = _trace(points[:1], mode="markers", marker={"color": INK, "size": 5})
    shown = {"height": height, "scene": _view(semi_axes, points.mean(axis=0))}
    traces = [*_surface(semi_axes, names), start]
    return {"data": traces, "layout": shown, "overlays": [overlay]}


def _overlay(kind: str, matrix: FloatArray, **panel: int) -> dict[str, Any]:
    """Return what the page's script needs to draw a curve of a motion's first turns.

    The dictionary has the parameters under their names; a `panel` is missing if it is left out. The
    entry `exact` names the motion among the page's data: "beginning", the first turns.

    Parameters
    ----------
    kind : which curve the script draws, such as "axis"
    matrix : matrix from components along body or world axes, depending on the kind, to components
        along the axes of the plot, (2, 3) or (3, 3)
    panel : `panel=k` for the k-th panel, counted from 1; left out for a figure without panels
    """
    return {"kind": kind, "exact": "beginning"} | panel | {"matrix": matrix.tolist()}


def _view(semi_axes: FloatArray, towards: FloatArray) -> dict[str, Any]:
    """Return the settings of a 3-D plot in Plotly: its ranges, proportions and camera.

    Parameters
    ----------
    semi_axes : semi-axes of the ellipsoid that is shown, (3,)
    towards : direction of the middle of the curve, (3,); the camera is on that side
    """
    direction = _unit(towards, np.ones(3))
    # The direction is tilted, so that no axis points straight at the camera.
    direction = direction + np.array([0.35, 0.5, 0.0])
    direction[2] = max(direction[2], LEAST_HEIGHT)
    eye = EYE_DISTANCE * direction / np.linalg.norm(direction)
    reach = EDGE * semi_axes
    sides = dict(zip("xyz", (reach / reach.max()).tolist(), strict=True))
    return {
        "aspectmode": "manual",
        "aspectratio": sides,
        "camera": {"eye": dict(zip("xyz", eye.tolist(), strict=True))},
        **{
            f"{axis}axis": {"visible": False, "showspikes": False, "range": [-limit, limit]}
            for axis, limit in zip("xyz", reach.tolist(), strict=True)
        },
    }


def _trace(points: FloatArray, **properties: Any) -> Trace:
    """Return Plotly's trace of a curve in space through points, (n, 3).

    Parameters
    ----------
    properties : further properties of the trace
    """
    return {
        "type": "scatter3d",
        "x": packed(points[:, 0]),
        "y": packed(points[:, 1]),
        "z": packed(points[:, 2]),
        "showlegend": False,
        "hoverinfo": "skip",
        **properties,
    }


def _latitudes() -> list[FloatArray]:
    """Return circles of latitude on the unit sphere, (POINTS, 3) each."""
    around = np.linspace(0, 2 * np.pi, POINTS)
    heights = np.linspace(-1, 1, LATITUDES + 2)[1:-1]
    radii = np.sqrt(1 - heights**2)
    return [
        np.column_stack([r * np.cos(around), r * np.sin(around), np.full(POINTS, h)])
        for r, h in zip(radii, heights, strict=True)
    ]


def _longitudes() -> list[FloatArray]:
    """Return half circles of longitude on the unit sphere, (POINTS, 3) each."""
    down = np.linspace(0, np.pi, POINTS)
    return [
        np.column_stack([np.sin(down) * np.cos(a), np.sin(down) * np.sin(a), np.cos(down)])
        for a in 2 * np.pi * np.arange(LONGITUDES) / LONGITUDES
    ]


UP = np.array([0.0, 0.0, 1.0])
HEIGHT = 400
#: Range of azimuth shown at first, degrees; the rest can be dragged into view.
ONE_TURN = 360.0
#: Factor of room around the path as seen from above.
MARGIN = 1.1
#: Least half width of what a panel shows, without its margin: on the unit sphere, or relative to
#: the largest ω. A smaller path looks like a point.
NARROWEST = 1e-6
#: Range of tilt below which the tilt counts as steady, degrees; and the margin that is then shown
#: on both sides of it, degrees.
STEADY, STEADY_ROOM = 1e-6, 0.5


def axis_path(scene: SceneRuns) -> list[Figure]:
    """Return three figures of the path of the axis `axis_body`, such as that of symmetry.

    They show the path on the unit sphere, seen from above, and unrolled into azimuth and tilt.
    """
    scenario, motion = scene.exact.scenario, dense_motion(scene)
    # The matrix from world components to two horizontal components and the upward one, (3, 3). Up
    # is −g, or z without gravity.
    R_upright_world = _frame_about(_unit(-scenario.gravity_world, UP))
    # The direction of the axis, (n, 3), in these components.
    exact = np.asarray(motion.to_world(axis_body(scenario)) @ R_upright_world.T)
    overlay = _overlay("axis", R_upright_world)
    return [
        _on_surface(np.ones(3), ("x", "y", "up"), exact, HEIGHT, overlay),
        _from_above(exact, R_upright_world),
        _unrolled_figure(exact, R_upright_world),
    ]


def _from_above(exact: FloatArray, R_upright_world: FloatArray) -> Figure:
    """Return a figure of the axis's path seen from above.

    Parameters
    ----------
    exact : directions of the axis, (n, 3): two horizontal components and the upward one
    R_upright_world : matrix from world components to these, (3, 3)
    """
    widest = MARGIN * max(float(np.abs(exact[:, :2]).max()), NARROWEST)
    panel = square(("level component, x", "level component, y", "From above"), widest)
    traces = [start_dot(exact[0, 0], exact[0, 1], 1)]
    return drawing(traces, [panel], HEIGHT, _overlay("axis", R_upright_world[:2], panel=1))


def _unrolled_figure(exact: FloatArray, R_upright_world: FloatArray) -> Figure:
    """Return a figure of the axis's path as tilt against azimuth, degrees.

    Parameters
    ----------
    exact : directions of the axis, (n, 3): two horizontal components and the upward one
    R_upright_world : matrix from world components to these, (3, 3)
    """
    azimuth, tilt = _unrolled(exact)
    framed = tilt
    if np.ptp(tilt) < STEADY:
        framed = tilt[:1] + np.array([-1.0, 1.0]) * STEADY_ROOM
    low, high = padded(framed)
    # The axis of tilt points down, so that the curve is higher where the body's axis is higher.
    panel = Panel(
        x_title="azimuth α, °",
        y_title="tilt β from the upward vertical, °",
        heading="Unrolled",
        x_range=_first_turn(azimuth),
        y_range=(high, low),
    )
    traces = [start_dot(azimuth[0], tilt[0], 1)]
    return drawing(traces, [panel], HEIGHT, _overlay("axis_unrolled", R_upright_world, panel=1))


def _first_turn(azimuth: FloatArray) -> Range:
    """Return the range of a path's azimuths, (n,), to show, degrees: at most the first turn."""
    if np.ptp(azimuth) <= ONE_TURN:
        return padded(azimuth)
    onwards = np.sign(azimuth[-1] - azimuth[0]) or 1.0
    return padded(azimuth[0] + np.array([0.0, onwards * ONE_TURN]))


def _unit(vector: FloatArray, otherwise: FloatArray) -> FloatArray:
    """Return the unit vector along a vector, (3,); `otherwise` if the vector is zero."""
    size = float(np.linalg.norm(vector))
    return vector / size if size else otherwise


def _unrolled(tips: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return azimuth and tilt of directions, degrees, (n,) each.

    Parameters
    ----------
    tips : unit vectors, (n, 3): two horizontal components and the upward one
    """
    azimuth = np.unwrap(np.arctan2(tips[:, 1], tips[:, 0]))
    tilt = np.arctan2(np.hypot(tips[:, 0], tips[:, 1]), tips[:, 2])
    return np.degrees(azimuth), np.degrees(tilt)


POLHODE_HEIGHT = 460
#: Factor of room around the herpolhode.
HERPOLHODE_MARGIN = 1.15
#: Distance from the ellipsoid's centre up to which a run is drawn, in longest semi-axes.
OFF_THE_ELLIPSOID = 1.5


def polhode(scene: SceneRuns) -> list[Figure]:
    """Return figures of the polhode and of the herpolhode; none for a body that never turns.

    The polhode lies on the ellipsoid Σ Iₖ ωₖ² = 2T in principal axes, where T is the largest
    rotational energy of the exact motion. ω/√2T is drawn, so that the semi-axes are 1/√Iₖ. The
    herpolhode is seen along the exact L at the start (Landau & Lifshitz, Mechanics, §37; Goldstein
    §5.6).
    """
    exact = dense_motion(scene)
    problem = rotational_problem(scene.exact.scenario)
    moments = np.array(problem.moments, dtype=float)
    R_axes_body = Rotation.from_quat(np.array(problem.q_axes_body, dtype=float), scalar_first=True)
    omega_axes = R_axes_body.apply(np.array(exact.omega_body))
    root_energy = float(np.sqrt((omega_axes**2 @ moments).max()))
    if root_energy == 0:
        return []
    semi_axes = 1 / np.sqrt(moments)
    overlay = _overlay("omega_body", R_axes_body.as_matrix() / root_energy)
    overlay["within"] = OFF_THE_ELLIPSOID * float(semi_axes.max())
    L_body = R_axes_body.inv().apply(omega_axes[0] * moments)
    along = _unit(exact.R_world_body[0].apply(L_body), UP)
    tips = omega_axes / root_energy
    return [
        _on_surface(semi_axes, ("1", "2", "3"), tips, POLHODE_HEIGHT, overlay),
        _herpolhode(exact, _frame_about(along)),
    ]


def _herpolhode(exact: Trajectory, R_level_world: FloatArray) -> Figure:
    """Return a figure of the path of ω's tip, projected on the plane normal to the initial L.

    Parameters
    ----------
    exact : the exact motion
    R_level_world : matrix, (3, 3), from world components to those along two axes normal to the
        initial L, and along L
    """
    flat = (exact.to_world(exact.omega_body) @ R_level_world.T)[:, :2]
    fastest = float(np.linalg.norm(exact.omega_body, axis=1).max())
    widest = HERPOLHODE_MARGIN * max(float(np.abs(flat).max()), NARROWEST * fastest)
    title = "ω across the initial L, rad/s"
    panel = square((title, title, "Herpolhode"), widest)
    overlay = _overlay("omega_world", R_level_world[:2], panel=1)
    return drawing([start_dot(flat[0, 0], flat[0, 1], 1)], [panel], POLHODE_HEIGHT, overlay)


def _frame_about(third: FloatArray) -> FloatArray:
    """Return the axes of a right-handed frame as rows of a matrix, (3, 3).

    Parameters
    ----------
    third : the third axis, a unit vector, (3,)
    """
    first = np.eye(3)[np.argmin(np.abs(third))]
    first = first - (first @ third) * third
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(third, first), third])
