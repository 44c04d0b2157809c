"""Lagrange's top at any time by Legendre's integrals: see `legendre_motion`.

With b = 2 M g l/I1, c = L·up/I1, d = L3/I1 and u the height of the top's axis (Whittaker §71;
Goldstein §5.7)::

    u̇² = b (U − u)(1 − u²) − (c − d u)² = b (u − u1)(u − u2)(u − u3),   u = u1 + (u2 − u1) sn²
    arg A = ½ ∫ (c + d)/(1 + u) + (ω3 − d) dt        arg B = ½ ∫ (c − d)/(1 − u) − (ω3 − d) dt
"""

from typing import NamedTuple

from legendre_motion import DIGITS, LegendreMotion, Swing, quaternion, to_axes, unit
from mpmath import mp, mpc, mpf
from spincheck.reference.problem import Problem
from spincheck.scenarios.exact import Quaternion, Vector, conjugate, dot, product
from spincheck.scenarios.principal import from_matrix

#: What differs by less, relative to the fastest rate, is the rounding of a start in 60 digits.
NOTHING = mpf(10) ** -50


class Top(NamedTuple):
    """Start and constants of motion, as above; A, B and ω along the top's axes."""

    A: mpc
    B: mpc
    omega: Vector
    b: mpf
    c: mpf
    d: mpf

    @property
    def turned(self) -> mpc:
        """−u̇ + i (c − d u)."""
        return 2 * self.A * mp.conj(self.B) * mpc(self.omega[1], -self.omega[0])

    @property
    def u(self) -> mpf:
        """Height."""
        return abs(self.A) ** 2 - abs(self.B) ** 2


class Parameter(NamedTuple):
    """A or B: its modulus squared is (start + slope sn²)/2, and it may be zero at a pole.

    Attributes
    ----------
    at_start : its value
    rate : i times that of its phase far from its pole, 1/s
    about : c + d or c − d, 1/s: its phase turns by ½ about/(start + slope sn²) as well
    start, slope : as above
    through : 1 where it is proportional to sn, 2 to cn, 0 where it has no zero
    """

    at_start: mpc
    rate: mpf
    about: mpf
    start: mpf
    slope: mpf
    through: int


def heavy_top(problem: Problem) -> LegendreMotion:
    """Lever along a principal axis of two equal moments, gravity not up along z."""
    with mp.workdps(DIGITS):
        axis = max(range(3), key=lambda k: abs(problem.lever_axes[k]))
        sign = int(mp.sign(problem.lever_axes[axis]))
        e1, e2, e3 = unit((axis + 1) % 3, 1), unit((axis + 2) % 3, sign), unit(axis, sign)
        q_triad, q_up = from_matrix((e1, e2, e3)), _upright(problem.gravity_world)
        top = _top(
            problem, (e1, e2, e3), product(product(q_up, problem.q_world_axes), conjugate(q_triad))
        )
        u1, u2, u3 = _roots(top)
        u21 = u2 - u1
        p = mp.sqrt(top.b * (u3 - u1)) / 2
        sine, cosine = mp.sqrt(abs(top.u - u1) / u21), mp.sqrt(abs(u2 - top.u) / u21)
        falling = top.turned.real > 0
        swing = Swing(p, u21 / (u3 - u1), mp.atan2(-sine if falling else sine, cosine))
        spin = (top.omega[2] - top.d) / 2
        A = Parameter(top.A, spin, top.c + top.d, 1 + u1, u21, int(u1 == -1))
        B = Parameter(top.B, -spin, top.c - top.d, 1 - u1, -u21, 2 * int(u2 == 1))
        slopes = _slopes(top)

        def state(t: float) -> tuple[Quaternion, Vector]:
            with mp.workdps(DIGITS):
                a, a_rate = _value(A, swing, t, slopes[0])
                b, b_rate = _value(B, swing, t, slopes[1])
                W = 2 * (a * mp.conj(b_rate) - mp.conj(b) * a_rate)
                q = product(product(conjugate(q_up), quaternion(a, b)), q_triad)
                return q, to_axes((e1, e2, e3), (W.imag, W.real, top.omega[2]))

        return LegendreMotion(state, swing.period / 2)


def _upright(gravity_world: Vector) -> Quaternion:
    """A rotation that takes the upward vertical, not −z, to z."""
    length = -mp.sqrt(dot(gravity_world, gravity_world))
    x, y, z = (g / length for g in gravity_world)
    size = mp.sqrt(2 * (1 + z))
    return ((1 + z) / size, y / size, -x / size, mpf(0))


def _top(problem: Problem, triad: tuple[Vector, Vector, Vector], q: Quaternion) -> Top:
    size = mp.sqrt(dot(q, q))
    w, x, y, z = (component / size for component in q)
    I1, _, I3 = (dot(problem.moments, [n * n for n in axis]) for axis in triad)
    omega = tuple(dot(axis, problem.omega_axes) for axis in triad)
    weight = mp.sqrt(dot(problem.lever_axes, problem.lever_axes)) * mp.sqrt(
        dot(problem.gravity_world, problem.gravity_world)
    )
    d = I3 * omega[2] / I1
    top = Top(mpc(w, z), mpc(y, -x), omega, 2 * weight / I1, mpf(0), d)
    return top._replace(c=top.turned.imag + d * top.u)


def _roots(top: Top) -> Vector:
    """u1 <= u2 <= 1 <= u3, by Viète's cosines (DLMF 1.11.iii); those at a pole exactly there."""
    b, c, d = top.b, top.c, top.d
    with mp.extradps(DIGITS):  # nearly double roots lose half the digits
        U = top.u + (top.omega[0] ** 2 + top.omega[1] ** 2) / b
        a2, a1, a0 = -(U + d * d / b), 2 * c * d / b - 1, U - c * c / b
        spread = (a2 * a2 - 3 * a1) / 9
        cosine = (9 * a2 * a1 - 2 * a2**3 - 27 * a0) / (54 * mp.sqrt(spread) ** 3)
        third = mp.acos(max(min(cosine, 1), -1)) / 3
        angles = (third + 2 * mp.pi / 3, third - 2 * mp.pi / 3, third)
        u1, u2, u3 = (2 * mp.sqrt(spread) * mp.cos(x) - a2 / 3 for x in angles)
    u1, u2, u3 = (mp.sign(u) if abs(abs(u) - 1) < NOTHING else u for u in (u1, u2, u3))
    return (u1, u2, u3)


def _slopes(top: Top) -> tuple[mpc, mpc]:
    """A' and B' at the start."""
    W, spin = mpc(top.omega[1], top.omega[0]), mpc(0, top.omega[2])
    return (spin * top.A - W * top.B) / 2, (mp.conj(W) * top.A - spin * top.B) / 2


def _value(part: Parameter, swing: Swing, t: float, slope_at_start: mpc) -> tuple[mpc, mpc]:
    """A or B, and its derivative in time."""
    amplitude, sn, cn, dn = swing.at(t)
    p = swing.p
    if part.through:
        now, now_rate = (sn, p * cn * dn) if part.through == 1 else (cn, -p * sn * dn)
        _, sn0, cn0, dn0 = swing.at(0)
        then, then_rate = (sn0, p * cn0 * dn0) if part.through == 1 else (cn0, -p * sn0 * dn0)
        turning = mpc(then_rate, part.rate * then)
        factor = slope_at_start / turning if 2 * abs(then) < 1 else part.at_start / then
        value = factor * now * mp.expj(part.rate * t)
        return value, factor * mp.expj(part.rate * t) * mpc(now_rate, part.rate * now)
    size = part.start + part.slope * sn**2
    n = -part.slope / part.start
    phase = part.rate * t + part.about / (2 * part.start) * swing.third_kind(n, amplitude)
    unit_at_start = part.at_start / abs(part.at_start)
    value = mp.sqrt(size / 2) * unit_at_start * mp.expj(phase)
    rate = mpc(2 * part.slope * p * sn * cn * dn, part.about) / (2 * size) + mpc(0, part.rate)
    return value, value * rate
