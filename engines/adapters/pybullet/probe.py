"""A body in PyBullet that is set to a motion and takes a step, to measure what acts on it."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import pybullet as p
from spincheck.engine import BodyReading, FloatArray, Scenario, State

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


@dataclass(frozen=True, eq=False)
class Probe:
    """A body that is set to a motion and takes one step, to measure what acts on it.

    Attributes
    ----------
    reading : the body as PyBullet holds it, already compared with the scene by the read-back
    push_world : N m, the scene's torques at the attitude of all probes, (3,)
    spin_world : rad/s, slow, (3,)
    dragged_world : N m, what the scene's torques change by at that spin, (3,)
    """

    advance: Callable[[int], None]
    model: Model
    scenario: Scenario
    reading: BodyReading
    push_world: FloatArray
    spin_world: FloatArray
    dragged_world: FloatArray

    @classmethod
    def of(cls, advance: Callable[[int], None], model: Model, scenario: Scenario) -> "Probe":
        """Prepare for probing; switches gravity off."""
        world = model.world
        p.setGravity(0, 0, 0, physicsClientId=world.client)
        world.set_timestep(PROBE_STEP)
        world.set_spins(np.full(len(scenario.rotors.each), PROBE_SPIN))
        R_world_body = model.R_world_body()
        spin_world = R_world_body @ np.full(3, PROBE_SPIN)
        push_world = push(scenario.pushed, R_world_body, np.zeros(3))
        dragged = push(scenario.pushed, R_world_body, spin_world) - push_world
        return cls(advance, model, scenario, model.body, push_world, spin_world, dragged)

    def after(self, omega_world: FloatArray) -> tuple[State, State]:
        """The states before and after a step from this ω.

        A free body also starts with a velocity: the same vector in m/s.
        """
        now = self.model.read_state()
        R_world_body = matrix(_unit(now.q_world_body_wxyz))
        omega_body, com_world, velocity_world = (
            R_world_body.T @ omega_world,
            now.com_world,
            omega_world,
        )
        if self.scenario.constraint.is_pivot:
            com_world = R_world_body @ self.model.body.com
            velocity_world = cross(omega_world, com_world)
        set_to = State(now.q_world_body_wxyz, omega_body, com_world, velocity_world)
        self.model.place(self.model.placed(set_to), com_world, velocity_world)
        before = self.model.read_state()
        self.advance(1)
        return before, self.model.read_state()

    def gains(self, omega_world: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Momentum gained, N, and angular momentum, N m, a second of such a step; (3,) each.

        A body that slides on a joint turns about that, which moves at v: its angular momentum there
        changes by −m v × v_com besides, since its own force passes through it.
        """
        before, after = self.after(omega_world)
        mass, velocity_world = self.reading.mass, before.velocity_world
        force = mass * (after.velocity_world - velocity_world) / PROBE_STEP
        gain = (self._momentum(after) - self._momentum(before)) / PROBE_STEP
        if self._slides:
            swing_world = cross(self._omega_world(before), self._lever_world(before))
            gain += mass * cross(velocity_world - swing_world, velocity_world)
        return force, gain

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
        slow = size(self.spin_world)
        if not near(at_rest, self.push_world, self.noise):
            torque = f"a torque of {size(at_rest)} N m at rest"
        if not near(spinning - at_rest, self.dragged_world, self.noise):
            resistance = f"a resistance of {size(spinning - at_rest)} N m at {slow} rad/s"
        faint = SLACK * PROBE_SPIN * self.reading.mass
        if self._slides:
            momentum = np.where(self.scenario.constraint.is_held, 0.0, momentum)
        if not (self.scenario.constraint.is_pivot or near(momentum, np.zeros(3), faint)):
            force = f"a force of {size(momentum)} N at {slow} m/s"
        return torque, resistance, force

    def wrong_hinges(self) -> Iterator[str]:
        """The hinges that do not keep what they should, from a slow spin, in words."""
        rotors = self.scenario.rotors
        self.model.world.set_spins(np.full(len(rotors.each), PROBE_SPIN))
        before, after = self.after(self.spin_world)
        kept = [rotors.kept(state.omega_body, state.spins) for state in (before, after)]
        for number, torque in enumerate((kept[1] - kept[0]) / PROBE_STEP, start=1):
            if not abs(torque) <= self.noise:
                yield f"a torque of {abs(torque):.3g} N m on the hinge of rotor {number}"

    @property
    def noise(self) -> float:
        """Noise of the measured torque, N m."""
        arm = float(np.linalg.norm(self.scenario.constraint.lever))
        moments = np.linalg.eigvalsh(self.reading.inertia_com)
        largest_moment = float(moments[-1]) + self.reading.mass * arm**2
        if self._slides:
            # A com that flies at 1 m/s a rad/s has an angular momentum about the joint.
            largest_moment += self.reading.mass * arm
        pushed = float(np.linalg.norm(self.push_world))
        # What a torque adds to ω in the step also turns the body, and with it L.
        dragged = float(np.linalg.norm(self.dragged_world))
        turned = (pushed + dragged) * largest_moment / float(moments[0])
        return SLACK * (PROBE_SPIN * (largest_moment + turned) + pushed)

    @property
    def _slides(self) -> bool:
        """Whether the body is on a joint that slides."""
        return self.model.world.link > 0

    def _lever_world(self, state: State) -> FloatArray:
        return matrix(_unit(state.q_world_body_wxyz)) @ self.scenario.constraint.lever

    def _omega_world(self, state: State) -> FloatArray:
        return matrix(_unit(state.q_world_body_wxyz)) @ state.omega_body

    def _momentum(self, state: State) -> FloatArray:
        """L about what a joint holds, or else the com, world axes, kg m²/s, (3,)."""
        R_world_body = matrix(_unit(state.q_world_body_wxyz))
        turning = state.spins @ self.reading.axial
        L_world = R_world_body @ (self.reading.inertia_com @ state.omega_body + turning)
        if self.scenario.constraint.is_pivot:
            L_world += self.reading.mass * cross(state.com_world, state.velocity_world)
        elif self._slides:
            lever_world = self._lever_world(state)
            L_world += self.reading.mass * cross(lever_world, state.velocity_world)
        return np.asarray(L_world)


def near(got: FloatArray, wanted: FloatArray, noise: float) -> bool:
    """Whether a vector is another but for rounding and noise."""
    return bool(np.abs(got - wanted).max() <= SLACK * np.abs(wanted).max() + noise)


def _unit(q_wxyz: FloatArray) -> FloatArray:
    """Normalised to the last digit, as differences are divided by a very short time."""
    return q_wxyz / np.linalg.norm(q_wxyz)


def size(vector: FloatArray) -> str:
    """The length of a vector, in words."""
    return f"{np.linalg.norm(vector):.3g}"
