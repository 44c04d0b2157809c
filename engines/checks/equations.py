"""A scene's equations of motion, with which the gains of an engine's states are compared.

Euler's about the pivot, or the com where there is none, and Newton's (Goldstein, Classical
Mechanics, eq. 5.39 and 1.23).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...scenarios import PUSHED, FloatArray, Scenario, push
from ...scenarios.effects import gravity
from ...scenarios.rotation import cross, matrices
from .read_back import READ_BACK_SLACK, State


@dataclass(frozen=True, eq=False)
class Equations:
    """The right-hand sides for one scene; vectors (3,), SI."""

    scenario: Scenario

    @cached_property
    def inertia(self) -> FloatArray:
        """Tensor of inertia by which ω' is multiplied, as `Scenario.inertia`, kg m², (3, 3)."""
        return self.scenario.inertia

    @cached_property
    def inverse(self) -> FloatArray:
        """Inverse of the tensor, (3, 3)."""
        return np.asarray(np.linalg.inv(self.inertia), dtype=float)

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

    def outer_body(self, R_world_body: FloatArray, omega_body: FloatArray) -> FloatArray:
        """Torque of the scene's effects, N m."""
        pulled = gravity.torque_body(self.scenario, R_world_body)
        if not self.scenario.called_for & PUSHED:
            return pulled
        pushed: FloatArray = push(self.scenario.pushed, R_world_body, R_world_body @ omega_body)
        return pulled + pushed @ R_world_body

    def torque_body(
        self, R_world_body: FloatArray, omega_body: FloatArray, kept_body: FloatArray
    ) -> FloatArray:
        """I dω/dt, N m, given the angular momentum that parts keep, kg m²/s."""
        gyroscopic = cross(omega_body, self.inertia @ omega_body + kept_body)
        torque_body = self.outer_body(R_world_body, omega_body) - gyroscopic
        if self.scenario.answer is None:
            return torque_body
        acting = R_world_body[2], omega_body, torque_body, self.scenario.gravity_world
        return self.scenario.answer(self.scenario, *acting)[0]

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
