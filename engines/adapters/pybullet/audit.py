"""What acts on a body in PyBullet, read back from its API, or measured if the API does not tell.

PyBullet reports neither damping nor applied torques. So after a run two tiny steps are taken
without gravity, one from rest and one from a slow spin: the angular momentum gained in a step,
divided by the timestep, is the torque that acts.
"""

from collections.abc import Callable
from functools import partial

import numpy as np
import pybullet as p
from spincheck.engine import Scenario

from ...models.mjcf_contact import sphere_and_plane
from .model import Model
from .probe import PROBE_SPIN, SLACK, Probe, near
from .world import BASE, World

#: Spin, rad/s, from which the body takes a step to find out whether PyBullet clamps velocities. It
#: is above the default clamp: the body keeps it only if the clamp is off.
PROBE_RUSH = 2.0**9
#: The effect that a spherical joint implements, by the number of slides that the joint is on.
HELD_BY = {0: "pivot", 2: "table"}
#: PyBullet's default margin around a shape, m: `gUrdfDefaultCollisionMargin` of its source.
EMPTY_MARGIN = 0.001


def what_acts(advance: Callable[[int], None], model: Model, scenario: Scenario) -> frozenset[str]:
    """Return names of the effects that act, and descriptions of anything else that acts.

    The measurements change the body's state, switch off gravity and some of PyBullet's defaults,
    and remove the plane under a body on a contact. Torques are not measured if ω is not finite.

    Parameters
    ----------
    advance : takes a given number of steps, in which the scene's torques are applied
    model : the body in its world
    """
    world = model.world
    acting = _engine(world, scenario) | _holds(world) | _beside(world, scenario)
    if np.isfinite(model.read_state().omega_body).all():
        acting |= _acting(Probe(advance, model, scenario))
    return frozenset(acting)


def _engine(world: World, scenario: Scenario) -> set[str]:
    """Return a set with "gravity" if it acts as in the scene, and descriptions of other settings.

    Described are real-time stepping, and a gravity that is not the scene's.
    """
    engine = p.getPhysicsEngineParameters(world.client)
    gravity = [engine[f"gravityAcceleration{axis}"] for axis in "XYZ"]
    acting = {"real-time stepping"} if engine["useRealTimeSimulation"] else set()
    if gravity != scenario.gravity_world.tolist():
        acting.add(f"a gravity of {gravity} m/s²")
    elif "gravity" in scenario.called_for:
        acting.add("gravity")
    return acting


def _holds(world: World) -> set[str]:
    """Return the effects that hold the body, and descriptions of other joints and constraints."""
    acting, client, slides = set(), world.client, 0
    for joint in range(p.getNumJoints(world.body, client)):
        kind = p.getJointInfo(world.body, joint, client)[2]
        if kind == p.JOINT_FIXED or joint in world.hinges:
            continue  # the joint of another link of the body, or of a rotor
        if kind == p.JOINT_PRISMATIC and joint < world.link:
            slides += 1
        elif kind == p.JOINT_SPHERICAL:
            acting.add(HELD_BY.get(slides, f"a joint on {slides} slides"))
        else:
            acting.add(f"a joint of type {kind}")
    for index in range(p.getNumConstraints(client)):
        kind = p.getConstraintInfo(p.getConstraintUniqueId(index, client), client)[4]
        acting.add("pivot" if kind == p.JOINT_POINT2POINT else f"a constraint of type {kind}")
    return acting


def _beside(world: World, scenario: Scenario) -> set[str]:
    """Return descriptions of what could collide: other bodies, and collision shapes.

    If a contact implements the table, a plane at the scene's height is reported as "table". All
    other bodies are then removed: a plane would push the body in the measurements that follow.
    """
    client, acting = world.client, set()
    bodies = [p.getBodyUniqueId(i, client) for i in range(p.getNumBodies(client))]
    others = [body for body in bodies if body != world.body]
    if world.scene["plane"] is not None:
        _, height = sphere_and_plane(scenario)
        has_tip = _has_shape(client, world.body, BASE)
        for body in others:
            kinds = [shape[2] for shape in p.getCollisionShapeData(body, BASE, client)]
            place, _ = p.getBasePositionAndOrientation(body, client)
            is_table = kinds == [p.GEOM_PLANE] and place == (0, 0, height) and has_tip
            acting.add("table" if is_table else "another body")
            p.removeBody(body, client)
        return acting
    if any(p.getDynamicsInfo(body, BASE, client)[0] for body in others):
        acting.add("another body")
    for body in bodies:
        links = range(BASE, p.getNumJoints(body, client))
        if any(_has_shape(client, body, link) for link in links):
            acting.add("a collision shape")
    return acting


def _has_shape(client: int, body: int, link: int) -> bool:
    """Whether a link has a collision shape that is larger than PyBullet's empty one.

    The arguments are PyBullet's numbers. What is compared is the collision margin, which for a
    sphere is its radius, and the bounding box, because PyBullet does not report the shapes of
    bodies in maximal coordinates.
    """
    margin = p.getDynamicsInfo(body, link, client)[11]
    low, high = p.getAABB(body, link, client)
    # The longest edge, in any attitude, of the bounding box of a cube with edges of twice
    # `EMPTY_MARGIN`.
    furthest = 2 * np.sqrt(3) * EMPTY_MARGIN * (1 + SLACK)
    return bool(margin > EMPTY_MARGIN or max(np.subtract(high, low)) > furthest)


def _acting(probe: Probe) -> set[str]:
    """Return names of the effects that act, and descriptions of other torques and forces.

    Effects are torques, drag and rotors; PyBullet's damping, motors and clamp are described. They
    are found by steps of the probe. The steps are taken without gravity, from rest and from a spin.
    """
    torque, resistance, force = probe.unlike()
    acting = {words for words in (torque, resistance, force) if words}
    if acting:
        acting |= _slowing_defaults(probe)
        # PyBullet's defaults are now off: measured again, for the effects of the scene.
        torque, resistance, _ = probe.unlike()
    if not torque:
        acting |= probe.scenario.called_for & {"torque_body", "torque_world"}
    if not resistance:
        acting |= probe.scenario.called_for & {"drag"}
    if probe.scenario.rotors:
        acting |= _wrong_hinges(probe) or {"rotors"}
    # The clamp comes last: the fast step changes the attitude.
    return acting | ({"velocity clamp"} if _is_clamped(probe) else set())


def _wrong_hinges(probe: Probe) -> set[str]:
    """Return, in words, what is wrong with the rotors' hinges, as a set; empty if nothing is.

    If removing PyBullet's motors mends everything, the set is {"joint motor"}.
    """
    if not probe.wrong_hinges():
        return set()
    probe.model.world.take_away_motors()
    return set(probe.wrong_hinges()) or {"joint motor"}


def _slowing_defaults(probe: Probe) -> set[str]:
    """Remove PyBullet's damping and joint motor; return the names of those that resisted a spin."""
    world, acting = probe.model.world, set()
    slowing: dict[str, Callable[[], object]] = {"damping": world.take_away_damping}
    if world.link != BASE:
        # The motor is removed first, because its torque would hide the damping.
        slowing = {"joint motor": partial(world.set_motor, 0), **slowing}
    for name, take_away in slowing.items():
        with_it = probe.resistance()
        take_away()
        if not near(probe.resistance(), with_it, probe.noise):
            acting.add(name)
    return acting


def _is_clamped(probe: Probe) -> bool:
    """Whether PyBullet clamps velocities, so that most of a fast spin is lost in one step.

    Damping and motors must have been removed before, as they would also slow the spin.
    """
    before, after = probe.after(probe.spin_world * (PROBE_RUSH / PROBE_SPIN))
    speed = float(np.linalg.norm(before.omega_body))
    return bool(np.linalg.norm(after.omega_body) < speed / 2)
