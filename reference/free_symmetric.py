"""The free top with two equal moments: regular precession about L (Landau & Lifshitz §33)."""

from dataclasses import replace

from mpmath import mp

from ..scenarios.exact import DIGITS, conjugate, dot, product
from ..scenarios.principal import from_matrix
from .cayley_klein import along, with_L_upright
from .effect_terms import is_free
from .problem import Problem
from .steady_motions import regular_precession, rigid_rotation, turns_rigidly
from .symmetry import (
    across,
    angular_momentum_axes,
    equal,
    moments_across_and_along,
    norm,
    scaled,
    symmetry_axis,
)
from .theta_quotients import ClosedForm, Frames


def free_symmetric(problem: Problem) -> ClosedForm:
    """Return the motion of a free body with two or three equal moments.

    With I1 the moment across the axis e3 of symmetry and I3 the one about it, the body precesses
    about L at |L|/I1 and spins about e3 at γ' = ω3 (1 − I3/I1):
    q(t) = exp(L t/2 I1) q(0) exp(e3 γ' t/2). If all moments are equal, or ω is along L, it rotates
    about a fixed axis.

    Raises
    ------
    ValueError
        If a torque acts or all moments are distinct.
    """
    axis = symmetry_axis(problem)
    sphere = equal(min(problem.moments), max(problem.moments))
    if not is_free(problem) or (axis is None and not sphere):
        raise ValueError("'problem' must be a free body with two equal moments.")
    if axis is None or turns_rigidly(problem):
        return rigid_rotation(problem)
    with mp.workdps(DIGITS):
        if dot(axis, problem.omega_axes) < 0:
            axis = scaled(axis, -1)
        triad = (*across(axis), axis)
        L, omega = (along(triad, v) for v in (angular_momentum_axes(problem), problem.omega_axes))
        start, q_frame_axes = with_L_upright(L), from_matrix(triad)
        q_left = product(problem.q_world_axes, conjugate(product(start.quaternion, q_frame_axes)))
        I1, I3 = moments_across_and_along(problem, axis)
        precession, spin = norm(L) / I1, omega[2] * (1 - I3 / I1)
        rates = ((precession + spin) / 2, (precession - spin) / 2)
        form = regular_precession(Frames(q_left, q_frame_axes, triad), start, omega, rates)
        return replace(form, period=float(2 * mp.pi / abs(spin)))
