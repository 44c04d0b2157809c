"""What a scene's equations of motion say of states: their sizes, and where the body can be held."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...scenarios import FloatArray, Scenario
from ...scenarios.rotation import cross, matrices, turned
from .read_back import READ_BACK_SLACK, State


@dataclass(frozen=True, eq=False)
class Equations:
    """The coefficients of one scene's equations of motion, SI, and what holds its body."""

    scenario: Scenario

    @cached_property
    def inverse(self) -> FloatArray:
        """Inverse of the tensor of inertia by which ω' is multiplied, (3, 3)."""
        return np.asarray(np.linalg.inv(self.scenario.inertia), dtype=float)

    @cached_property
    def arm(self) -> float:
        """Distance of the com from the point that is held, or from a free body's origin, m."""
        return float(np.linalg.norm(self.scenario.constraint.lever))

    @cached_property
    def reach(self) -> float:
        """Scale of the com's position, m: its arm, or the radius of gyration if it has none.

        An arm of less than what a body may differ by when it is read back is none.
        """
        body = self.scenario.body
        gyration = float(np.sqrt(body.principal_moments[-1] / body.mass))
        return self.arm if self.arm > READ_BACK_SLACK * gyration else gyration

    def kept_body(self, state: State) -> FloatArray:
        """The angular momentum that parts keep, kg m²/s, (3,) or (n, 3)."""
        return self.scenario.kept_body(self.scenario.kept(state.omega_body, state.spins))

    def bears(self, states: State) -> NDArray[np.bool_]:
        """Whether what holds the body can hold it at each of n states: some cannot pull."""
        bears = np.ones(len(states.omega_body), dtype=bool)
        for force in filter(None, (one.force for one in self.scenario.acting)):
            at = matrices(states.q_world_body_wxyz), states.omega_body, self.kept_body(states)
            bears &= force(self.scenario, *at) > 0
        return bears

    def bearable(self, states: State, others: State) -> State:
        """Each of n states, or the other one where what holds the body cannot hold it there."""
        bears = self.bears(states)[:, None]
        pairs = zip(states.columns, others.columns, strict=True)
        return State(*(np.where(bears, column, other) for column, other in pairs))

    def on_constraint(self, states: State) -> State:
        """States, n of them, with com and velocity where attitude and ω put them if it is held."""
        constraint, R_world_body = self.scenario.constraint, matrices(states.q_world_body_wxyz)
        swing_world = turned(R_world_body, cross(states.omega_body, np.array(constraint.lever)))
        return replace(
            states,
            com_world=constraint.com_world(R_world_body @ constraint.lever, states.com_world),
            velocity_world=constraint.velocity_world(swing_world, states.velocity_world),
        )
