"""The equations of motion of a scene: their scales, and the states that its constraint allows."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...scenarios import FloatArray, Scenario
from ...scenarios.rotation import cross, matrices, turned
from .read_back import READ_BACK_SLACK, State


@dataclass(frozen=True, eq=False)
class Equations:
    """Scales of the equations of motion of one scene, and the states that its constraint allows."""

    scenario: Scenario

    @cached_property
    def inverse(self) -> FloatArray:
        """The inverse of the tensor of inertia, 1/(kg m²), body axes, (3, 3).

        The tensor is that about the pivot, or about the com if the scene has no pivot.
        """
        return np.asarray(np.linalg.inv(self.scenario.inertia), dtype=float)

    @cached_property
    def arm(self) -> float:
        """The distance of the com from the constrained point, or from a free body's origin, m."""
        return float(np.linalg.norm(self.scenario.constraint.lever))

    @cached_property
    def reach(self) -> float:
        """The scale of the com's position, m: `arm`, or the radius of gyration if the arm is zero.

        An arm within the tolerance of the read-back counts as zero.
        """
        body = self.scenario.body
        gyration = float(np.sqrt(body.principal_moments[-1] / body.mass))
        return self.arm if self.arm > READ_BACK_SLACK * gyration else gyration

    def kept_body(self, state: State) -> FloatArray:
        """Return the vector sum of the angular momenta that the rotors keep, kg m²/s, body axes.

        Each rotor keeps its momentum about its axle. The sum is (3,) for one state, and (n, 3) for
        n states.
        """
        return self.scenario.kept_body(self.scenario.kept(state.omega_body, state.spins))

    def bears(self, states: State) -> NDArray[np.bool_]:
        """Return whether the constraint can exert the force that each of n states needs, (n,).

        A table, for example, can push the body but not pull it.
        """
        bears = np.ones(len(states.omega_body), dtype=bool)
        for force in filter(None, (one.force for one in self.scenario.acting)):
            at = matrices(states.q_world_body_wxyz), states.omega_body, self.kept_body(states)
            bears &= force(self.scenario, *at) > 0
        return bears

    def bearable(self, states: State, others: State) -> State:
        """Return n states, with those replaced whose force the constraint cannot exert.

        Parameters
        ----------
        states : n states, returned as they are where `bears` is true
        others : n states; the k-th replaces the k-th of `states` where `bears` is false
        """
        bears = self.bears(states)[:, None]
        pairs = zip(states.columns, others.columns, strict=True)
        return State(*(np.where(bears, column, other) for column, other in pairs))

    def on_constraint(self, states: State) -> State:
        """Return n states moved onto the constraint: with the com and the velocity that it demands.

        Attitude and ω stay as they are; so do com and velocity along axes that are not held.
        """
        constraint, R_world_body = self.scenario.constraint, matrices(states.q_world_body_wxyz)
        swing_world = turned(R_world_body, cross(states.omega_body, np.array(constraint.lever)))
        return replace(
            states,
            com_world=constraint.com_world(R_world_body @ constraint.lever, states.com_world),
            velocity_world=constraint.velocity_world(swing_world, states.velocity_world),
        )
