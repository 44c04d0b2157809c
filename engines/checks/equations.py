"""The equations of motion of a scene: scales of its states, and where its constraint can hold."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...scenarios import FloatArray, Scenario
from ...scenarios.rotation import cross, matrices, turned
from .read_back import READ_BACK_SLACK, State


@dataclass(frozen=True, eq=False)
class Equations:
    """The coefficients of one scene's equations of motion, in SI units, and its constraint."""

    scenario: Scenario

    @cached_property
    def inverse(self) -> FloatArray:
        """Inverse of the tensor of inertia about the pivot, 1/(kg m²), body axes, (3, 3).

        It is about the com if the scene has no pivot.
        """
        return np.asarray(np.linalg.inv(self.scenario.inertia), dtype=float)

    @cached_property
    def arm(self) -> float:
        """Distance of the com from the constrained point, or from a free body's origin, m."""
        return float(np.linalg.norm(self.scenario.constraint.lever))

    @cached_property
    def reach(self) -> float:
        """Scale of the com's position, m: its arm, or the radius of gyration if the arm is zero.

        An arm that is within the tolerance of a body's read-back counts as zero.
        """
        body = self.scenario.body
        gyration = float(np.sqrt(body.principal_moments[-1] / body.mass))
        return self.arm if self.arm > READ_BACK_SLACK * gyration else gyration

    def kept_body(self, state: State) -> FloatArray:
        """The sum of the rotors' constant momenta about their axles, body axes, kg m²/s.

        It is of shape (3,) for one state, and (n, 3) for n states.
        """
        return self.scenario.kept_body(self.scenario.kept(state.omega_body, state.spins))

    def bears(self, states: State) -> NDArray[np.bool_]:
        """Whether the constraint can exert the force that it needs, in each of n states, (n,).

        A table, for example, can push the body but not pull it.
        """
        bears = np.ones(len(states.omega_body), dtype=bool)
        for force in filter(None, (one.force for one in self.scenario.acting)):
            at = matrices(states.q_world_body_wxyz), states.omega_body, self.kept_body(states)
            bears &= force(self.scenario, *at) > 0
        return bears

    def bearable(self, states: State, others: State) -> State:
        """Return n states, where each that the constraint cannot hold is replaced by another.

        Parameters
        ----------
        states : n states
        others : n states; the k-th replaces the k-th of `states` where `bears` is false
        """
        bears = self.bears(states)[:, None]
        pairs = zip(states.columns, others.columns, strict=True)
        return State(*(np.where(bears, column, other) for column, other in pairs))

    def on_constraint(self, states: State) -> State:
        """Return n states with com and velocity replaced by those that the constraint demands.

        Attitude and ω stay as they are.
        """
        constraint, R_world_body = self.scenario.constraint, matrices(states.q_world_body_wxyz)
        swing_world = turned(R_world_body, cross(states.omega_body, np.array(constraint.lever)))
        return replace(
            states,
            com_world=constraint.com_world(R_world_body @ constraint.lever, states.com_world),
            velocity_world=constraint.velocity_world(swing_world, states.velocity_world),
        )
