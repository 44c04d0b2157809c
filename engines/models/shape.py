"""The uniform box that has a body's inertia."""

from collections.abc import Iterable
from math import sqrt


def box_sides(mass: float, moments: Iterable[float]) -> tuple[float, ...]:
    """Return the sides, m, of the uniform box with a mass, kg, and principal moments, kg m².

    The sides a, b, c follow from I₁ = m (b² + c²) / 12 and its permutations; the triangle
    inequality of the moments makes their squares positive. For a flat body one side is zero.
    """
    moments = list(moments)
    return tuple(sqrt(max(0.0, 6 * (sum(moments) - 2 * own) / mass)) for own in moments)
