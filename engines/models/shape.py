"""The uniform box that has a body's inertia."""

from collections.abc import Iterable
from dataclasses import dataclass
from math import prod, sqrt


@dataclass(frozen=True)
class Box:
    """A box along principal axes.

    Attributes
    ----------
    sides : m; of a flat body one is zero
    density : kg/m³; infinite of a flat body
    """

    sides: tuple[float, ...]
    density: float


def box_of(mass: float, moments: Iterable[float]) -> Box:
    """The uniform box of a mass, kg, with these principal moments, kg m².

    From I₁ = m (b² + c²) / 12 and so on; the triangle inequality makes the squares positive.
    """
    moments = list(moments)
    sides = tuple(sqrt(max(0.0, 6 * (sum(moments) - 2 * own) / mass)) for own in moments)
    volume = prod(sides)
    return Box(sides, mass / volume if volume else float("inf"))
