"""What acts on a body in PyBullet: read back where its API reports it, measured where it does not.

PyBullet reports neither damping nor applied torques. So after a run one tiny step is taken without
gravity, from rest and once more from a slow spin: the gain of angular momentum in that step is the
torque that acts.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
import pybullet as p

from ....scenarios import FloatArray, Scenario
from ....scenarios.rotation import cross, matrix
from ...checks.read_back import BodyReading, State
from ...models.mjcf_contact import sphere_and_plane
from .model import Model
from .world import BASE, HUNG, World

#: s, timestep h of a probe. The torque, gain of L over h, has a rounding error of EPS L / h and a
#: truncation error proportional to h: their sum is least at h = √EPS.
PROBE_STEP = 2.0**-26
#: rad/s, and m/s of a free body's com; slow, so that gyroscopic terms stay below both errors.
PROBE_SPIN = 2.0**-7
#: rad/s, above the default clamp: the body keeps this speed only if the clamp is off.
PROBE_RUSH = 2.0**9
#: m; PyBullet's default, `gUrdfDefaultCollisionMargin` of its source.
EMPTY_MARGIN = 0.001
#: How many such errors add up, at most. PyBullet's default damping, 0.04 I ω, is a hundred thousand
#: times as large.
SLACK = 16 * PROBE_STEP


def what_acts(
    advance: Callable[[int], None], model: Model, scenario: Scenario, *, rests: bool = False
) -> frozenset[str]:
    """Names of the effects that act, and descriptions of anything else that does.

    Parameters
    ----------
    advance : takes whole steps, with the torques that belong to the scene
    rests : whether the body lies on a plane by contact

    The probes change the body's state, and switch PyBullet's defaults off.
    """
    world = model.world
    acting = {*_engine(world, scenario), *_holds(world)}
    acting |= _lifted_off(world, scenario) if rests else _extras(world)
    if np.isfinite(model.read_state().omega_body).all():
        acting |= _acting(_Probe.of(advance, model, scenario))
    return frozenset(acting)


def _engine(world: World, scenario: Scenario) -> set[str]:
    engine = p.getPhysicsEngineParameters(world.client)
    gravity = [engine[f"gravityAcceleration{axis}"] for axis in "XYZ"]
    acting = {"real-time stepping"} if engine["useRealTimeSimulation"] else set()
    if gravity != scenario.gravity_world.tolist():
        acting.add(f"a gravity of {gravity} m/s²")
    elif "gravity" in scenario.called_for:
        acting.add("gravity")
    return acting


def _holds(world: World) -> set[str]:
    """What holds the body, in words: its joints, and constraints of the world."""
    acting, client = set(), world.client
    for joint in range(p.getNumJoints(world.body, client)):
        kind = p.getJointInfo(world.body, joint, client)[2]
        if kind == p.JOINT_FIXED or joint in world.hinges:
            continue  # of a part of the body
        acting.add("pivot" if kind == p.JOINT_SPHERICAL else f"a joint of type {kind}")
    for index in range(p.getNumConstraints(client)):
        kind = p.getConstraintInfo(p.getConstraintUniqueId(index, client), client)[4]
        acting.add("pivot" if kind == p.JOINT_POINT2POINT else f"a constraint of type {kind}")
    return acting


def _others(world: World) -> list[int]:
    """The bodies besides the scene's."""
    bodies = [p.getBodyUniqueId(i, world.client) for i in range(p.getNumBodies(world.client))]
    return [body for body in bodies if body != world.body]


def _lifted_off(world: World, scenario: Scenario) -> set[str]:
    """What a body lies on, in words; that is taken away, so that nothing else pushes it."""
    acting, (_, height) = set(), sphere_and_plane(scenario)
    has_tip = _has_shape(world.client, world.body, BASE)
    for body in _others(world):
        shapes = p.getCollisionShapeData(body, BASE, world.client)
        place, _ = p.getBasePositionAndOrientation(body, world.client)
        is_plane = [shape[2] for shape in shapes] == [p.GEOM_PLANE] and place == (0, 0, height)
        acting.add("table" if is_plane and has_tip else "another body")
        p.removeBody(body, world.client)
    return acting


def _extras(world: World) -> set[str]:
    """The shapes that can collide, and other bodies that move, in words."""
    acting, others = set(), _others(world)
    if any(p.getDynamicsInfo(body, BASE, world.client)[0] for body in others):
        acting.add("another body")
    for body in (world.body, *others):
        links = range(BASE, p.getNumJoints(body, world.client))
        if any(_has_shape(world.client, body, link) for link in links):
            acting.add("a collision shape")
    return acting


def _has_shape(client: int, body: int, link: int) -> bool:
    """Whether the bounding box is larger than PyBullet's margin around an empty shape.

    (In maximal coordinates PyBullet does not report the shapes themselves; the margin of a sphere
    is its radius.)
    """
    margin = p.getDynamicsInfo(body, link, client)[11]
    low, high = p.getAABB(body, link, client)
    # A cube of half-width `EMPTY_MARGIN`, turned to reach furthest.
    furthest = 2 * np.sqrt(3) * EMPTY_MARGIN * (1 + SLACK)
    return bool(margin > EMPTY_MARGIN or max(np.subtract(high, low)) > furthest)


@dataclass(frozen=True, eq=False)
class _Probe:
    """A body that is set to a motion and takes one step, to measure what acts on it.

    Attributes
    ----------
    reading : the body as PyBullet holds it, already compared with the scene by the read-back
    push_world : N m, the scene's torques at the attitude of all probes, (3,)
    spin_world : rad/s, slow, (3,)
    """

    advance: Callable[[int], None]
    model: Model
    scenario: Scenario
    reading: BodyReading
    push_world: FloatArray
    spin_world: FloatArray

    @classmethod
    def of(cls, advance: Callable[[int], None], model: Model, scenario: Scenario) -> "_Probe":
        """Prepare for probing; switches gravity off."""
        world = model.world
        p.setGravity(0, 0, 0, physicsClientId=world.client)
        world.set_timestep(PROBE_STEP)
        if scenario.constraint.is_pivot and world.link == BASE:
            model.put_on_pivot()
        world.set_spins(np.full(len(scenario.rotors.each), PROBE_SPIN))
        R_world_body = model.R_world_body()
        push_world = R_world_body @ scenario.pushed["torque_body"] + scenario.pushed["torque_world"]
        spin_world = R_world_body @ np.full(3, PROBE_SPIN)
        return cls(advance, model, scenario, model.read_body(), push_world, spin_world)

    def after(self, omega_world: FloatArray) -> tuple[State, State]:
        """The states before and after a step from this ω.

        A free body also starts with a velocity: the same vector in m/s.
        """
        arm_world = self.model.R_world_body() @ self.model.com
        at_pivot = cross(omega_world, arm_world)
        is_held = self.scenario.constraint.is_pivot
        self.model.set_velocity(omega_world, at_pivot if is_held else omega_world)
        before = self.model.read_state()
        self.advance(1)
        return before, self.model.read_state()

    def gains(self, omega_world: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Momentum gained, N, and angular momentum, N m, a second of such a step; (3,) each."""
        before, after = self.after(omega_world)
        force = self.reading.mass * (after.velocity_world - before.velocity_world) / PROBE_STEP
        return force, (self._momentum(after) - self._momentum(before)) / PROBE_STEP

    def resistance(self) -> FloatArray:
        """The torque of the spinning body minus that at rest, N m, (3,)."""
        return self.gains(self.spin_world)[1] - self.gains(np.zeros(3))[1]

    def unlike(self) -> tuple[str, str, str]:
        """How torque, resistance and force differ from the scene's; empty if they do not.

        Gravity is off and so not part of the force; a body on a pivot has no force to compare.
        """
        torque, force, resistance = "", "", ""
        _, at_rest = self.gains(np.zeros(3))
        momentum, spinning = self.gains(self.spin_world)
        slow = _size(self.spin_world)
        if not _near(at_rest, self.push_world, self.noise):
            torque = f"a torque of {_size(at_rest)} N m at rest"
        dragged = -self.scenario.pushed["drag"] * self.spin_world
        if not _near(spinning - at_rest, dragged, self.noise):
            resistance = f"a resistance of {_size(spinning - at_rest)} N m at {slow} rad/s"
        faint = SLACK * PROBE_SPIN * self.reading.mass
        if not (self.scenario.constraint.is_pivot or _near(momentum, np.zeros(3), faint)):
            force = f"a force of {_size(momentum)} N at {slow} m/s"
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
        arm = float(np.linalg.norm(self.reading.com))
        moments = np.linalg.eigvalsh(self.reading.inertia_com)
        largest_moment = float(moments[-1]) + self.reading.mass * arm**2
        push = float(np.linalg.norm(self.push_world))
        # What a torque adds to ω in the step also turns the body, and with it L.
        dragged = float(self.scenario.pushed["drag"]) * PROBE_SPIN
        turned = (push + dragged) * largest_moment / float(moments[0])
        return SLACK * (PROBE_SPIN * (largest_moment + turned) + push)

    def _momentum(self, state: State) -> FloatArray:
        """L about the pivot, or the com where there is none, world axes, kg m²/s, (3,)."""
        # Normalised to the last digit, as differences are divided by a very short time.
        q_world_body = state.q_world_body_wxyz / np.linalg.norm(state.q_world_body_wxyz)
        R_world_body = matrix(q_world_body)
        turning = state.spins @ self.reading.axial
        L_world = R_world_body @ (self.reading.inertia_com @ state.omega_body + turning)
        if self.scenario.constraint.is_pivot:
            L_world += self.reading.mass * cross(state.com_world, state.velocity_world)
        return np.asarray(L_world)


def _acting(probe: _Probe) -> set[str]:
    """The names of effects that the momentum gained in a step shows: torques, drag, damping."""
    torque, resistance, force = probe.unlike()
    acting = {words for words in (torque, resistance, force) if words}
    if acting:
        acting |= _slowing_defaults(probe)
        # Of what the scene calls for, once nothing else acts.
        torque, resistance, _ = probe.unlike()
    if not torque:
        acting |= probe.scenario.called_for & {"torque_body", "torque_world"}
    if not resistance:
        acting |= probe.scenario.called_for & {"drag"}
    if probe.scenario.rotors:
        acting |= _wrong_hinges(probe) or {"rotors"}
    # Last, as so fast a step changes the attitude.
    return acting | ({"velocity clamp"} if _is_clamped(probe) else set())


def _wrong_hinges(probe: _Probe) -> set[str]:
    """What is wrong with the hinges; PyBullet's motors if it ends without them."""
    if not any(probe.wrong_hinges()):
        return set()
    probe.model.world.take_away_motors()
    return set(probe.wrong_hinges()) or {"joint motor"}


def _slowing_defaults(probe: _Probe) -> set[str]:
    """The defaults of PyBullet that act: those whose removal makes a difference."""
    world, acting = probe.model.world, set()
    slowing: dict[str, Callable[[], object]] = {"damping": world.take_away_damping}
    if world.link == HUNG:
        # First, as its torque would hide the damping.
        slowing = {"joint motor": partial(world.set_motor, 0), **slowing}
    for name, take_away in slowing.items():
        with_it = probe.resistance()
        take_away()
        if not _near(probe.resistance(), with_it, probe.noise):
            acting.add(name)
    return acting


def _is_clamped(probe: _Probe) -> bool:
    """Whether a fast body is slower a step later, though nothing slows it."""
    before, after = probe.after(probe.spin_world * (PROBE_RUSH / PROBE_SPIN))
    speed = float(np.linalg.norm(before.omega_body))
    return bool(np.linalg.norm(after.omega_body) < speed / 2)


def _near(got: FloatArray, wanted: FloatArray, noise: float) -> bool:
    return bool(np.abs(got - wanted).max() <= SLACK * np.abs(wanted).max() + noise)


def _size(vector: FloatArray) -> str:
    return f"{np.linalg.norm(vector):.3g}"
