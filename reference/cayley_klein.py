"""Cayley–Klein parameters of an attitude, and how they turn.

With Euler angles ZYZ (Fetter & Walecka §29) α, β, γ::

    A = q0 + i q3 = cos(β/2) e^{i(α+γ)/2}        B = q2 − i q1 = sin(β/2) e^{i(α−γ)/2}
    A' = ½ (iω3 A − W B)                         B' = ½ (W* A − iω3 B)        W = ω2 + iω1

(Klein & Sommerfeld, Über die Theorie des Kreisels, ch. I §§3–4, up to names and signs: from
q' = ½ q ω, component by component.)
"""

from typing import NamedTuple

from mpmath import mp, mpc

from ..scenarios.exact import Quaternion, Vector, dot


class CayleyKlein(NamedTuple):
    """The Cayley–Klein parameters A = q0 + i q3 and B = q2 − i q1 of an attitude.

    q is the unit quaternion of the attitude, scalar first.
    """

    A: mpc
    B: mpc

    @property
    def quaternion(self) -> Quaternion:
        """The attitude, body to world, as a unit quaternion, w x y z."""
        return (self.A.real, -self.B.imag, self.B.real, self.A.imag)

    def rates(self, omega: Vector) -> tuple[mpc, mpc]:
        """Return the derivatives A' and B', 1/s, given ω, rad/s, along the body's axes."""
        W, spin = transverse(omega), mpc(0, omega[2])
        return (spin * self.A - W * self.B) / 2, (mp.conj(W) * self.A - spin * self.B) / 2


def of_quaternion(q: Quaternion) -> CayleyKlein:
    """Return the Cayley–Klein parameters of a unit quaternion q, w x y z."""
    return CayleyKlein(mpc(q[0], q[3]), mpc(q[2], -q[1]))


def transverse(omega: Vector) -> mpc:
    """Return W = ω2 + iω1, the part of ω across the third axis, in the unit of ω."""
    return mpc(omega[1], omega[0])


def with_L_upright(L: Vector) -> CayleyKlein:
    """Return A and B of an attitude that turns the angular momentum L to the world's z axis.

    Of these attitudes it is the one with real A. L is given along the body's axes, with L3 >= 0.
    The formulas A B* = (−L1 + iL2)/2|L| and |A|² = (1 + L3/|L|)/2 have no difference that cancels.
    """
    length = mp.sqrt(dot(L, L))
    A = mp.sqrt((1 + L[2] / length) / 2)
    return CayleyKlein(mpc(A), mpc(-L[0], -L[1]) / (2 * length * A))


def along(triad: tuple[Vector, Vector, Vector], vector: Vector) -> Vector:
    """Return the components of a vector along three unit vectors."""
    x, y, z = (dot(axis, vector) for axis in triad)
    return (x, y, z)
