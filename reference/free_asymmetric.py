"""The free body with three distinct moments: Jacobi's solution, by theta quotients.

The principal axes are renumbered and reversed so that I2 is the middle moment, ω circulates about
e3 (the axis of the largest moment where D = L² − 2 E I2 >= 0, of the smallest where D < 0), ω3 > 0
and s ω1 >= 0 with s = sign(I2 − I1). Then ω and the Cayley–Klein parameters A and B are (Landau &
Lifshitz, Mechanics, §37; derivation: docs/explanation/closed-forms.md)::

    ω = (s a1 cn, a2 sn, a3 dn)(u | m)        u = p t + u0
    A ∝ e^{iΩt} θ1(z + i σ η_A | q²)/√θ4(z | q)
    B ∝ e^{iΩt} θ1(z − i σ η_B | q²)/√θ4(z | q)        z = π u/2K, σ = 1 for the largest moment

in a frame with z along L; η_A and η_B follow from the zeros of A and B (C. G. J. Jacobi, J. reine
angew. Math. 39 (1850) 293; Whittaker, Analytical Dynamics, §69).
"""

from dataclasses import dataclass

from mpmath import mp, mpc, mpf

from ..scenarios.exact import DIGITS, Vector, conjugate, cross, product
from ..scenarios.principal import from_matrix
from .cayley_klein import CayleyKlein, along, with_L_upright
from .effect_terms import is_free
from .elliptic import Jacobi, Lattice, first_kind, jacobi, scaled, theta
from .problem import Problem
from .steady_motions import rigid_rotation, turns_rigidly
from .symmetry import UNIT_VECTORS, equal, moment_about
from .theta_quotients import (
    NOTHING,
    Clock,
    ClosedForm,
    Frames,
    InitialValue,
    Quotient,
    fitted,
    over_theta4,
    tables,
)

#: Decimal digits in which products of five doubles, and differences of these, are exact.
EXACT_DIGITS = 3 * DIGITS
SIGN_CHANGE = mpf(1) / 2  # a change of sign in each half period, as a phase in turns


@dataclass(frozen=True)
class JacobiMotion:
    """The constants of ω = (s a1 cn, a2 sn, a3 dn)(u | m), u = p t + u0, of a free body.

    The components are along the principal axes e1, e2, e3 that the module defines: e2 is that of
    the middle moment, and ω circulates about e3.

    Attributes
    ----------
    moments : I1, I2, I3, kg m²
    amplitudes : s a1, a2, a3, rad/s, with s = 1 if I2 > I1, else −1
    p : du/dt, rad/s
    lattice : periods of the elliptic functions of parameter m
    sin_squared, cos_squared : sn² and cn² at t = 0
    rising : whether sn >= 0 at t = 0
    """

    moments: Vector
    amplitudes: Vector
    p: mpf
    lattice: Lattice
    sin_squared: mpf
    cos_squared: mpf
    rising: bool

    @property
    def u0(self) -> mpf:
        """The argument u of sn, cn and dn at t = 0, in [−K, K], with K the quarter period."""
        u = first_kind(self.sin_squared, self.cos_squared, self.lattice.m1)
        return u if self.rising else -u

    @property
    def largest(self) -> bool:
        """Whether ω circulates about the axis of the largest moment."""
        return bool(self.moments[2] > self.moments[1])


def free_asymmetric(problem: Problem) -> ClosedForm:
    """Return the motion of a free body with three distinct moments.

    Raises
    ------
    ValueError
        If a torque acts or two moments are equal.
    """
    low, middle, high = sorted(problem.moments)
    if not is_free(problem) or equal(low, middle) or equal(middle, high):
        raise ValueError("'problem' must be a free body with three distinct moments.")
    if turns_rigidly(problem):
        return rigid_rotation(problem)
    with mp.workdps(EXACT_DIGITS):
        triad, D = _triad(problem)
        omega = along(triad, problem.omega_axes)
        I1, I2, I3 = (moment_about(problem, axis) for axis in triad)
        body = _jacobi_motion((I1, I2, I3), omega, D)
    with mp.workdps(DIGITS):
        return _closed_form(problem, triad, omega, body)


def _triad(problem: Problem) -> tuple[tuple[Vector, Vector, Vector], mpf]:
    """Return the axes e1, e2, e3 that the module defines, in principal components, and |D|.

    D = L² − 2 E I2, with I2 the middle moment, decides which principal axis is e3.
    """
    moments, omega = problem.moments, problem.omega_axes
    low, middle, high = sorted(range(3), key=lambda k: moments[k])
    above = moments[high] * (moments[high] - moments[middle]) * omega[high] ** 2
    below = moments[low] * (moments[middle] - moments[low]) * omega[low] ** 2
    D = mpf(0) if equal(above, below) else above - below
    around, other, s = (high, low, 1) if D >= 0 else (low, high, -1)
    e3 = _directed(around, omega[around] >= 0)
    e1 = _directed(other, s * omega[other] >= 0)
    return (e1, cross(e3, e1), e3), abs(D)


def _directed(axis: int, forward: bool) -> Vector:
    """Return the unit vector along a principal axis, 0 to 2, or against it if not `forward`."""
    x, y, z = UNIT_VECTORS[axis]
    return (x, y, z) if forward else (-x, -y, -z)


def _jacobi_motion(moments: Vector, omega: Vector, D: mpf) -> JacobiMotion:
    """Return the constants of ω(t), given moments and ω at t = 0 along e1, e2, e3.

    The parameter D is |L² − 2 E I2|, kg² m⁴/s²; e1, e2 and e3 are the axes that `_triad` returns.
    The formulas are those of Landau & Lifshitz §37, eq. 37.8–10. |L² − 2 E I_k| for k = 1, 3 is
    computed as a sum of squares, which loses no digits.
    """
    I1, I2, I3 = moments
    w1, w2, w3 = omega
    d12, d13, d23 = abs(I1 - I2), abs(I1 - I3), abs(I2 - I3)
    P1 = I2 * d12 * w2**2 + I3 * d13 * w3**2
    P3 = I1 * d13 * w1**2 + I2 * d23 * w2**2
    s = 1 if I2 > I1 else -1
    amplitudes = (
        s * mp.sqrt(P3 / (I1 * d13)),
        mp.sqrt(P3 / (I2 * d23)),
        mp.sqrt(P1 / (I3 * d13)),
    )
    return JacobiMotion(
        moments,
        amplitudes,
        p=mp.sqrt(d23 * P1 / (I1 * I2 * I3)),
        lattice=Lattice(d12 * P3 / (d23 * P1), d13 * D / (d23 * P1)),
        sin_squared=I2 * d23 * w2**2 / P3,
        cos_squared=I1 * d13 * w1**2 / P3,
        rising=bool(w2 >= 0),
    )


def _closed_form(
    problem: Problem, triad: tuple[Vector, Vector, Vector], omega: Vector, body: JacobiMotion
) -> ClosedForm:
    """Return the closed form of a body's motion.

    Parameters
    ----------
    triad : the axes e1, e2, e3 in principal components
    omega : ω along these axes at t = 0, rad/s
    body : the constants of ω(t) along these axes
    """
    I1, I2, I3 = body.moments
    start = with_L_upright((I1 * omega[0], I2 * omega[1], I3 * omega[2]))
    q_frame_axes = from_matrix(triad)
    q_left = product(problem.q_world_axes, conjugate(product(start.quaternion, q_frame_axes)))
    lattice = body.lattice
    clock = Clock(lattice, body.p * lattice.scale, body.u0 * lattice.scale)
    functions = jacobi(lattice)
    A, B, residual = _attitude(body, clock, functions, start, omega)
    quotients = (A, B, *_angular_velocity(body, functions))
    return ClosedForm(
        "Jacobi's closed form, theta quotients",
        tables(clock, quotients, Frames(q_left, q_frame_axes, triad)),
        float(residual),
        float(4 * lattice.K / body.p),
    )


def _attitude(
    body: JacobiMotion, clock: Clock, functions: Jacobi, start: CayleyKlein, omega: Vector
) -> tuple[Quotient, Quotient, mpf]:
    """Return the Cayley–Klein parameters A and B as theta quotients, and a residual.

    The residual is the sum of the relative residuals that `fitted` returns for the two quotients.

    Parameters
    ----------
    body : the constants of ω(t)
    clock : the argument x of the theta functions as a function of t
    functions : the Jacobi functions of the lattice, by the clock's argument x
    start : A and B at t = 0, in a frame with z along L
    omega : ω along e1, e2, e3 at t = 0, rad/s
    """

    def at(x: mpf) -> tuple[CayleyKlein, tuple[mpc, mpc]]:
        """Return A, B and their derivatives by time, A' and B', 1/s, at an argument x of thetas.

        All four are multiplied by the same phase factor, chosen so that A is real. The factor
        cancels in A'/A and B'/B.
        """
        sn, cn, dn = functions(x)
        (a1, a2, a3), (I1, I2, I3) = body.amplitudes, body.moments
        w = (a1 * cn, a2 * sn, a3 * dn)
        attitude = with_L_upright((I1 * w[0], I2 * w[1], I3 * w[2]))
        return attitude, attitude.rates(w)

    def log_rate_of_A(x: mpf) -> mpc:
        attitude, rates = at(x)
        return rates[0] / attitude.A

    def log_rate_of_B(x: mpf) -> mpc:
        attitude, rates = at(x)
        return rates[1] / attitude.B

    A_rate, B_rate = start.rates(omega)
    y_A, y_B = _zeros(body)
    over_A = theta(1, clock.lattice, y_A, doubled=True)
    over_B = theta(1, clock.lattice, y_B, doubled=True)
    A, residual_A = fitted(clock, over_A, 1, InitialValue(start.A, A_rate), log_rate_of_A)
    B, residual_B = fitted(clock, over_B, 1, InitialValue(start.B, B_rate), log_rate_of_B)
    return A, B, residual_A + residual_B


def _zeros(body: JacobiMotion) -> tuple[mpf, mpf]:
    """Return the imaginary parts y of u at which the Cayley–Klein parameters A and B vanish.

    A vanishes where the component of L along e3 is L3 = −|L|, and B where L3 = |L|.

    With c = I3 a3/|L|, L3 = |L| at u = iy means c dn(iy|m) = 1. As dn(iy|m) = dn/cn(y|m1) (DLMF
    22.6.12), tan² am y = (1 − c²)/(m c²) for B; A vanishes at y − 2K'. If ω circulates about the
    axis of the smallest moment, the two numbers have the opposite sign.
    """
    (I1, _, I3), (a1, _, a3) = body.moments, body.amplitudes
    m, away, near = body.lattice.m, (I1 * a1) ** 2, (I3 * a3) ** 2
    whole = away + m * near
    y = first_kind(away / whole, m * near / whole, m)
    sign = 1 if body.largest else -1
    return sign * (y - 2 * body.lattice.K1), sign * y


def _angular_velocity(body: JacobiMotion, functions: Jacobi) -> tuple[Quotient, Quotient]:
    """Return W = ω2 + iω1 and ω3 as quotients of theta functions.

    Parameters
    ----------
    body : the constants of ω(t)
    functions : the Jacobi functions of the body's lattice
    """
    a1, a2, a3 = body.amplitudes
    W = over_theta4(scaled(functions.sn, a2), scaled(functions.cn, a1), SIGN_CHANGE)
    return W, over_theta4(scaled(functions.dn, a3), NOTHING, mpf(0))
