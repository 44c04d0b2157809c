"""Equations of motion that need not be a scene's.

What a motion is compared with, to find what was computed instead of the exact one: a tensor that is
another one, a gyroscopic torque ω × Gω with another tensor G than in I ω', an attitude that follows
ω otherwise.
"""

from typing import NamedTuple

import numpy as np

from ..scenarios import FloatArray, Scenario

#: How q' is a product of q and ω: as it is due; with ω, along body axes, on the side of world axes;
#: or with ω, along world axes, in which its components are kept, on the side of body axes.
BODY, WORLD, KEPT_IN_WORLD = 0, 1, 2
#: A kinematic number above is a convention of Euler angles, `FIRST_ANGLES` + 9 i + 3 j + k for
#: R = R_i(a) R_j(b) R_k(c), whose rates ω is taken for.
FIRST_ANGLES = 3


class OtherEquations(NamedTuple):
    """Numbers of equations of motion, SI; `torque` is in body axes unless its name says otherwise.

    I ω' = τ − ω × (G ω + h) and q' = ½ q (A ω), τ = l × Rᵀg + torque + Rᵀ torque_world
    − (c + (a + b ‖ω‖) I) ω − (a + b ‖ω‖) h, and what a table answers.

    Attributes
    ----------
    inertia, inverse, gyroscopic, turning : I, its inverse, G, A, (3, 3)
    kept : h, the momentum of parts, (3,)
    gravity_world, pull : g, and l, mass times the lever from a pivot, zero without one, (3,)
    torque, torque_world : (3,)
    slowing : c, a, b
    lever, mobility : from a table to the com, m, and 1/mass, which is 0 without a table
    in_world : whether I and G are along world axes
    kinematics : `BODY`, `WORLD`, `KEPT_IN_WORLD`, or of Euler angles
    rate : rad/s besides ‖ω‖, at which the state may change
    """

    inertia: FloatArray
    inverse: FloatArray
    gyroscopic: FloatArray
    turning: FloatArray
    kept: FloatArray
    gravity_world: FloatArray
    pull: FloatArray
    torque: FloatArray
    torque_world: FloatArray
    slowing: FloatArray
    lever: FloatArray
    mobility: float
    in_world: bool
    kinematics: int
    rate: float

    def with_inertia(self, inertia: FloatArray) -> "OtherEquations":
        """These equations for another tensor of inertia, kg m², (3, 3); nan if it is singular."""
        return self._replace(inertia=inertia, inverse=inverse(inertia), gyroscopic=inertia.copy())


def inverse(matrix: FloatArray) -> FloatArray:
    """The inverse of a matrix (3, 3); nan where it has none."""
    try:
        return np.asarray(np.linalg.inv(matrix), dtype=float)
    except np.linalg.LinAlgError:
        return np.full((3, 3), np.nan)


def equations_of(scenario: Scenario) -> OtherEquations:
    """Return the equations of a scene."""
    constraint, pushed = scenario.constraint, scenario.pushed
    inertia = np.array(scenario.inertia)
    is_on_table = scenario.answer is not None
    lever = np.array(constraint.lever)
    return OtherEquations(
        inertia,
        inverse(inertia),
        inertia.copy(),
        np.eye(3),
        np.array(scenario.kept_body(scenario.kept_at_start)),
        np.array(scenario.gravity_world),
        scenario.body.mass * lever if constraint.is_pivot else np.zeros(3),
        np.array(pushed["torque_body"], dtype=float),
        np.array(pushed["torque_world"], dtype=float),
        np.array([pushed["drag"], 0.0, 0.0], dtype=float),
        lever,
        1 / scenario.body.mass if is_on_table else 0.0,
        in_world=False,
        kinematics=BODY,
        rate=float(max((one.rate(scenario) for one in scenario.acting), default=0.0)),
    )
