"""Curves on a sphere or an ellipsoid, to be turned with the mouse."""

from typing import Any

import numpy as np

from ....scenarios import FloatArray
from .plot import INK, WIRE, Trace, packed

#: Lines that show a surface: circles of latitude, half circles of longitude, points on each.
LATITUDES, LONGITUDES, POINTS = 5, 8, 25
#: Length of the axes relative to the surface; distance of the eye, in sides of the scene.
STICK_OUT = 1.18
#: Half side of the scene, including the names of the axes.
EDGE = 1.3
EYE_DISTANCE = 1.25
#: Smallest vertical part of the eye's direction: the curve is seen from above.
LEAST_HEIGHT = 0.45


def surface(semi_axes: FloatArray, names: tuple[str, str, str]) -> list[Trace]:
    """A wire frame with its three axes named; semi-axes along x, y, z, (3,)."""
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


def curve(points: FloatArray, style: dict[str, Any]) -> Trace:
    """A curve in space, (n, 3), in the style of its method."""
    return _trace(points, **style)


def dot(point: FloatArray) -> Trace:
    """The point where the motion starts."""
    return _trace(point[None, :], mode="markers", marker={"color": INK, "size": 5})


def view(semi_axes: FloatArray, towards: FloatArray) -> dict[str, Any]:
    """Plotly's 3-D scene without a box around it, the eye on the side where the curve is."""
    size = float(np.linalg.norm(towards))
    direction = towards / size if size else np.array([1.0, 1.0, 1.0])
    # Askew, so that no axis points straight at the eye.
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
    around = np.linspace(0, 2 * np.pi, POINTS)
    heights = np.linspace(-1, 1, LATITUDES + 2)[1:-1]
    radii = np.sqrt(1 - heights**2)
    return [
        np.column_stack([r * np.cos(around), r * np.sin(around), np.full(POINTS, h)])
        for r, h in zip(radii, heights, strict=True)
    ]


def _longitudes() -> list[FloatArray]:
    down = np.linspace(0, np.pi, POINTS)
    return [
        np.column_stack([np.sin(down) * np.cos(a), np.sin(down) * np.sin(a), np.cos(down)])
        for a in 2 * np.pi * np.arange(LONGITUDES) / LONGITUDES
    ]
