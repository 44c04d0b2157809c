"""Pictures of a link that need no script: its solid ellipsoid, and angles over time.

A uniform ellipsoid of semi-axes a has the second moments of mass m a² / 5 along them; those of a
tensor I are (tr I / 2) E − I (Goldstein, Classical Mechanics, §5.3). A tensor that no body can have
has no ellipsoid: one of its second moments is negative.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ....scenarios import FloatArray
from ..analysis.trace_style import TraceStyle

#: Size of the picture; margins for numbers at its left and bottom.
WIDTH, HEIGHT, LEFT, BOTTOM, TOP, RIGHT = 320.0, 200.0, 40.0, 30.0, 10.0, 12.0
#: Possible upper ends of the axis of angles, degrees; the smallest sufficient one is used.
TOPS = (1e-3, 1e-2, 0.1, 1.0, 5.0, 15.0, 45.0, 90.0, 180.0)


def time_curves(
    times: FloatArray, of_runs: Sequence[tuple[str, TraceStyle, FloatArray]]
) -> dict[str, Any]:
    """Curves of angles, with positions and labels of ticks, in the picture's units.

    Parameters
    ----------
    times : s, (n,), from 0 on
    of_runs : name, style and angles in degrees, (n,), of each
    """
    most = max(float(angles.max()) for _, _, angles in of_runs)
    top = next((limit for limit in TOPS if most <= limit), TOPS[-1])
    end = float(times[-1])

    def x(time: FloatArray | float) -> FloatArray:
        return np.asarray(LEFT + (WIDTH - LEFT - RIGHT) * np.asarray(time) / end)

    def y(angle: FloatArray | float) -> FloatArray:
        return np.asarray(HEIGHT - BOTTOM - (HEIGHT - BOTTOM - TOP) * np.asarray(angle) / top)

    curves = [
        {
            "name": name,
            "colour": style.colour,
            "dash": style.dash,
            "points": " ".join(
                f"{a:.1f},{b:.1f}" for a, b in zip(x(times), y(angles), strict=True)
            ),
        }
        for name, style, angles in of_runs
    ]
    seconds = [(float(x(t)), f"{t:g}") for t in range(int(end) + 1)]
    degrees = [(float(y(a)), f"{a:g}°") for a in (0.0, top / 3, 2 * top / 3, top)]
    return {"curves": curves, "x_ticks": seconds, "y_ticks": degrees}


#: For a solid ellipsoid, a² = 5 × second moment / mass.
SOLID = 5.0
#: Pairs of axes that a view shows, to the right and up, and the axis that it looks along.
VIEWS = ((0, 1), (0, 2), (1, 2))
AXES = "xyz"
#: Width and height of a view; its margin.
SIZE, MARGIN = 200.0, 26.0
#: Smallest size of anything drawn.
LEAST = 1.5
#: Lengths of scale bars, m: 1, 2 or 5 times a power of ten, at most this part of the width.
BAR = 0.4


@dataclass(frozen=True, eq=False)
class Solid:
    """The data that an ellipsoid is drawn from.

    Attributes
    ----------
    name, colour, dash : of the configuration that holds it; the file's body has the text's colour
    com : m, (3,)
    squares : matrix of the squared semi-axes, m², (3, 3); None for a tensor that no body can have
    """

    name: str
    colour: str
    dash: str
    com: FloatArray
    squares: FloatArray | None


def solid_squares(mass: float, inertia: FloatArray) -> FloatArray | None:
    """The squares of the ellipsoid's semi-axes as a matrix, m², (3, 3); None if there is none."""
    if not mass > 0:
        return None
    second = (np.trace(inertia) / 2 * np.eye(3) - inertia) * (SOLID / mass)
    rounding = 16 * float(np.finfo(float).eps) * float(np.abs(second).max())
    moments = np.linalg.eigvalsh(second)
    return second if moments[-1] > 0 and moments[0] >= -rounding else None


def views(solids: Sequence[Solid]) -> list[dict[str, Any]]:
    """Three views at one scale, which all solids and the frame's origin fit.

    Each has the names of the axes to the `right` and `up`, the place of the `origin`, `ellipses`,
    the file's first, and `bar`, the length that `bar_text` has in the picture.
    """
    reaches = [np.zeros(3) if s.squares is None else _reach(s.squares) for s in solids]
    low = np.min([np.zeros(3), *(s.com - r for s, r in zip(solids, reaches, strict=True))], axis=0)
    high = np.max([np.zeros(3), *(s.com + r for s, r in zip(solids, reaches, strict=True))], axis=0)
    width = float((high - low).max()) or 1.0
    scale, middle = (SIZE - 2 * MARGIN) / width, (low + high) / 2
    return [_view(solids, right, up, scale, middle) for right, up in VIEWS]


def _view(
    solids: Sequence[Solid], right: int, up: int, scale: float, middle: FloatArray
) -> dict[str, Any]:
    def place(point: FloatArray) -> tuple[float, float]:
        x, y = (point - middle)[[right, up]] * scale
        return float(SIZE / 2 + x), float(SIZE / 2 - y)

    length = _round_length(BAR * SIZE / scale)
    return {
        "right": AXES[right],
        "up": AXES[up],
        "origin": place(np.zeros(3)),
        "ellipses": [_ellipse(solid, place(solid.com), (right, up), scale) for solid in solids],
        "bar": length * scale,
        "bar_text": f"{length:g} m" if length >= 0.1 else f"{1000 * length:g} mm",
    }


def _ellipse(
    solid: Solid, centre: tuple[float, float], plane: tuple[int, int], scale: float
) -> dict[str, Any]:
    """An ellipse, y downwards, `turn` in degrees, clockwise; without radii, a tensor of no body."""
    x, y = centre
    drawn: dict[str, Any] = {
        "name": solid.name,
        "colour": solid.colour,
        "dash": solid.dash,
        "x": x,
        "y": y,
    }
    if solid.squares is None:
        return drawn | {"rx": 0.0}
    squares, axes = np.linalg.eigh(solid.squares[np.ix_(plane, plane)])
    ry, rx = np.maximum(np.sqrt(np.maximum(squares, 0.0)) * scale, LEAST)
    turn = -float(np.degrees(np.arctan2(axes[1, 1], axes[0, 1])))
    return drawn | {"rx": float(rx), "ry": float(ry), "turn": turn}


def _reach(squares: FloatArray) -> FloatArray:
    """Half extents of an ellipsoid along the axes, m, (3,)."""
    return np.asarray(np.sqrt(np.maximum(np.diag(squares), 0.0)))


def _round_length(most: float) -> float:
    power = 10.0 ** np.floor(np.log10(most))
    return float(max(digit * power for digit in (1, 2, 5) if digit * power <= most * (1 + 1e-9)))
