"""A scene's numbers in extended precision: each decimal's double is read exactly, then converted.

The reference solves these values; engines are given their rounding to double. Nothing is
rounded twice, so what separates a run from the exact motion is the engine.
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
    """Doubles as exact extended-precision numbers."""
    return tuple(mpf(value) for value in values)


def vector(values: Iterable[float]) -> Vector:
    """Three doubles as exact extended-precision numbers."""
    x, y, z = map(mpf, values)
    return (x, y, z)


def dot(a: Sequence[mpf], b: Sequence[mpf]) -> mpf:
    """a · b."""
    return mp.fdot(a, b)


def cross(a: Sequence[mpf], b: Sequence[mpf]) -> Vector:
    """a × b; of floats as of extended numbers."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def product(p: Quaternion, q: Quaternion) -> Quaternion:
    """Hamilton product p q, scalar first."""
    (p0, p1, p2, p3), (q0, q1, q2, q3) = p, q
    return (
        p0 * q0 - p1 * q1 - p2 * q2 - p3 * q3,
        p0 * q1 + p1 * q0 + p2 * q3 - p3 * q2,
        p0 * q2 - p1 * q3 + p2 * q0 + p3 * q1,
        p0 * q3 + p1 * q2 - p2 * q1 + p3 * q0,
    )


def conjugate(q: Quaternion) -> Quaternion:
    """The inverse of a unit quaternion."""
    return (q[0], -q[1], -q[2], -q[3])


def rotate(q: Quaternion, v: Vector) -> Vector:
    """q v q*: with q_world_body, body components to world components."""
    return product(product(q, (mpf(0), *v)), conjugate(q))[1:]


def normalised(q: Sequence[Any]) -> Quaternion:
    """q divided by its norm."""
    w, x, y, z = (mpf(c) for c in q)
    with mp.workdps(DIGITS):
        norm = mp.sqrt(w * w + x * x + y * y + z * z)
        return (w / norm, x / norm, y / norm, z / norm)


def from_euler_zyz_deg(angles_deg: Sequence[float]) -> Quaternion:
    """R = Rz(α) Ry(β) Rz(γ), angles in degrees (Fetter & Walecka §29).

    ``cospi`` and ``sinpi`` make right angles exact.
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
    """A rotation by the vector's length, in degrees, about its direction."""
    with mp.workdps(DIGITS):
        x, y, z = (mpf(c) for c in vector_deg)
        angle_deg = mp.sqrt(x * x + y * y + z * z)
        if angle_deg == 0:
            return (mpf(1), mpf(0), mpf(0), mpf(0))
        scale = mp.sinpi(angle_deg / 360) / angle_deg
        return (mp.cospi(angle_deg / 360), x * scale, y * scale, z * scale)


def omega_body_from_zyz_rates(angles_deg: Sequence[float], rates: Sequence[float]) -> Vector:
    """Body components of ω from the rates α̇, β̇, γ̇ in rad/s (Fetter & Walecka eq. 29.7)."""
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
    """Inertia of a point mass at ``arm``: m (|r|² 1 − r rᵀ), kg m² (the parallel-axis theorem)."""
    with mp.workdps(DIGITS):
        square = dot(arm, arm)
        rows = [
            [mass * ((square if i == j else 0) - arm[i] * arm[j]) for j in range(3)]
            for i in range(3)
        ]
        return _tensor(rows)


def add(a: Tensor, b: Tensor, sign: int = 1) -> Tensor:
    """a + sign b, entry by entry."""
    with mp.workdps(DIGITS):
        return _tensor([[a[i][j] + sign * b[i][j] for j in range(3)] for i in range(3)])


def turned_tensor(tensor: Tensor, q: Quaternion) -> Tensor:
    """Rᵀ I R, R the rotation of q: along axes that q turns from those of I; symmetric."""
    with mp.workdps(DIGITS):
        axes = [rotate(q, axis) for axis in _AXES]
        images = [tuple(dot(row, axis) for row in tensor) for axis in axes]
        return _tensor(
            [[dot(axes[min(i, j)], images[max(i, j)]) for j in range(3)] for i in range(3)]
        )


def _tensor(rows: Sequence[Sequence[mpf]]) -> Tensor:
    first, second, third = (tuple(row) for row in rows)
    return (first, second, third)
