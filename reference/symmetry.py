"""Which axis a problem is symmetric about, and its moments about and across that axis."""

from collections.abc import Sequence

import numpy as np
from mpmath import mp, mpf

from ..scenarios import FloatArray
from ..scenarios.exact import DIGITS, Vector, conjugate, cross, dot, rotate
from ..scenarios.principal import EQUAL_TO_WORKING_PRECISION
from .problem import Problem

UNIT_VECTORS: tuple[Vector, Vector, Vector] = (
    (mpf(1), mpf(0), mpf(0)),
    (mpf(0), mpf(1), mpf(0)),
    (mpf(0), mpf(0), mpf(1)),
)


def equal(a: mpf, b: mpf, scale: mpf = 0) -> bool:
    """Whether a and b differ by rounding only, relative to the largest of |a|, |b| and `scale`."""
    return bool(abs(a - b) <= EQUAL_TO_WORKING_PRECISION * max(abs(a), abs(b), scale))


def norm(vector: Sequence[mpf]) -> mpf:
    """Return the Euclidean length of a vector, in the caller's precision of mpmath."""
    return mp.sqrt(dot(vector, vector))


def scaled(vector: Vector, factor: mpf) -> Vector:
    """Return factor · vector, in the caller's precision of mpmath."""
    x, y, z = vector
    return (factor * x, factor * y, factor * z)


def gravity_torque_scale(problem: Problem) -> mpf:
    """Return M g l, N m: weight times the com's distance from pivot or tip; 0 if it has neither."""
    with mp.workdps(DIGITS):
        return norm(problem.held_lever) * norm(problem.gravity_world)


def symmetry_axis(problem: Problem) -> Vector | None:
    """Return the axis that a top is symmetric about, a unit vector in principal components.

    The two moments across this axis are equal. If gravity can turn the body about its pivot or tip,
    the axis must also contain the com, and points from pivot or tip to the com. If not, it is the
    principal axis whose moment differs from the other two.

    It is None if there is no such axis, as for a sphere that gravity cannot turn, and for a body
    whose rotors have an angular momentum.
    """
    if any(problem.kept_momentum):
        return None
    with mp.workdps(DIGITS):
        if gravity_torque_scale(problem) == 0:
            single = _axis_of_the_single_moment(problem.moments)
            return None if single is None else UNIT_VECTORS[single]
        lever = problem.held_lever
        axis = scaled(lever, 1 / norm(lever))
        first, second, third = problem.moments
        if equal(first, second) and equal(second, third):
            return axis
        single = _axis_of_the_single_moment(problem.moments)
        if single is None or not all(equal(axis[k], 0, 1) for k in range(3) if k != single):
            return None
        return scaled(UNIT_VECTORS[single], mp.sign(axis[single]))


def angular_momentum_axes(problem: Problem) -> Vector:
    """Return the angular momentum at t = 0 along the principal axes, kg m²/s."""
    with mp.workdps(DIGITS):
        parts = zip(problem.moments, problem.omega_axes, problem.kept_momentum, strict=True)
        x, y, z = (m * w + h for m, w, h in parts)
        return (x, y, z)


def moment_about(problem: Problem, axis: Vector) -> mpf:
    """Return the moment about an axis through the fixed point, kg m²; `axis` is a unit vector."""
    with mp.workdps(DIGITS):
        return mp.fsum(m * n * n for m, n in zip(problem.moments, axis, strict=True))


def moments_across_and_along(problem: Problem, axis: Vector) -> tuple[mpf, mpf]:
    """Return I1 and I3 of a symmetric top, its moments across its axis and about it, kg m²."""
    with mp.workdps(DIGITS):
        I3 = moment_about(problem, axis)
        return (mp.fsum(problem.moments) - I3) / 2, I3


def across(axis: Vector) -> tuple[Vector, Vector]:
    """Return unit vectors e1, e2 for which (e1, e2, axis) is a right-handed orthogonal triad."""
    with mp.workdps(DIGITS):
        least = min(range(3), key=lambda k: abs(axis[k]))
        second = cross(axis, UNIT_VECTORS[least])
        second = scaled(second, 1 / norm(second))
        return cross(second, axis), second


def up_world(problem: Problem) -> FloatArray:
    """Return the upward vertical −ĝ, world axes, (3,); gravity must not be zero."""
    with mp.workdps(DIGITS):
        g = problem.gravity_world
        return np.array(scaled(g, -1 / norm(g)), dtype=float)


def to_body(problem: Problem, vector_axes: Vector) -> Vector:
    """Return the body components of a vector that is given along the principal axes."""
    with mp.workdps(DIGITS):
        return rotate(conjugate(problem.q_axes_body), vector_axes)


def _axis_of_the_single_moment(moments: Vector) -> int | None:
    """Return the index of the moment that differs from two equal ones; None unless two are equal.

    It is None for three equal moments, too.
    """
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        if equal(moments[i], moments[j]) and not equal(moments[k], moments[i]):
            return k
    return None
