"""Angles over time as an SVG picture that needs no script."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ....scenarios import FloatArray
from ..analysis.trace_style import TraceStyle

#: Size of the picture; margins for numbers at its left and bottom.
WIDTH, HEIGHT, LEFT, BOTTOM, TOP, RIGHT = 320.0, 200.0, 40.0, 30.0, 10.0, 12.0
#: Possible upper ends of the axis of angles, degrees; the smallest sufficient one is used.
TOPS = (1e-3, 1e-2, 0.1, 1.0, 5.0, 15.0, 45.0, 90.0, 180.0)


@dataclass(frozen=True)
class TimeCurve:
    """One line: "x,y x,y …" in the picture's units."""

    name: str
    colour: str
    dash: str
    points: str


@dataclass(frozen=True)
class TimeCurves:
    """A picture of curves.

    Attributes
    ----------
    x_ticks, y_ticks : positions and labels
    """

    curves: tuple[TimeCurve, ...]
    x_ticks: tuple[tuple[float, str], ...]
    y_ticks: tuple[tuple[float, str], ...]


def time_curves(
    times: FloatArray, of_runs: Sequence[tuple[str, TraceStyle, FloatArray]]
) -> TimeCurves:
    """Curves of angles.

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

    curves = tuple(
        TimeCurve(name, style.colour, style.dash, _points(x(times), y(angles)))
        for name, style, angles in of_runs
    )
    seconds = tuple((float(x(t)), f"{t:g}") for t in range(int(end) + 1))
    degrees = tuple((float(y(a)), f"{a:g}°") for a in (0.0, top / 3, 2 * top / 3, top))
    return TimeCurves(curves, seconds, degrees)


def _points(x: FloatArray, y: FloatArray) -> str:
    return " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))
