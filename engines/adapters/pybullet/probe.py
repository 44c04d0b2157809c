"""Measures what acts on a body in PyBullet: it is set to a motion and takes a step."""

from collections.abc import Callable

import numpy as np
import pybullet as p
from spincheck.engine import FloatArray, Scenario, State

from ....scenarios.effects.push import push
from ....scenarios.rotation import cross
from .model import Model, attitude

#: Timestep h of a probe, s. The measured torque, ΔL / h, has a rounding error of ε L / h, where ε
#: is the machine epsilon, and a truncation error proportional to h. Their sum is least at h = √ε.
PROBE_STEP = 2.0**-26
#: Spin in a probe, rad/s, and speed of a free body's com, m/s. It is so slow that gyroscopic terms
#: are smaller than these errors.
PROBE_SPIN = 2.0**-7
#: Relative tolerance of a measured torque: 16 errors of `PROBE_STEP` each may add up. The torque of
#: PyBullet's default damping, 0.04 I ω, is a hundred thousand times as large.
SLACK = 16 * PROBE_STEP


class Probe:
    """Measurements on a body that is set to a motion and takes one step.

    Making a probe switches off gravity, and gives the rotors a slow spin.

    Parameters
    ----------
    advance : takes a given number of steps, in which the scene's torques are applied
    model : the body in its world

    Attributes
    ----------
    spin_world : the slow angular velocity from which steps are taken, rad/s, world axes, (3,)
    """

    def __init__(self, advance: Callable[[int], None], model: Model, scenario: Scenario) -> None:
        self.model, self.scenario, self._advance = model, scenario, advance
        p.setGravity(0, 0, 0, physicsClientId=model.world.client)
        model.world.set_spins(np.full(len(scenario.rotors.each), PROBE_SPIN))
        R_world_body = attitude(model.read_state())
        self.spin_world = R_world_body @ np.full(3, PROBE_SPIN)
        # The scene's torque on the body at rest, N m, and the change of the torque by that spin.
        self._push_world = push(scenario.pushed, R_world_body, np.zeros(3))
        self._dragged_world = (
            push(scenario.pushed, R_world_body, self.spin_world) - self._push_world
        )
        # For each axis of the world, whether a joint or constraint, but not a contact, holds the
        # body along it; and the vector from the held point to the com, m, body axes.
        is_held = scenario.constraint.is_pivot or model.world.link > 0
        self._is_held = np.array(scenario.constraint.is_held) & is_held
        self._lever_body = scenario.constraint.lever * is_held

    def after(self, omega_world: FloatArray) -> tuple[State, State]:
        """Return the states before and after a step that starts with a given ω.

        A body that is not on a pivot starts with the same vector, in m/s, as its velocity.

        Parameters
        ----------
        omega_world : ω, rad/s, world axes, (3,)
        """
        now = self.model.read_state()
        R_world_body = attitude(now)
        com_world, velocity_world = now.com_world, omega_world
        if self._is_held.all():
            com_world = R_world_body @ self.model.body.com
            velocity_world = cross(omega_world, com_world)
        omega_body = R_world_body.T @ omega_world
        set_to = State(now.q_world_body_wxyz, omega_body, com_world, velocity_world)
        self.model.world.restart(self.model.motion(set_to), PROBE_STEP)
        before = self.model.read_state()
        self._advance(1)
        return before, self.model.read_state()

    def gains(self, omega_world: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the rates at which momentum, N, and angular momentum, N m, change in a step.

        Both are in world axes, (3,). The step starts with an angular velocity of `omega_world`,
        rad/s. The angular momentum is about the held point. If this point slides at v, a rate of
        −m v × v_com comes from its motion and not from a torque, and is not included.
        """
        before, after = self.after(omega_world)
        mass, velocity_world = self.model.body.mass, before.velocity_world
        force = mass * (after.velocity_world - velocity_world) / PROBE_STEP
        gain = (self._momentum(after) - self._momentum(before)) / PROBE_STEP
        swing_world = attitude(before) @ cross(before.omega_body, self._lever_body)
        return force, gain + mass * cross(velocity_world - swing_world, velocity_world)

    def _momentum(self, state: State) -> FloatArray:
        """Return the angular momentum about the held point, kg m²/s, world axes, (3,).

        It is about the com if no point is held by a joint or constraint.
        """
        # `attitude` normalises quaternions: rounding of momenta is divided by a short time.
        body, R_world_body = self.model.body, attitude(state)
        L_body = body.inertia_com @ state.omega_body + state.spins @ body.axial
        about_world = cross(R_world_body @ self._lever_body, state.velocity_world)
        return np.asarray(R_world_body @ L_body + body.mass * about_world)

    def resistance(self) -> FloatArray:
        """Return the torque on the spinning body minus that at rest, N m, world axes, (3,).

        The body spins slowly, at `spin_world`.
        """
        return self.gains(self.spin_world)[1] - self.gains(np.zeros(3))[1]

    def unlike(self) -> tuple[str, str, str]:
        """Return what acts on the body in PyBullet unlike in the scene, in words; empty if alike.

        The first text is on the torque at rest, the second on the resistance, which is the change
        of the torque by a slow spin, and the third on the force on the com. Gravity is off, so that
        the force should be zero; it is not compared along axes along which a joint holds the body.
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
        """Return a description of each rotor's hinge that exerts a torque about its axis.

        On such a hinge the angular momentum that the scene's hinge would keep (`Rotors.kept`)
        changes in a step.
        """
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
        """A bound on the rounding and truncation errors of a measured torque, N m."""
        body, arm = self.model.body, float(np.linalg.norm(self.scenario.constraint.lever))
        moments = np.linalg.eigvalsh(body.inertia_com)
        largest_moment = float(moments[-1]) + body.mass * arm**2
        if self.model.world.link > 0:
            # A body on slides has a velocity of 1 m/s for each rad/s, and so more angular momentum
            # about the joint.
            largest_moment += body.mass * arm
        pushed = float(np.linalg.norm(self._push_world))
        # A torque changes ω during the step; this also turns the body, and with it L.
        dragged = float(np.linalg.norm(self._dragged_world))
        turned = (pushed + dragged) * largest_moment / float(moments[0])
        return SLACK * (PROBE_SPIN * (largest_moment + turned) + pushed)


def near(got: FloatArray, wanted: FloatArray, noise: float) -> bool:
    """Whether each component of `got` is that of `wanted`, within a tolerance.

    The tolerance is `SLACK` times the largest component of `wanted`, plus `noise`.
    """
    return bool(np.abs(got - wanted).max() <= SLACK * np.abs(wanted).max() + noise)


def size(vector: FloatArray) -> str:
    """Return the length of a vector as text, to three digits."""
    return f"{np.linalg.norm(vector):.3g}"
