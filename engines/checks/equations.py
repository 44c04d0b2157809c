"""A scene's equations of motion, with which the gains of an engine's states are compared.

Euler's about the pivot, or the com where there is none, and Newton's (Goldstein, Classical
Mechanics, eq. 5.39 and 1.23).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...scenarios import PUSHED, FloatArray, Scenario, push
from ...scenarios.effects import gravity, table
from ...scenarios.fastest_rate import fastest_rate
from ...scenarios.rotation import cross, matrix, rotation_vectors
from .read_back import State

#: rad, largest step of the classical Runge–Kutta rule that computes an exact gain.
FINE_TURN = 0.05


@dataclass(frozen=True, eq=False)
class Equations:
    """The right-hand sides for one scene; vectors (3,), SI.

    Attributes
    ----------
    gyroscopic : whether ω × I ω acts, I about the com; the part due to the com's motion round a
        pivot acts in any case
    """

    scenario: Scenario
    gyroscopic: bool = True

    @cached_property
    def inertia(self) -> FloatArray:
        """Tensor about the pivot, or the com without one, kg m², body axes, (3, 3)."""
        return self.scenario.inertia

    @cached_property
    def inverse(self) -> FloatArray:
        """Inverse of the tensor, (3, 3)."""
        return np.asarray(np.linalg.inv(self.inertia), dtype=float)

    @cached_property
    def arm(self) -> float:
        """m, from the body's origin to the com."""
        return float(np.linalg.norm(self.scenario.body.com))

    @cached_property
    def reach(self) -> float:
        """m, scale of the com's position: its arm, or the radius of gyration if that is zero."""
        body = self.scenario.body
        return self.arm or float(np.sqrt(body.principal_moments[-1] / body.mass))

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

    def torque_body(self, R_world_body: FloatArray, omega_body: FloatArray) -> FloatArray:
        """I dω/dt, N m."""
        inertia = self.inertia
        if not self.gyroscopic:
            inertia = inertia - self.scenario.body.inertia_com
        outer_body = self.outer_body(R_world_body, omega_body)
        torque_body = outer_body - cross(omega_body, inertia @ omega_body)
        if self.scenario.effects.table is None:
            return torque_body
        up_body = R_world_body[2]
        force = table.normal_force(self.scenario, up_body, omega_body, torque_body)
        return np.asarray(torque_body + force * table.arm_body(self.scenario, up_body))

    def after(self, state: State, span: float) -> State:
        """The state a time `span` later, s."""
        turn = span * max(self.rate, float(np.linalg.norm(state.omega_body)))
        steps = max(2, int(np.ceil(turn / FINE_TURN)))
        q, omega = (
            state.q_world_body_wxyz / np.linalg.norm(state.q_world_body_wxyz),
            state.omega_body,
        )
        for _ in range(steps):
            q, omega = self._step(q, omega, span / steps)
        gravity, constraint = self.scenario.gravity_world, self.scenario.constraint
        com = state.com_world + span * state.velocity_world + span**2 / 2 * gravity
        velocity = state.velocity_world + span * gravity
        if not constraint.is_free:
            R_world_body = matrix(q)
            com = constraint.com_world(R_world_body @ constraint.lever, com)
            swing_world = R_world_body @ cross(omega, constraint.lever)
            velocity = constraint.velocity_world(swing_world, velocity)
        return State(q, omega, com, velocity)

    def _step(self, q: FloatArray, omega: FloatArray, h: float) -> tuple[FloatArray, FloatArray]:
        y = np.concatenate([q, omega])
        first = self._rates(y)
        second = self._rates(y + h / 2 * first)
        third = self._rates(y + h / 2 * second)
        fourth = self._rates(y + h * third)
        y = y + h / 6 * (first + 2 * second + 2 * third + fourth)
        return y[:4] / np.linalg.norm(y[:4]), y[4:]

    def _rates(self, y: FloatArray) -> FloatArray:
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
        omega_rate = self.inverse @ self.torque_body(R_world_body, omega)
        return np.concatenate([np.array(q_rate) / 2, omega_rate])


@dataclass(frozen=True, eq=False)
class Gain:
    """The gain of a state per second in excess of the exact gain, and its scale.

    Attributes
    ----------
    before, after : the states, as read
    span : s, between them
    excess : (4, 3): of the attitude rad/s in body axes, of I ω N m in body axes; of a free body's
        velocity m/s² and position m/s, in world axes; of a body on a pivot how far velocity (m/s)
        and com (m) are from where ω and attitude put them
    wanted : the exact gain, (4, 3)
    """

    before: State
    after: State
    span: float
    excess: FloatArray
    wanted: FloatArray


def gain_between(equations: Equations, before: State, after: State, span: float) -> Gain:
    """Compare what a state gained within a span, s, with the exact gain."""
    exact = equations.after(before, span)
    turn = _turn(before, after) / span
    exact_turn = _turn(before, exact) / span
    torque = equations.inertia @ (after.omega_body - before.omega_body) / span
    exact_torque = equations.inertia @ (exact.omega_body - before.omega_body) / span
    if equations.scenario.constraint.is_pivot:
        R = matrix(after.q_world_body_wxyz)
        com = np.array(equations.scenario.body.com)
        got = np.array([turn, torque, after.velocity_world, after.com_world])
        wanted = [exact_turn, exact_torque, R @ cross(after.omega_body, com), R @ com]
    else:
        velocity = (after.velocity_world - before.velocity_world) / span
        position = (after.com_world - before.com_world) / span
        got = np.array([turn, torque, velocity, position])
        exact_position = (exact.com_world - before.com_world) / span
        fall = (exact.velocity_world - before.velocity_world) / span
        if equations.scenario.constraint.is_free:
            fall = equations.scenario.gravity_world
        wanted = [exact_turn, exact_torque, fall, exact_position]
    return Gain(before, after, span, got - np.array(wanted), np.array(wanted))


def gain_sizes(equations: Equations, gain: Gain) -> FloatArray:
    """Sizes of the terms that the gains are sums of, (4,)."""
    omega = gain.before.omega_body
    R = matrix(gain.before.q_world_body_wxyz)
    L = float(np.linalg.norm(equations.inertia @ omega))
    speed = float(np.linalg.norm(omega))
    still, pushed = (push(equations.scenario.pushed, R, R @ spin) for spin in (np.zeros(3), omega))
    outer = gravity.torque_body(equations.scenario, R), still, pushed - still
    torque = L * speed + sum(float(np.linalg.norm(one)) for one in outer)
    places = np.linalg.norm(gain.wanted[2:], axis=1)
    if equations.scenario.constraint.is_pivot:
        places = np.maximum(places, np.array([speed, 1.0]) * equations.reach)
    return np.array([speed, torque, *places])


def rounded(equations: Equations, gain: Gain, epsilon: float) -> FloatArray:
    """The change of a gain by one rounding of the states read, (4,)."""
    speed = float(np.linalg.norm(gain.before.omega_body)) + equations.rate
    fast = float(np.linalg.norm(gain.before.velocity_world)) + equations.reach * speed
    far = float(np.linalg.norm(gain.before.com_world)) + equations.reach
    largest = float(np.linalg.norm(equations.inertia, 2))
    sizes = np.array([1 / gain.span, largest * speed / gain.span, fast, far])
    if not equations.scenario.constraint.is_pivot:
        sizes[2:] /= gain.span
    return epsilon * sizes


def _turn(before: State, after: State) -> FloatArray:
    """Rotation vector from one attitude to the other, rad, body axes, (3,)."""
    first, second = before.q_world_body_wxyz[None], after.q_world_body_wxyz[None]
    return np.asarray(rotation_vectors(first, second)[0])
