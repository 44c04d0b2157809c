"""Motions at constant rates: rotation about a fixed axis, and regular precession."""

from mpmath import mp, mpc, mpf

from ..scenarios.exact import DIGITS, Vector, conjugate, product
from ..scenarios.principal import from_matrix
from .cayley_klein import CayleyKlein, transverse
from .problem import Problem
from .symmetry import UNIT_VECTORS, across, equal, norm, scaled
from .theta_quotients import ClosedForm, Frames, tables, turning

ZERO = mpc(0)


def turns_rigidly(problem: Problem) -> bool:
    """Whether ω is along L at t = 0, so that it stays constant without torque.

    See Landau & Lifshitz §36.
    """
    moments, omega = problem.moments, problem.omega_axes
    with mp.workdps(DIGITS):
        speed = norm(omega)
        still = [equal(w, 0, speed) for w in omega]
        return all(
            equal(moments[i], moments[j]) or still[i] or still[j]
            for i, j in ((0, 1), (1, 2), (2, 0))
        )


def rigid_rotation(problem: Problem) -> ClosedForm:
    """Return the motion with constant ω, or at rest: q(t) = q(0) exp(ω t/2)."""
    omega = problem.omega_axes
    with mp.workdps(DIGITS):
        speed = norm(omega)
        axis = scaled(omega, 1 / speed) if speed else UNIT_VECTORS[2]
        e1, e2 = across(axis)
        q_frame_axes = from_matrix((e1, e2, axis))
        frames = Frames(
            product(problem.q_world_axes, conjugate(q_frame_axes)), q_frame_axes, (e1, e2, omega)
        )
        # In place of the third unit vector stands ω itself, with 1 as its component: so ω is
        # rounded only once.
        quotients = (turning(mpc(1), speed / 2), turning(ZERO), turning(ZERO), turning(mpc(1)))
        return ClosedForm("Rotation about a fixed axis", tables(None, quotients, frames), 0.0, None)


def regular_precession(
    frames: Frames,
    start: CayleyKlein,
    omega: Vector,
    rates: tuple[mpf, mpf],
) -> ClosedForm:
    """Return the closed form of steady precession and spin at a constant tilt.

    A and B are the Cayley–Klein parameters, and α, β, γ the Euler angles ZYZ, as in `cayley_klein`.
    |A|, |B| and ω3 are constant, and so is |W|, with W = ω2 + iω1. The equation
    A' = ½ (iω3 A − W B) makes W proportional to A B*, so that the phase of W changes at the rate of
    A's phase less that of B's, which is γ'.

    Parameters
    ----------
    frames : rotations that relate the frames of A and B to the world and to the principal axes
    start : A and B at t = 0
    omega : angular velocity at t = 0 along the axes of the top's frame, rad/s
    rates : rates of the phases of A and B, (α' + γ')/2 and (α' − γ')/2, rad/s
    """
    of_A, of_B = rates
    quotients = (
        turning(start.A, of_A),
        turning(start.B, of_B),
        turning(transverse(omega), of_A - of_B),
        turning(mpc(omega[2])),
    )
    return ClosedForm("Regular precession", tables(None, quotients, frames), 0.0, None)
