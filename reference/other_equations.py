"""Equations of motion that need not be a scene's: candidates for what an engine computed.

They may differ from a scene's in the inertia tensor, in a gyroscopic torque ω × Gω whose tensor G
is not the one in I ω', in other torques, or in the relation between ω and the attitude.
"""

from typing import Self

import numpy as np

from ..scenarios import FloatArray, Scenario
from .rows import Entry, Rows

#: How q' follows from q and ω. `BODY` is right: q' = ½ q (0, ω) with ω along body axes. `WORLD` is
#: q' = ½ (0, ω) q with the same components, as if they were along world axes. `KEPT_IN_WORLD` is
#: q' = ½ q (0, ω) with components along world axes, as if they were along body axes; these
#: components are also the ones that are integrated.
BODY, WORLD, KEPT_IN_WORLD = 0, 1, 2
#: A kinematic number from here on is a convention of Euler angles, `FIRST_ANGLES` + 9 i + 3 j + k
#: for R = R_i(a) R_j(b) R_k(c): the components of ω are taken for the rates of these angles.
FIRST_ANGLES = 3
#: How vectors along world axes are turned to body axes: by Rᵀ, which is right; by R; not at all; or
#: not at all, where the torque of gravity is first computed along world axes.
TURNED_BACK, TURNED_ON, UNTURNED, TORQUE_UNTURNED = 0, 1, 2, 3


class OtherEquations(Rows):
    """Numbers of one or several sets of equations of motion, SI.

    Torques are along body axes unless their names say otherwise. The shapes below are those for one
    set; for E sets each array has a further first axis, of length E.

    I ω' = τ − ω × (G ω + h) and q' = ½ q (A ω), τ = l × Rᵀg + torque + Rᵀ torque_world − (c + (a +
    b ‖ω‖) I) ω − (a + b ‖ω‖) h − (D + f ‖ω‖ᵖ + u R + v Rᵀ) ω + Σᵢ P eᵢ × Rᵀ eᵢ + Σᵢ eᵢ × I Rᵀ S R
    eᵢ, plus the torques of `spring` and of a table's force, which can also pull. R is the matrix of
    q, body to world, and D is diagonal. The attitude turns at A ω + s − Rᵀ w.

    Attributes
    ----------
    inertia, inverse : I, kg m², and its inverse, (3, 3)
    gyroscopic : G, kg m², (3, 3)
    turning : A, which has no unit, (3, 3)
    kept : h, the sum of the rotors' constant angular momenta about their axles, kg m²/s, (3,)
    gravity_world : g, m/s², (3,)
    pull : l, mass times the vector from a pivot to the com, kg m, (3,); zero without a pivot
    torque, torque_world : constant torques along body axes and along world axes, N m, (3,)
    slowing : c, N m s; a, 1/s; and b, which has no unit; (3,)
    damping : the diagonal of D, N m s, (3,)
    friction : f, N m sᵖ⁺¹, and p
    turned_drag : u, v, N m s: resistance to ω turned from body to world axes, or from world to body
        axes, once too often
    attitude_torque : P, N m: m bᵀ for a dipole m, body axes, in a field b, world axes; and k/2 R₀ᵀ
        for a spring, k N m, to the attitude R₀; (3, 3)
    spring : k R₀, N m: a torque −k φ by the rotation vector φ from the attitude R₀; (3, 3)
    gravity_gradient : S, symmetric, along world axes: κ z zᵀ for a torque κ z × I z; 1/s², (3, 3)
    body_turns : s, angular velocity of the body in addition to A ω, body axes, rad/s, (3,); used
        only with `BODY`
    world_turns : w, angular velocity of the world, world axes, rad/s, (3,); used only with `BODY`
    world_vectors : how g and torque_world are turned to body axes, which is by Rᵀ in the formula
        above: `TURNED_BACK`, `TURNED_ON`, `UNTURNED` or `TORQUE_UNTURNED`
    lever : vector from the tip on a table to the com, m, (3,); not used without a table
    mobility : 1/mass, 1/kg; 0 without a table
    tensor_turns : how often R turns vectors before I and G are applied: 0 if these are constant
        along body axes, 1 if along world axes, and 2 if ω along world axes is computed as
        Rᵀ I⁻¹ R L in place of the correct R I⁻¹ Rᵀ L
    kinematics : `BODY`, `WORLD`, `KEPT_IN_WORLD`, or the number of a convention of Euler angles
    rate : fastest rate, besides ‖ω‖, at which the state may change, rad/s
    has_torque_of_attitude : 1 if `attitude_torque`, `spring` or `gravity_gradient` is not zero,
        else 0; set by `all_numbers`
    """

    inertia = Entry(3, 3)
    inverse = Entry(3, 3)
    gyroscopic = Entry(3, 3)
    turning = Entry(3, 3)
    kept = Entry(3)
    gravity_world = Entry(3)
    pull = Entry(3)
    torque = Entry(3)
    torque_world = Entry(3)
    slowing = Entry(3)
    damping = Entry(3)
    friction = Entry(2)
    turned_drag = Entry(2)
    attitude_torque = Entry(3, 3)
    spring = Entry(3, 3)
    gravity_gradient = Entry(3, 3)
    body_turns = Entry(3)
    world_turns = Entry(3)
    world_vectors = Entry()
    lever = Entry(3)
    mobility = Entry()
    tensor_turns = Entry()
    kinematics = Entry()
    rate = Entry()
    has_torque_of_attitude = Entry()

    def with_inertia(self, inertia: FloatArray) -> Self:
        """Return the equations with another tensor for both I and G, kg m², (..., 3, 3).

        Its inverse is nan if the tensor is singular.
        """
        return self.of(inertia=inertia, inverse=inverse(inertia), gyroscopic=inertia)


def inverse(matrices: FloatArray) -> FloatArray:
    """Return the inverses of matrices, (..., n, n); all nan for those that are singular."""
    try:
        return np.asarray(np.linalg.inv(matrices), dtype=float)
    except np.linalg.LinAlgError:
        if matrices.ndim > 2:
            return np.stack([inverse(one) for one in matrices])
        return np.full_like(matrices, np.nan)


def equations_of(scenario: Scenario) -> OtherEquations:
    """Return a scene's own equations of motion, in the form of `OtherEquations`."""
    constraint, pushed = scenario.constraint, scenario.pushed
    inertia = np.array(scenario.inertia)
    return OtherEquations(np.zeros(OtherEquations.count)).of(
        inertia=inertia,
        inverse=inverse(inertia),
        gyroscopic=inertia,
        turning=np.eye(3),
        kept=scenario.kept_body(scenario.kept_at_start),
        gravity_world=scenario.gravity_world,
        pull=scenario.body.mass * np.array(constraint.lever) * constraint.is_pivot,
        torque=pushed["torque_body"],
        torque_world=pushed["torque_world"],
        slowing=[pushed["drag"], 0.0, 0.0],
        world_vectors=TURNED_BACK,
        lever=constraint.lever,
        mobility=1 / scenario.body.mass if scenario.answer is not None else 0.0,
        kinematics=BODY,
        rate=max((one.rate(scenario) for one in scenario.acting), default=0.0),
    )
