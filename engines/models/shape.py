"""The uniform box that has a body's inertia."""

from collections.abc import Iterable
from math import sqrt


def box_sides(mass: float, moments: Iterable[float]) -> tuple[float, ...]:
    """Sides, m, along principal axes of the uniform box of a mass, kg, with these moments, kg m².

    From I₁ = m (b² + c²) / 12 and so on; the triangle inequality makes the squares positive. Of a
    flat body one is zero.
    """
    moments = list(moments)
    return tuple(sqrt(max(0.0, 6 * (sum(moments) - 2 * own) / mass)) for own in moments)
