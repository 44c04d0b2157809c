"""A body in PyBullet that is set to a motion and takes a step, to measure what acts on it."""

from collections.abc import Callable

import numpy as np
import pybullet as p
from spincheck.engine import FloatArray, Scenario, State

from ....scenarios.effects.push import push
from ....scenarios.rotation import cross, matrix
from .model import Model

#: s, timestep h of a probe. The torque, gain of L over h, has a rounding error of EPS L / h and a
#: truncation error proportional to h: their sum is least at h = √EPS.
PROBE_STEP = 2.0**-26
#: rad/s, and m/s of a free body's com; slow, so that gyroscopic terms stay below both errors.
PROBE_SPIN = 2.0**-7
#: How many such errors add up, at most. PyBullet's default damping, 0.04 I ω, is a hundred thousand
#: times as large.
SLACK = 16 * PROBE_STEP


class Probe:
    """A body that is set to a motion and takes one step, to measure what acts on it.

    Gravity is switched off.

    Parameters
    ----------
    advance : takes whole steps, with the torques that belong to the scene

    Attributes
    ----------
    spin_world : rad/s, slow, (3,)
    """

    def __init__(self, advance: Callable[[int], None], model: Model, scenario: Scenario) -> None:
        self.model, self.scenario, self._advance = model, scenario, advance
        p.setGravity(0, 0, 0, physicsClientId=model.world.client)
        model.world.set_timestep(PROBE_STEP)
        model.world.set_spins(np.full(len(scenario.rotors.each), PROBE_SPIN))
        R_world_body = model.R_world_body()
        self.spin_world = R_world_body @ np.full(3, PROBE_SPIN)
        # N m, the scene's torques at rest, and what they change by at that spin.
        self._push_world = push(scenario.pushed, R_world_body, np.zeros(3))
        self._dragged_world = (
            push(scenario.pushed, R_world_body, self.spin_world) - self._push_world
        )
        # What holds the body, if not a contact: along which axes, and m from there to the com.
        is_held = scenario.constraint.is_pivot or model.world.link > 0
        self._is_held = np.array(scenario.constraint.is_held) & is_held
        self._lever_body = scenario.constraint.lever * is_held

    def after(self, omega_world: FloatArray) -> tuple[State, State]:
        """The states before and after a step from this ω.

        A body that is not on a pivot also starts with a velocity: the same vector in m/s.
        """
        now, R_world_body = self.model.read_state(), self.model.R_world_body()
        com_world, velocity_world = now.com_world, omega_world
        if self._is_held.all():
            com_world = R_world_body @ self.model.body.com
            velocity_world = cross(omega_world, com_world)
        omega_body = R_world_body.T @ omega_world
        set_to = State(now.q_world_body_wxyz, omega_body, com_world, velocity_world)
        self.model.place(self.model.placed(set_to), com_world, velocity_world)
        before = self.model.read_state()
        self._advance(1)
        return before, self.model.read_state()

    def gains(self, omega_world: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Momentum gained, N, and angular momentum, N m, a second of such a step; (3,) each.

        A point that holds the body may slide, at v: the angular momentum about it changes by
        −m v × v_com besides, since the force there passes through it.
        """
        before, after = self.after(omega_world)
        mass, velocity_world = self.model.body.mass, before.velocity_world
        force = mass * (after.velocity_world - velocity_world) / PROBE_STEP
        gain = (self._momentum(after) - self._momentum(before)) / PROBE_STEP
        swing_world = _attitude(before) @ cross(before.omega_body, self._lever_body)
        return force, gain + mass * cross(velocity_world - swing_world, velocity_world)

    def _momentum(self, state: State) -> FloatArray:
        """L about what holds the body, or else the com, world axes, kg m²/s, (3,)."""
        body, R_world_body = self.model.body, _attitude(state)
        L_body = body.inertia_com @ state.omega_body + state.spins @ body.axial
        about_world = cross(R_world_body @ self._lever_body, state.velocity_world)
        return np.asarray(R_world_body @ L_body + body.mass * about_world)

    def resistance(self) -> FloatArray:
        """The torque of the spinning body minus that at rest, N m, (3,)."""
        return self.gains(self.spin_world)[1] - self.gains(np.zeros(3))[1]

    def unlike(self) -> tuple[str, str, str]:
        """How torque, resistance and force differ from the scene's; empty if they do not.

        Gravity is off and so not part of the force; along axes on which a joint holds the body
        there is no force to compare.
        """
        torque, force, resistance = "", "", ""
        _, at_rest = self.gains(np.zeros(3))
        momentum, spinning = self.gains(self.spin_world)
        slow, momentum = size(self.spin_world), np.where(self._is_held, 0.0, momentum)
        if not near(at_rest, self._push_world, self.noise):
            torque = f"a torque of {size(at_rest)} N m at rest"
        if not near(spinning - at_rest, self._dragged_world, self.noise):
            resistance = f"a resistance of {size(spinning - at_rest)} N m at {slow} rad/s"
        if not near(momentum, np.zeros(3), SLACK * PROBE_SPIN * self.model.body.mass):
            force = f"a force of {size(momentum)} N at {slow} m/s"
        return torque, resistance, force

    def wrong_hinges(self) -> list[str]:
        """The hinges that do not keep what they should, from a slow spin, in words."""
        rotors = self.scenario.rotors
        self.model.world.set_spins(np.full(len(rotors.each), PROBE_SPIN))
        before, after = self.after(self.spin_world)
        kept = [rotors.kept(state.omega_body, state.spins) for state in (before, after)]
        return [
            f"a torque of {abs(torque):.3g} N m on the hinge of rotor {number}"
            for number, torque in enumerate((kept[1] - kept[0]) / PROBE_STEP, start=1)
            if not abs(torque) <= self.noise
        ]

    @property
    def noise(self) -> float:
        """Noise of the measured torque, N m."""
        body, arm = self.model.body, float(np.linalg.norm(self.scenario.constraint.lever))
        moments = np.linalg.eigvalsh(body.inertia_com)
        largest_moment = float(moments[-1]) + body.mass * arm**2
        if self.model.world.link > 0:
            # A com that flies at 1 m/s a rad/s has an angular momentum about the joint.
            largest_moment += body.mass * arm
        pushed = float(np.linalg.norm(self._push_world))
        # What a torque adds to ω in the step also turns the body, and with it L.
        dragged = float(np.linalg.norm(self._dragged_world))
        turned = (pushed + dragged) * largest_moment / float(moments[0])
        return SLACK * (PROBE_SPIN * (largest_moment + turned) + pushed)


def _attitude(state: State) -> FloatArray:
    """The attitude, (3, 3), to the last digit, as differences are divided by a very short time."""
    q_wxyz = state.q_world_body_wxyz
    return matrix(q_wxyz / np.linalg.norm(q_wxyz))


def near(got: FloatArray, wanted: FloatArray, noise: float) -> bool:
    """Whether a vector is another but for rounding and noise."""
    return bool(np.abs(got - wanted).max() <= SLACK * np.abs(wanted).max() + noise)


def size(vector: FloatArray) -> str:
    """The length of a vector, in words."""
    return f"{np.linalg.norm(vector):.3g}"
