"""Pictures of a link that need no script: its solid ellipsoid, and angles over time.

A uniform ellipsoid of semi-axes a has the second moments of mass m a² / 5 along them; those of a
tensor I are (tr I / 2) E − I (Goldstein, Classical Mechanics, §5.3). A tensor that no body can have
has no ellipsoid: one of its second moments is negative.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...engines import BodyReading
from ...scenarios import FloatArray
from ..pages.analysis.trace_style import TraceStyle

#: Size of the picture of curves; margins for numbers at its left and bottom.
WIDTH, HEIGHT, LEFT, BOTTOM, TOP, RIGHT = 320.0, 200.0, 40.0, 30.0, 10.0, 12.0
#: Possible upper ends of the axis of angles, degrees; the smallest sufficient one is used.
TOPS = (1e-3, 1e-2, 0.1, 1.0, 5.0, 15.0, 45.0, 90.0, 180.0)
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
class Curve:
    """Angles of one configuration, degrees, (n,), and how they are drawn."""

    name: str
    style: TraceStyle
    angles: FloatArray


def time_curves(times: FloatArray, curves: Sequence[Curve]) -> dict[str, Any]:
    """The curves, with positions and labels of ticks, in the picture's units.

    Parameters
    ----------
    times : s, (n,), from 0 on
    """
    most = max(float(curve.angles.max()) for curve in curves)
    top = next((limit for limit in TOPS if most <= limit), TOPS[-1])
    end = float(times[-1])
    right, up = (WIDTH - LEFT - RIGHT) / end, (HEIGHT - BOTTOM - TOP) / top
    base = HEIGHT - BOTTOM
    drawn = [
        {
            "name": curve.name,
            "style": curve.style,
            "points": " ".join(
                f"{LEFT + time * right:.1f},{base - angle * up:.1f}"
                for time, angle in zip(times, curve.angles, strict=True)
            ),
        }
        for curve in curves
    ]
    return {
        "curves": drawn,
        "x_ticks": [(LEFT + second * right, f"{second:g}") for second in range(int(end) + 1)],
        "y_ticks": [(base - a * up, f"{a:g}°") for a in (0.0, top / 3, 2 * top / 3, top)],
    }


@dataclass(frozen=True, eq=False)
class Solid:
    """The body that an ellipsoid is drawn of, and how."""

    name: str
    style: TraceStyle
    body: BodyReading

    @property
    def squares(self) -> FloatArray | None:
        """Matrix of the squared semi-axes, m², (3, 3); None for a tensor that no body can have."""
        return solid_squares(self.body.mass, self.body.inertia_com)

    @property
    def reach(self) -> FloatArray:
        """Half extents along the axes, m, (3,)."""
        squares = np.zeros((3, 3)) if self.squares is None else self.squares
        return np.asarray(np.sqrt(np.maximum(np.diag(squares), 0.0)))


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
    low = np.min([np.zeros(3), *(solid.body.com - solid.reach for solid in solids)], axis=0)
    high = np.max([np.zeros(3), *(solid.body.com + solid.reach for solid in solids)], axis=0)
    width = float((high - low).max()) or 1.0
    scale, middle = (SIZE - 2 * MARGIN) / width, (low + high) / 2
    length = _round_length(BAR * SIZE / scale)

    def place(point: FloatArray, right: int, up: int) -> tuple[float, float]:
        x, y = (point - middle)[[right, up]] * scale
        return float(SIZE / 2 + x), float(SIZE / 2 - y)

    return [
        {
            "right": AXES[right],
            "up": AXES[up],
            "origin": place(np.zeros(3), right, up),
            "ellipses": [
                _ellipse(solid, place(solid.body.com, right, up), (right, up), scale)
                for solid in solids
            ],
            "bar": length * scale,
            "bar_text": f"{length:g} m" if length >= 0.1 else f"{1000 * length:g} mm",
        }
        for right, up in VIEWS
    ]


def _ellipse(
    solid: Solid, centre: tuple[float, float], plane: tuple[int, int], scale: float
) -> dict[str, Any]:
    """An ellipse, y downwards, `turn` in degrees, clockwise; without radii, a tensor of no body."""
    x, y = centre
    drawn = {"name": solid.name, "style": solid.style, "x": x, "y": y, "rx": 0.0}
    if solid.squares is None:
        return drawn
    squares, axes = np.linalg.eigh(solid.squares[np.ix_(plane, plane)])
    ry, rx = np.maximum(np.sqrt(np.maximum(squares, 0.0)) * scale, LEAST)
    turn = -float(np.degrees(np.arctan2(axes[1, 1], axes[0, 1])))
    return drawn | {"rx": float(rx), "ry": float(ry), "turn": turn}


def _round_length(most: float) -> float:
    power = 10.0 ** np.floor(np.log10(most))
    return float(max(digit * power for digit in (1, 2, 5) if digit * power <= most * (1 + 1e-9)))
