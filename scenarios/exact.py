"""A scene's numbers in extended precision: each double that a file states is taken as exact.

Angles, units and frames are then converted in extended precision. The reference solves the scene
with the results; engines are given them rounded to double. Nothing is rounded twice, so that what
separates a run from the exact motion is the engine.
"""

from collections.abc import Iterable, Sequence
from typing import Any

from mpmath import mp, mpf

#: Working precision of every conversion. Products of three doubles need 159 bits = 48 digits.
DIGITS = 60

Vector = tuple[mpf, mpf, mpf]
Quaternion = tuple[mpf, mpf, mpf, mpf]
Tensor = tuple[Vector, Vector, Vector]

ZERO: Vector = (mpf(0), mpf(0), mpf(0))
#: The unit quaternion of no turn.
NO_TURN: Quaternion = (mpf(1), mpf(0), mpf(0), mpf(0))
_AXES: Tensor = ((mpf(1), mpf(0), mpf(0)), (mpf(0), mpf(1), mpf(0)), (mpf(0), mpf(0), mpf(1)))


def exact(values: Sequence[float]) -> tuple[mpf, ...]:
    """Return doubles as numbers in extended precision, without rounding."""
    return tuple(mpf(value) for value in values)


def vector(values: Iterable[float]) -> Vector:
    """Return a vector of three doubles in extended precision, without rounding."""
    x, y, z = map(mpf, values)
    return (x, y, z)


def dot(a: Sequence[mpf], b: Sequence[mpf]) -> mpf:
    """Return a · b, in the caller's precision of mpmath."""
    return mp.fdot(a, b)


def cross(a: Sequence[mpf], b: Sequence[mpf]) -> Vector:
    """Return a × b, of floats or of numbers in extended precision."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def product(p: Quaternion, q: Quaternion) -> Quaternion:
    """Return Hamilton's product p q of quaternions, scalar first."""
    (p0, p1, p2, p3), (q0, q1, q2, q3) = p, q
    return (
        p0 * q0 - p1 * q1 - p2 * q2 - p3 * q3,
        p0 * q1 + p1 * q0 + p2 * q3 - p3 * q2,
        p0 * q2 - p1 * q3 + p2 * q0 + p3 * q1,
        p0 * q3 + p1 * q2 - p2 * q1 + p3 * q0,
    )


def conjugate(q: Quaternion) -> Quaternion:
    """Return the conjugate of a quaternion, which is the inverse of a unit quaternion."""
    return (q[0], -q[1], -q[2], -q[3])


def rotate(q: Quaternion, v: Vector) -> Vector:
    """Return q v q*: v turned by a unit quaternion.

    With q_world_body it takes body components to world components.
    """
    return product(product(q, (mpf(0), *v)), conjugate(q))[1:]


def normalised(q: Sequence[Any]) -> Quaternion:
    """Return a quaternion divided by its norm, in extended precision."""
    w, x, y, z = (mpf(c) for c in q)
    with mp.workdps(DIGITS):
        norm = mp.sqrt(w * w + x * x + y * y + z * z)
        return (w / norm, x / norm, y / norm, z / norm)


def from_euler_zyz_deg(angles_deg: Sequence[float]) -> Quaternion:
    """Return the quaternion of R = Rz(α) Ry(β) Rz(γ), angles in degrees (Fetter & Walecka §29).

    Right angles are exact, by ``cospi`` and ``sinpi``.
    """
    with mp.workdps(DIGITS):
        alpha, beta, gamma = (mpf(angle) / 360 for angle in angles_deg)
        cos_half, sin_half = mp.cospi(beta), mp.sinpi(beta)
        return (
            cos_half * mp.cospi(alpha + gamma),
            -sin_half * mp.sinpi(alpha - gamma),
            sin_half * mp.cospi(alpha - gamma),
            cos_half * mp.sinpi(alpha + gamma),
        )


def from_rotation_vector_deg(vector_deg: Sequence[float]) -> Quaternion:
    """Return the quaternion of a rotation by a vector's length, in degrees, about its direction."""
    with mp.workdps(DIGITS):
        x, y, z = (mpf(c) for c in vector_deg)
        angle_deg = mp.sqrt(x * x + y * y + z * z)
        if angle_deg == 0:
            return (mpf(1), mpf(0), mpf(0), mpf(0))
        scale = mp.sinpi(angle_deg / 360) / angle_deg
        return (mp.cospi(angle_deg / 360), x * scale, y * scale, z * scale)


def omega_body_from_zyz_rates(angles_deg: Sequence[float], rates: Sequence[float]) -> Vector:
    """Return ω in body axes, rad/s, given ZYZ Euler angles and their rates.

    The formula is Fetter & Walecka eq. 29.7; angles are in degrees, rates in rad/s.
    """
    with mp.workdps(DIGITS):
        beta, gamma = (mpf(angle) / 180 for angle in angles_deg[1:])
        alpha_rate, beta_rate, gamma_rate = (mpf(rate) for rate in rates)
        sin_beta, cos_gamma, sin_gamma = mp.sinpi(beta), mp.cospi(gamma), mp.sinpi(gamma)
        return (
            -alpha_rate * sin_beta * cos_gamma + beta_rate * sin_gamma,
            alpha_rate * sin_beta * sin_gamma + beta_rate * cos_gamma,
            alpha_rate * mp.cospi(beta) + gamma_rate,
        )


def steiner(mass: mpf, arm: Vector) -> Tensor:
    """Return the inertia of a point mass at a place r, `arm`: m (|r|² 1 − r rᵀ), kg m².

    It is the term that the parallel-axis theorem adds.
    """
    with mp.workdps(DIGITS):
        square = dot(arm, arm)
        rows = [
            [mass * ((square if i == j else 0) - arm[i] * arm[j]) for j in range(3)]
            for i in range(3)
        ]
        return _tensor(rows)


def add(a: Tensor, b: Tensor, sign: int = 1) -> Tensor:
    """Return a + sign · b, the sum or difference of two tensors."""
    with mp.workdps(DIGITS):
        return _tensor([[a[i][j] + sign * b[i][j] for j in range(3)] for i in range(3)])


def turned_tensor(tensor: Tensor, q: Quaternion) -> Tensor:
    """Return Rᵀ I R, the components of a tensor I along the axes that q turns the old axes to.

    R is the matrix of the unit quaternion q. The result is symmetric to the last digit.
    """
    with mp.workdps(DIGITS):
        axes = [rotate(q, axis) for axis in _AXES]
        images = [tuple(dot(row, axis) for row in tensor) for axis in axes]
        return _tensor(
            [[dot(axes[min(i, j)], images[max(i, j)]) for j in range(3)] for i in range(3)]
        )


def _tensor(rows: Sequence[Sequence[mpf]]) -> Tensor:
    first, second, third = (tuple(row) for row in rows)
    return (first, second, third)
