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
from ...scenarios.fastest_rate import fastest_rate
from ...scenarios.rotation import cross, matrices, matrix, rotation_vectors
from .read_back import State, stacked

#: rad, largest step of the classical Runge–Kutta rule that computes an exact gain.
FINE_TURN = 0.05
#: Radii of gyration; no engine places a body in double precision to less.
NO_ARM = 1e-12


@dataclass(frozen=True, eq=False)
class Equations:
    """The right-hand sides for one scene; vectors (3,), SI."""

    scenario: Scenario

    @cached_property
    def inertia(self) -> FloatArray:
        """As `Scenario.inertia`."""
        return self.scenario.inertia

    @cached_property
    def inverse(self) -> FloatArray:
        """Inverse of the tensor, (3, 3)."""
        return np.asarray(np.linalg.inv(self.inertia), dtype=float)

    @cached_property
    def arm(self) -> float:
        """m, from the point that is held, or of a free body its origin, to the com."""
        return float(np.linalg.norm(self.scenario.constraint.lever))

    @cached_property
    def reach(self) -> float:
        """m, scale of the com's position: its arm, or the radius of gyration if it has none."""
        body = self.scenario.body
        gyration = float(np.sqrt(body.principal_moments[-1] / body.mass))
        return self.arm if self.arm > NO_ARM * gyration else gyration

    @cached_property
    def rate(self) -> float:
        """The fastest rate at the start, 1/s: of rotation, or of an effect."""
        scenario, omega_body = self.scenario, self.scenario.start.omega_body
        moments = np.linalg.eigvalsh(self.inertia)
        pushed = float(np.linalg.norm(push(scenario.pushed, np.eye(3), np.zeros(3))))
        return max(
            float(np.linalg.norm(omega_body)) * float(moments[-1] / moments[0]),
            fastest_rate(scenario, omega_body),
            float(np.sqrt(pushed / moments[0])),
            1 / scenario.window.duration,
        )

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

    def after(self, state: State, span: float) -> State:
        """The state a time `span` later, s."""
        turn = abs(span) * max(self.rate, float(np.linalg.norm(state.omega_body)))
        steps = max(2, int(np.ceil(turn / FINE_TURN)))
        q, omega = (
            state.q_world_body_wxyz / np.linalg.norm(state.q_world_body_wxyz),
            state.omega_body,
        )
        kept = self.kept_body(state)
        for _ in range(steps):
            q, omega = self._step(q, omega, kept, span / steps)
        gravity, constraint = self.scenario.gravity_world, self.scenario.constraint
        com = state.com_world + span * state.velocity_world + span**2 / 2 * gravity
        R_world_body = matrix(q)
        swing_world = R_world_body @ cross(omega, constraint.lever)
        return State(
            q,
            omega,
            constraint.com_world(R_world_body @ constraint.lever, com),
            constraint.velocity_world(swing_world, state.velocity_world + span * gravity),
            self.scenario.spins(omega, self.scenario.kept(state.omega_body, state.spins)),
        )

    def after_each(self, states: State, spans: FloatArray) -> State:
        """The states a time later of each of n states, s, (n,)."""
        return stacked([self.after(states.rows(k), span) for k, span in enumerate(spans)])

    def _step(
        self, q: FloatArray, omega: FloatArray, kept: FloatArray, h: float
    ) -> tuple[FloatArray, FloatArray]:
        y = np.concatenate([q, omega])
        first = self._rates(y, kept)
        second = self._rates(y + h / 2 * first, kept)
        third = self._rates(y + h / 2 * second, kept)
        fourth = self._rates(y + h * third, kept)
        y = y + h / 6 * (first + 2 * second + 2 * third + fourth)
        return y[:4] / np.linalg.norm(y[:4]), y[4:]

    def _rates(self, y: FloatArray, kept: FloatArray) -> FloatArray:
        w, x, y_, z = y[:4]
        omega = y[4:]
        a, b, c = omega
        q_rate = [
            -x * a - y_ * b - z * c,
            w * a + y_ * c - z * b,
            w * b + z * a - x * c,
            w * c + x * b - y_ * a,
        ]
        R_world_body = matrix(y[:4])
        omega_rate = self.inverse @ self.torque_body(R_world_body, omega, kept)
        return np.concatenate([np.array(q_rate) / 2, omega_rate])


@dataclass(frozen=True, eq=False)
class Gain:
    """The gain of a state per second in excess of the exact gain, and its scale.

    Attributes
    ----------
    before : the state
    span : s, of the gain
    excess : (4, 3): of the attitude rad/s in body axes, of I ω N m in body axes; of a free body's
        velocity m/s² and position m/s, in world axes; of a body on a pivot how far velocity (m/s)
        and com (m) are from where ω and attitude put them
    wanted : the exact gain, (4, 3)
    """

    before: State
    span: float
    excess: FloatArray
    wanted: FloatArray


def gains_of(
    equations: Equations, before: State, exact: State, spans: FloatArray, excess: FloatArray
) -> list[Gain]:
    """The exact gains of the last K of n states, beside what is gained in excess, (K, 4, 3).

    Parameters
    ----------
    exact : the states a time `spans` later, s, (n,)
    """
    gains: list[Gain] = []
    turns = rotation_vectors(before.q_world_body_wxyz, exact.q_world_body_wxyz)
    for k, beyond in enumerate(excess, len(spans) - len(excess)):
        start, end, span = before.rows(k), exact.rows(k), float(spans[k])
        torque = equations.inertia @ (end.omega_body - start.omega_body) / span
        if equations.scenario.constraint.is_pivot:
            R, com = matrix(end.q_world_body_wxyz), np.array(equations.scenario.body.com)
            velocity, place = R @ cross(end.omega_body, com), R @ com
        else:
            velocity = equations.scenario.gravity_world
            if not equations.scenario.constraint.is_free:
                velocity = (end.velocity_world - start.velocity_world) / span
            place = (end.com_world - start.com_world) / span
        wanted = np.array([turns[k] / span, torque, velocity, place])
        gains.append(Gain(start, span, beyond, wanted))
    return gains
