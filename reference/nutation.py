"""How the tilt of a heavy symmetric top swings: u(t) = cos β by Jacobi's functions.

β is the angle from the upward vertical to the axis, which points from the pivot to the centre of
mass, and κ = M g l. The constants of motion, divided by I1, and the cubic of u̇² are (Goldstein
§5.7; Whittaker §71)::

    b = 2κ/I1    c = L·(−ĝ)/I1    d = I3 ω3/I1    |W|² = b (U − u),  W = ω2 + iω1
    u̇² = b (U − u)(1 − u²) − (c − d u)² = b (u − u1)(u − u2)(u − u3)
    u = u1 + (u2 − u1) sn²(p t + u0 | m)    p² = b (u3 − u1)/4    m = (u2 − u1)/(u3 − u1)

The poles are u = ±1, where the axis is vertical. A top that sleeps, or passes close to a pole, has
roots that agree in many digits. So that small differences keep their relative accuracy, u is
given by its distance δ from a pole: u = σ (1 − δ), σ = ±1. This is the pole nearer to the start, or
the upper one if the energy is just enough to reach it.
"""

from typing import NamedTuple

from mpmath import mp, mpf

from ..scenarios.exact import Vector
from .cayley_klein import CayleyKlein, transverse
from .elliptic import Lattice
from .symmetry import equal


class Constants(NamedTuple):
    """A top's constants of motion and its state at t = 0, with heights measured from a pole.

    The height is u = cos β = σ (1 − δ), with δ the distance from the pole u = σ. W = ω2 + iω1 is
    the part of ω across the top's axis.

    Attributes
    ----------
    pole : σ, 1 for the upper pole, −1 for the lower
    b, d : 2 M g l/I1, s⁻², and I3 ω3/I1, 1/s
    excess : |W|² of the top at the pole by conservation of energy, s⁻²; negative if the energy is
        too low to reach the pole
    e : c − σ d, 1/s, with c the upward component of L divided by I1; zero for a top that can reach
        the pole
    delta : δ at t = 0
    W_squared : |W|² at t = 0, s⁻²
    rising : whether u̇ >= 0 at t = 0
    """

    pole: int
    b: mpf
    d: mpf
    excess: mpf
    e: mpf
    delta: mpf
    W_squared: mpf
    rising: bool

    @property
    def c_plus_d(self) -> mpf:
        """c + d, 1/s: the sum of L's upward component and its component along the axis, over I1."""
        return self.e + (1 + self.pole) * self.d

    @property
    def c_minus_d(self) -> mpf:
        """c − d, 1/s: L's upward component less its component along the axis, divided by I1."""
        return self.e - (1 - self.pole) * self.d

    def c_minus_d_times(self, below: mpf, above: mpf) -> mpf:
        """Return c − d u, 1/s, with c the upward component of L divided by I1, and u = cos β.

        Parameters
        ----------
        below, above : 1 − u, and 1 + u
        """
        return self.e + self.pole * self.d * (below if self.pole > 0 else above)


def constants(start: CayleyKlein, omega: Vector, b: mpf, d: mpf) -> Constants:
    """Return a top's constants of motion and start, with heights measured from one of the poles.

    The pole is the nearer one, or the upper one if the top has just the energy and the angular
    momentum to reach it.

    Parameters
    ----------
    start : the attitude at t = 0
    omega : ω along the axes of the top's frame at t = 0, rad/s
    b, d : 2 M g l/I1, s⁻², and I3 ω3/I1, 1/s
    """
    upper = _constants_from(1, start, omega, b, d)
    if upper.delta <= 1 or (upper.excess == 0 and upper.e == 0):
        return upper
    return _constants_from(-1, start, omega, b, d)


def _constants_from(pole: int, start: CayleyKlein, omega: Vector, b: mpf, d: mpf) -> Constants:
    """Return a top's constants of motion and start, with heights measured from a given pole.

    A difference of numbers that agree to working precision is set to zero. u̇ follows from A and B,
    as −γ1 + iγ2 = 2 A B*, with γ the upward vertical along the top's axes.

    Parameters
    ----------
    pole : 1 for the upper pole, −1 for the lower
    start : the Cayley–Klein parameters A and B of the attitude at t = 0
    omega : ω along the axes of the top's frame at t = 0, rad/s
    b, d : 2 M g l/I1, s⁻², and I3 ω3/I1, 1/s
    """
    W = transverse(omega)
    tilt = abs(start.B if pole > 0 else start.A)
    delta = 2 * tilt**2
    turned = 2 * start.A * mp.conj(start.B) * mp.conj(W)  # −u̇ + i (ω1 γ1 + ω2 γ2)
    W_squared = abs(W) ** 2
    return Constants(
        pole,
        b,
        d,
        _difference(W_squared, pole * b * delta),
        _difference(turned.imag, pole * d * delta, 2 * tilt * abs(W)),
        delta,
        W_squared,
        bool(turned.real <= 0),
    )


class Nutation(NamedTuple):
    """The nutation of a top's axis: u = cos β = u1 + (u2 − u1) sn²(p t + u0 | m).

    Attributes
    ----------
    below, above : 1 − u, and 1 + u, at each of u1, u2, u3, the zeros of u̇² as a cubic in u
    u21, u31, u32 : u2 − u1, u3 − u1, u3 − u2
    U2 : U − u2, with U the u at which ω would have no part across the top's axis
    p : rate of the argument p t + u0, 1/s
    lattice : periods of the elliptic functions of parameter m
    sin_squared, cos_squared : sn² and cn² at t = 0
    """

    below: Vector
    above: Vector
    u21: mpf
    u31: mpf
    u32: mpf
    U2: mpf
    p: mpf
    lattice: Lattice
    sin_squared: mpf
    cos_squared: mpf


def nutation(start: Constants) -> Nutation | None:
    """Return the nutation of a top with given constants of motion; None if its tilt is constant.

    Parameters
    ----------
    start : the constants of motion, and the state at t = 0
    """
    pole, delta = start.pole, start.delta
    d1, d2, d3 = turning_points(pole, start.b, start.d, start.excess, start.e)
    if equal(d1, d2):
        return None
    u21, u31, u32 = pole * (d1 - d2), pole * (d1 - d3), pole * (d2 - d3)
    sin_squared = min(max(pole * (d1 - delta) / u21, mpf(0)), mpf(1))
    cos_squared = min(max(pole * (delta - d2) / u21, mpf(0)), mpf(1))
    near, far = (d1, d2, d3), (2 - d1, 2 - d2, 2 - d3)
    return Nutation(
        below=near if pole > 0 else far,
        above=far if pole > 0 else near,
        u21=u21,
        u31=u31,
        u32=u32,
        U2=max(start.W_squared / start.b - cos_squared * u21, mpf(0)),
        p=mp.sqrt(start.b * u31) / 2,
        lattice=Lattice(u21 / u31, u32 / u31),
        sin_squared=sin_squared,
        cos_squared=cos_squared,
    )


def turning_points(pole: int, b: mpf, d: mpf, excess: mpf, e: mpf) -> Vector:
    """Return the distances δ from a pole of u1, u2 and u3, the zeros of u̇² as a cubic in u.

    With u = cos β = σ(1 − δ), σ = `pole`, they are the zeros of (excess + sδ) δ(2 − δ) − (e + gδ)²,
    s = σb, g = σd. The largest comes from Viète's cosines (DLMF 1.11.iii; all are real). Division
    by it leaves a quadratic, whose roots are accurate even if they are smaller by many orders.

    Parameters
    ----------
    pole, b, d, excess, e : the attributes of `Constants` with these names
    """
    s, g = pole * b, pole * d
    a2, a1, a0 = (excess + g * g) / s - 2, 2 * (e * g - excess) / s, e * e / s
    largest = max(_by_cosines(a2, a1, a0), key=abs)
    if largest == 0:
        return mpf(0), mpf(0), mpf(0)
    product = -a0 / largest
    half_sum = (a1 - product) / largest / 2
    root = mp.sqrt(max(half_sum**2 - product, mpf(0)))
    further = half_sum + (root if half_sum >= 0 else -root)
    deltas = [largest, further, product / further if further else mpf(0)]
    return _within_bounds(sorted(deltas, key=lambda x: -pole * x), pole)


def _by_cosines(a2: mpf, a1: mpf, a0: mpf) -> list[mpf]:
    """Return the three roots of x³ + a2 x² + a1 x + a0, all of which are real."""
    spread = max(a2 * a2 - 3 * a1, mpf(0)) / 9
    if spread == 0:
        return [-a2 / 3] * 3
    cosine = (9 * a2 * a1 - 2 * a2**3 - 27 * a0) / (54 * spread * mp.sqrt(spread))
    third = mp.acos(min(max(cosine, mpf(-1)), mpf(1))) / 3
    return [2 * mp.sqrt(spread) * mp.cos(third + k * 2 * mp.pi / 3) - a2 / 3 for k in range(3)]


def _within_bounds(deltas: list[mpf], pole: int) -> Vector:
    """Return the roots' distances δ from a pole, without what rounding has put beyond a pole.

    A root beyond a pole is moved to it, so that −1 ≤ u1, u2 ≤ 1 ≤ u3 holds exactly.

    Parameters
    ----------
    deltas : δ of u1, u2 and u3
    pole : 1 for the upper pole, −1 for the lower
    """
    d1, d2, d3 = deltas
    if pole > 0:
        return min(d1, mpf(2)), max(d2, mpf(0)), min(d3, mpf(0))
    return max(d1, mpf(0)), min(d2, mpf(2)), max(d3, mpf(2))


def _difference(a: mpf, b: mpf, scale: mpf = 0) -> mpf:
    """Return a − b; 0 if it is only rounding, relative to the largest of |a|, |b| and `scale`."""
    return mpf(0) if equal(a, b, scale) else a - b
