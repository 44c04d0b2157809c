"""Lagrange's heavy symmetric top, by theta quotients.

Let e3 be its axis from the pivot to the centre of mass, z the upward vertical, and u = cos β and U
as in `nutation`. Then the Cayley–Klein parameters A and B, and W = ω2 + iω1, are (F. Klein & A.
Sommerfeld, Über die Theorie des Kreisels, ch. VI; Whittaker, Analytical Dynamics, §71; derivation:
docs/explanation/closed-forms.md)::

    A ∝ e^{iΩt} θ1(z − iη_A)/θ4(z)        B ∝ e^{iΩt} θ2(z − iη_B)/θ4(z)
    W ∝ e^{iΩt} θ2(z − iη_W)/θ4(z)        z = π (p t + u0)/2K

A, B and W vanish where u = −1, 1 and U. Where the axis is vertical, a theta function has a simple
zero: a top that passes through the vertical, or starts there, is no exception.
"""

from collections.abc import Callable

from mpmath import mp, mpc, mpf

from ..scenarios.exact import DIGITS, Quaternion, Vector, conjugate, product
from ..scenarios.principal import from_matrix
from .cayley_klein import CayleyKlein, along, of_quaternion, transverse
from .effect_terms import is_undriven
from .elliptic import Theta, first_kind, jacobi, theta
from .nutation import Constants, Nutation, constants, nutation
from .problem import Problem
from .steady_motions import regular_precession, rigid_rotation
from .symmetry import (
    across,
    equal,
    gravity_torque_scale,
    moments_across_and_along,
    norm,
    scaled,
    symmetry_axis,
)
from .theta_quotients import Clock, ClosedForm, Frames, InitialValue, fitted, tables, turning

#: Digits in which roots are computed: where two or three roots of the nutation cubic meet, a
#: root has only half or a third of the digits.
ROOT_DIGITS = 3 * DIGITS

LogRate = Callable[[mpf], mpc]


def lagrange(problem: Problem) -> ClosedForm:
    """Return the motion of a symmetric body with the fixed point on its axis, under gravity alone.

    The axis may be any principal axis, in either direction; in a sphere it may be any direction.

    Raises
    ------
    ValueError
        If the body is not symmetric about the line from pivot to com, if gravity exerts no torque,
        or if anything else turns the body.
    """
    axis, kappa = symmetry_axis(problem), gravity_torque_scale(problem)
    if axis is None or kappa == 0 or not is_undriven(problem):
        raise ValueError(
            "'problem' must be a body symmetric about the lever that gravity alone pulls at."
        )
    with mp.workdps(ROOT_DIGITS):
        triad = (*across(axis), axis)
        frames = _frames(problem, triad)
        start = _attitude(problem, frames)
        omega = along(triad, problem.omega_axes)
        I1, I3 = moments_across_and_along(problem, axis)
        if _rests_at_a_pole(start, omega, mp.sqrt(kappa / I1)):
            return rigid_rotation(problem)
        constants_of_motion = constants(start, omega, 2 * kappa / I1, I3 * omega[2] / I1)
        swing = nutation(constants_of_motion)
    with mp.workdps(DIGITS):
        if swing is None:
            return _steady(frames, start, omega, constants_of_motion)
        return _swinging(frames, start, omega, constants_of_motion, swing)


def _frames(problem: Problem, triad: tuple[Vector, Vector, Vector]) -> Frames:
    """Return the two frames that the Cayley–Klein parameters A and B relate, as rotations.

    One frame is fixed in the world, with z upward; its rotation takes its axes to those of the
    world. The other is fixed in the top, with the axes `triad`, in principal components; its
    rotation takes its axes to the principal axes.
    """
    up_world = scaled(problem.gravity_world, -1 / norm(problem.gravity_world))
    return Frames(conjugate(_upright(up_world)), from_matrix(triad), triad)


def _upright(up: Vector) -> Quaternion:
    """Return a quaternion that turns the unit vector `up` to z; exactly (1, 0, 0, 0) for z."""
    x, y, z = up
    if z < 0:
        return product(_upright((x, -y, -z)), (mpf(0), mpf(1), mpf(0), mpf(0)))
    length = mp.sqrt(2 * (1 + z))
    return ((1 + z) / length, y / length, -x / length, mpf(0))


def _attitude(problem: Problem, frames: Frames) -> CayleyKlein:
    """Return A and B, Cayley–Klein parameters of the top's frame in the upright one, at t = 0."""
    q = product(product(conjugate(frames.q_left), problem.q_world_axes), conjugate(frames.q_right))
    length = mp.sqrt(mp.fsum(c * c for c in q))
    w, x, y, z = (c / length for c in q)
    return of_quaternion((w, x, y, z))


def _rests_at_a_pole(start: CayleyKlein, omega: Vector, rate: mpf) -> bool:
    """Whether the axis points along the vertical and stays there: the top sleeps or is at rest.

    Parameters
    ----------
    start : the attitude at t = 0
    omega : ω along the axes of the top's frame at t = 0, rad/s
    rate : √(M g l/I1), rad/s; ω across the axis counts as zero if it is negligible beside
        rate + |ω3|
    """
    near = min(abs(start.A), abs(start.B))
    return equal(near, 0, 1) and equal(abs(transverse(omega)), 0, rate + abs(omega[2]))


def _steady(
    frames: Frames, start: CayleyKlein, omega: Vector, constants_of_motion: Constants
) -> ClosedForm:
    """Return steady precession in closed form: |A|, |B| and the rates of both phases are constant.

    Parameters
    ----------
    frames : the rotations that relate the frames of A and B to the world and to principal axes
    start : the Cayley–Klein parameters A and B of the attitude at t = 0
    omega : ω along the axes of the top's frame at t = 0, rad/s
    constants_of_motion : the constants that follow from this start
    """
    delta, spin = constants_of_motion.delta, omega[2] - constants_of_motion.d
    above, below = (2 - delta, delta) if constants_of_motion.pole > 0 else (delta, 2 - delta)
    rates = (
        (constants_of_motion.c_plus_d / above + spin) / 2,
        (constants_of_motion.c_minus_d / below - spin) / 2,
    )
    return regular_precession(frames, start, omega, rates)


def _swinging(
    frames: Frames,
    start: CayleyKlein,
    omega: Vector,
    constants_of_motion: Constants,
    swing: Nutation,
) -> ClosedForm:
    """Return the closed form of a top whose tilt varies.

    Parameters
    ----------
    frames : the rotations that relate the frames of A and B to the world and to principal axes
    start : the attitude at t = 0
    omega : ω along the axes of the top's frame at t = 0, rad/s
    constants_of_motion : the constants that follow from this start
    swing : the nutation that follows from these constants
    """
    lattice = swing.lattice
    u0 = first_kind(swing.sin_squared, swing.cos_squared, lattice.m1)
    at_start = (u0 if constants_of_motion.rising else -u0) * lattice.scale
    clock = Clock(lattice, swing.p * lattice.scale, at_start)
    rows, residual = [], mpf(0)
    for numerator, begin, log_rate in zip(
        _numerators(constants_of_motion, swing),
        _starts(start, omega, constants_of_motion),
        _log_rates(omega, constants_of_motion, swing),
        strict=True,
    ):
        quotient, error = fitted(clock, numerator, 2, begin, log_rate)
        rows.append(quotient)
        residual += error
    return ClosedForm(
        "Lagrange's top in Klein and Sommerfeld's closed form, theta quotients",
        tables(clock, [*rows, turning(mpc(omega[2]))], frames),
        float(residual),
        float(2 * lattice.K / swing.p),
    )


def _starts(
    start: CayleyKlein, omega: Vector, constants_of_motion: Constants
) -> tuple[InitialValue, InitialValue, InitialValue]:
    """Return A, B and W = ω2 + iω1 at t = 0, with their derivatives.

    By Euler's equations W' = i (ω3 − d) W + b A B*, with b and d of `Constants`.

    Parameters
    ----------
    start : the Cayley–Klein parameters A and B of the attitude at t = 0
    omega : ω along the axes of the top's frame at t = 0, rad/s
    constants_of_motion : the constants that follow from this start
    """
    W = transverse(omega)
    W_rate = mpc(
        0, omega[2] - constants_of_motion.d
    ) * W + constants_of_motion.b * start.A * mp.conj(start.B)
    A_rate, B_rate = start.rates(omega)
    return InitialValue(start.A, A_rate), InitialValue(start.B, B_rate), InitialValue(W, W_rate)


def _numerators(constants_of_motion: Constants, swing: Nutation) -> tuple[Theta, Theta, Theta]:
    """Return the numerators of A, B and W: θ1 or θ2, with arguments shifted by an imaginary iy.

    A and B are the Cayley–Klein parameters; they and W are quotients of theta functions.
    u = cos β moves between u1 and u2. A vanishes where u is −1: at the argument iy with
    sc²(y|m1) = (1 + u1)/(u2 − u1). B vanishes where u is 1, and W = ω2 + iω1 where u is a constant
    U: both at K + iy with nd²(y|m1) = (u − u1)/(u2 − u1). The functions sc and nd give the sine and
    cosine of the amplitude of y. On the separatrix, m1 = 0, the series of θ2 is a constant,
    whatever y is.

    Parameters
    ----------
    constants_of_motion : the constants of motion, and the state at t = 0
    swing : the nutation that follows from these constants
    """
    lattice, below, above = swing.lattice, swing.below, swing.above
    y_A = first_kind(above[0] / above[1], swing.u21 / above[1], lattice.m)
    y_B = y_W = mpf(0)
    if lattice.m1:
        y_B = _zero_beyond(below[1], -below[2], swing)
        y_W = _zero_beyond(swing.U2, max(swing.u32 - swing.U2, mpf(0)), swing)
    at_U = constants_of_motion.c_minus_d_times(below[1] - swing.U2, above[1] + swing.U2)
    return (
        theta(1, lattice, _sign(constants_of_motion.c_plus_d) * y_A),
        theta(2, lattice, _sign(constants_of_motion.c_minus_d) * y_B),
        theta(2, lattice, _sign(at_U) * y_W),
    )


def _zero_beyond(to_u2: mpf, to_u3: mpf, swing: Nutation) -> mpf:
    """Return y of the argument K + iy at which cos β has a given value u between u2 and u3.

    K is the quarter period of the elliptic functions.

    Parameters
    ----------
    to_u2, to_u3 : the distances u − u2 and u3 − u
    swing : the nutation, whose cubic has the zeros u2 and u3
    """
    whole = (to_u2 + swing.u21) * swing.u32
    return first_kind(to_u2 * swing.u31 / whole, to_u3 * swing.u21 / whole, swing.lattice.m)


def _sign(value: mpf) -> int:
    """Return the sign of a number, 1 or −1; 1 for zero, where both signs would be right."""
    return -1 if value < 0 else 1


def _log_rates(
    omega: Vector, constants_of_motion: Constants, swing: Nutation
) -> tuple[LogRate, LogRate, LogRate]:
    """Return A'/A, B'/B and W'/W, 1/s, as functions of the argument x of the theta functions.

    A and B are the Cayley–Klein parameters, and W = ω2 + iω1. The quotients follow from u = cos β,
    u̇ and the constants of motion.

    Parameters
    ----------
    omega : ω along the axes of the top's frame at t = 0, rad/s
    constants_of_motion : the constants of motion, and the state at t = 0
    swing : the nutation that follows from these constants
    """
    functions, spin = jacobi(swing.lattice), omega[2] - constants_of_motion.d

    def height(x: mpf) -> tuple[mpf, mpf, mpf]:
        """Return sn², cn² and the rate of u = cos β, 1/s, at the argument x of the thetas."""
        sn, cn, dn = functions(x)
        return sn**2, cn**2, 2 * swing.p * swing.u21 * sn * cn * dn

    def of_A(x: mpf) -> mpc:
        sn2, _, u_rate = height(x)
        return (
            mpc(u_rate, constants_of_motion.c_plus_d) / (swing.above[0] + swing.u21 * sn2)
            + mpc(0, spin)
        ) / 2

    def of_B(x: mpf) -> mpc:
        _, cn2, u_rate = height(x)
        below = swing.below[1] + swing.u21 * cn2
        return (mpc(-u_rate, constants_of_motion.c_minus_d) / below - mpc(0, spin)) / 2

    def of_W(x: mpf) -> mpc:
        sn2, cn2, u_rate = height(x)
        below, above = swing.below[1] + swing.u21 * cn2, swing.above[0] + swing.u21 * sn2
        turn = mpc(-u_rate, constants_of_motion.c_minus_d_times(below, above))
        return turn / (2 * (swing.U2 + swing.u21 * cn2)) + mpc(0, spin)

    return of_A, of_B, of_W
