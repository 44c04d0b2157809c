"""Motions of tops at any time by Legendre's integrals of the first and third kind, in mpmath.

The textbooks' way, which knows of no theta quotient: tilt and ω by Jacobi's functions, precession
and spin by Π(n; am u | m) (Landau & Lifshitz, Mechanics, §37; Whittaker, Analytical Dynamics,
§§69, 71; DLMF 19.2.7). It cancels, and so is done in many digits; it wants a motion that
repeats and, of a heavy top, an axis that moves.
"""

from collections.abc import Callable
from dataclasses import dataclass

from mpmath import mp, mpc, mpf
from spincheck.reference.problem import Problem
from spincheck.scenarios.exact import Quaternion, Vector, conjugate, cross, dot, product, rotate
from spincheck.scenarios.principal import from_matrix

#: Differences of E and L², or of roots that nearly agree, may cost a half of them.
DIGITS = 120

Motion = Callable[[float], tuple[Quaternion, Vector]]


@dataclass(frozen=True)
class Swing:
    """u = p t + u0 with amplitude am u.

    Attributes
    ----------
    p : 1/s
    m : parameter
    amplitude0 : am u0, in (−π, π]
    """

    p: mpf
    m: mpf
    amplitude0: mpf

    @property
    def period(self) -> mpf:
        """4 K/p, s."""
        return 4 * mp.ellipk(self.m) / self.p

    def at(self, t: float) -> tuple[mpf, mpf, mpf, mpf]:
        """am u and sn u, cn u, dn u."""
        half = 2 * mp.ellipk(self.m)
        u = self.p * mpf(t) + mp.ellipf(self.amplitude0, self.m)
        turns = mp.nint(u / half)
        sn, cn, dn = (mp.ellipfun(f, u=u - turns * half, m=self.m) for f in ("sn", "cn", "dn"))
        sign = -1 if int(turns) % 2 else 1
        return mp.atan2(sn, cn) + turns * mp.pi, sign * sn, sign * cn, dn

    def third_kind(self, n: mpf, amplitude: mpf) -> mpf:
        """∫ dt/(1 − n sn² u) from 0 on, s."""
        since = mp.ellippi(n, amplitude, self.m) - mp.ellippi(n, self.amplitude0, self.m)
        return since / self.p


@dataclass(frozen=True, eq=False)
class LegendreMotion:
    """A motion, q_world_axes and omega_axes at a time, and the period of its swing, s."""

    state: Motion
    period: mpf


def free_body(problem: Problem) -> LegendreMotion:
    """Three distinct moments, no torque, not on the separatrix (Landau & Lifshitz §37)."""
    with mp.workdps(DIGITS):
        triad, squared, E2 = _circulating(problem)
        I1, I2, I3 = (dot(problem.moments, [x * x for x in axis]) for axis in triad)
        w1, w2, _ = (dot(axis, problem.omega_axes) for axis in triad)
        a1, a2, a3 = _amplitudes((I1, I2, I3), squared, E2)
        p = mp.sqrt((I3 - I2) * (squared - E2 * I1) / (I1 * I2 * I3))
        m = (I2 - I1) * (E2 * I3 - squared) / ((I3 - I2) * (squared - E2 * I1))
        s = mp.sign(I2 - I1)
        swing = Swing(p, m, mp.atan2(s * w2 / a2, w1 / a1))
        length, q_triad = mp.sqrt(squared), from_matrix(triad)
        n = -m * (I3 * a3 / (I1 * a1)) ** 2
        slope = length * (E2 - squared / I3) / (I1 * a1) ** 2

        def along_triad(t: float) -> tuple[Quaternion, Vector]:
            """Attitude, L upright, and ω; α̇ = |L| (2E − I3 ω3²)/(L² − I3² ω3²)."""
            amplitude, sn, cn, dn = swing.at(t)
            omega = (a1 * cn, s * a2 * sn, a3 * dn)
            alpha = length * t / I3 + slope * swing.third_kind(n, amplitude)
            up = [i * w / length for i, w in zip((I1, I2, I3), omega, strict=True)]
            sine = mpc(-up[0], up[1])  # sin β e^{iγ} = 2 A B*
            A = mp.sqrt((1 + up[2]) / 2) * mp.expj((alpha + mp.arg(sine)) / 2)
            return quaternion(A, mp.conj(sine / (2 * A))), omega

        at_start, _ = along_triad(0)
        q_left = product(problem.q_world_axes, conjugate(product(at_start, q_triad)))

        def state(t: float) -> tuple[Quaternion, Vector]:
            with mp.workdps(DIGITS):
                q, omega = along_triad(t)
                return product(product(q_left, q), q_triad), to_axes(triad, omega)

        return LegendreMotion(state, swing.period)


def free_symmetric_body(problem: Problem) -> LegendreMotion:
    """Two equal moments, no torque: q = exp(L t/2 I1) q(0) exp(e3 γ̇ t/2) (the same, §33)."""
    with mp.workdps(DIGITS):
        moments, omega = problem.moments, problem.omega_axes
        axis = next(k for k in range(3) if moments[k - 1] == moments[k - 2])
        spin = omega[axis] * (1 - moments[axis] / moments[axis - 1])
        L_axes: Vector = tuple(i * w for i, w in zip(moments, omega, strict=True))
        L_world = rotate(problem.q_world_axes, L_axes)
        precession = tuple(x / moments[axis - 1] for x in L_world)

        def state(t: float) -> tuple[Quaternion, Vector]:
            with mp.workdps(DIGITS):
                about_axis = _turn(unit(axis, 1), spin * t)
                q = product(_turn(precession, mpf(t)), problem.q_world_axes)
                return product(q, about_axis), rotate(conjugate(about_axis), omega)

        return LegendreMotion(state, 2 * mp.pi / abs(spin))


def _turn(rate: Vector, t: mpf) -> Quaternion:
    """exp(rate t/2): rotation at a constant rate."""
    speed = mp.sqrt(dot(rate, rate))
    cosine, sine = mp.cos(speed * t / 2), mp.sin(speed * t / 2)
    x, y, z = (sine * n / speed for n in rate)
    return (cosine, x, y, z)


def _circulating(problem: Problem) -> tuple[tuple[Vector, Vector, Vector], mpf, mpf]:
    """Right-handed axes, e2 that of the middle moment and ω·e3 > 0 always; L² and 2E."""
    moments, omega = problem.moments, problem.omega_axes
    squared = sum((i * w) ** 2 for i, w in zip(moments, omega, strict=True))
    E2 = sum(i * w * w for i, w in zip(moments, omega, strict=True))
    low, middle, high = sorted(range(3), key=lambda k: moments[k])
    around, other = (high, low) if squared > E2 * moments[middle] else (low, high)
    e3 = unit(around, 1 if omega[around] > 0 else -1)
    e1 = unit(other, 1)
    return (e1, cross(e3, e1), e3), squared, E2


def _amplitudes(moments: Vector, squared: mpf, E2: mpf) -> Vector:
    """Of cn, sn and dn (Landau & Lifshitz §37)."""
    I1, I2, I3 = moments
    return (
        mp.sqrt((E2 * I3 - squared) / (I1 * (I3 - I1))),
        mp.sqrt((E2 * I3 - squared) / (I2 * (I3 - I2))),
        mp.sqrt((squared - E2 * I1) / (I3 * (I3 - I1))),
    )


def quaternion(A: mpc, B: mpc) -> Quaternion:
    """Of Cayley–Klein parameters A = cos(β/2) e^{i(α+γ)/2}, B = sin(β/2) e^{i(α−γ)/2}."""
    return (A.real, -B.imag, B.real, A.imag)


def unit(axis: int, sign: int) -> Vector:
    """± the unit vector of an axis."""
    x, y, z = (mpf(sign if k == axis else 0) for k in range(3))
    return (x, y, z)


def to_axes(triad: tuple[Vector, Vector, Vector], vector: Vector) -> Vector:
    """From components along a triad to those along the axes it is given in."""
    x, y, z = (dot(vector, column) for column in zip(*triad, strict=True))
    return (x, y, z)
