"""What acts on a body in PyBullet: read back where PyBullet tells, felt where it does not.

PyBullet reports neither damping nor applied torques. So after a run the body is set spinning, and
set at rest, for one tiny step each without gravity: what its angular momentum then gains is what
acts.
"""

from typing import Protocol

import numpy as np
import pybullet as p

from ..scenarios import FloatArray, Scenario, Trajectory, angular_momentum_world
from .pybullet_model import BASE, Model

#: s. A gain of L over a step is rounded to EPS L / h a second, and off by h times whatever turns:
#: least together where h is the root of EPS.
PROBE_STEP = 2.0**-26
#: rad/s, and m/s of a free body's com; slow, so that gyroscopic terms stay below both errors.
PROBE_SPIN = 2.0**-7
#: Of roundings and of such terms there are a few each. PyBullet's default damping, 0.04 I ω, is a
#: hundred thousand times as much.
SLACK = 16 * PROBE_STEP


class Steps(Protocol):
    """The part of a session that a probe uses."""

    def set_timestep(self, timestep: float) -> None:
        """Length of the steps from now on, s."""

    def advance(self, steps: int) -> None:
        """Take whole steps, with the torques that belong to the scene."""


def what_acts(steps: Steps, model: Model, scenario: Scenario) -> frozenset[str]:
    """Effects by their names, and in words whatever else acts. The state is lost."""
    found = {*_world(model, scenario), *_holds(model), *_extras(model)}
    if np.isfinite(model.read_state().omega_body).all():
        found |= _felt(steps, model, scenario)
    return frozenset(found)


def _world(model: Model, scenario: Scenario) -> set[str]:
    world = p.getPhysicsEngineParameters(model.client)
    gravity = [world[f"gravityAcceleration{axis}"] for axis in "XYZ"]
    found = {"real-time stepping"} if world["useRealTimeSimulation"] else set()
    if gravity != scenario.gravity_world.tolist():
        found.add(f"a gravity of {gravity} m/s²")
    elif "gravity" in scenario.called_for:
        found.add("gravity")
    return found


def _holds(model: Model) -> set[str]:
    """What the body hangs by: joints of its own, constraints of the world."""
    found = set()
    for joint in range(p.getNumJoints(model.body, model.client)):
        kind = p.getJointInfo(model.body, joint, model.client)[2]
        found.add("pivot" if kind == p.JOINT_SPHERICAL else f"a joint of type {kind}")
    for index in range(p.getNumConstraints(model.client)):
        constraint = p.getConstraintUniqueId(index, model.client)
        kind = p.getConstraintInfo(constraint, model.client)[4]
        found.add("pivot" if kind == p.JOINT_POINT2POINT else f"a constraint of type {kind}")
    return found


def _extras(model: Model) -> set[str]:
    """Shapes that can collide, and bodies that move."""
    found = set()
    for index in range(p.getNumBodies(model.client)):
        body = p.getBodyUniqueId(index, model.client)
        if body != model.body and p.getDynamicsInfo(body, BASE, model.client)[0]:
            found.add("another body")
        links = range(BASE, p.getNumJoints(body, model.client))
        if any(_has_shape(model.client, body, link) for link in links):
            found.add("a collision shape")
    return found


def _has_shape(client: int, body: int, link: int) -> bool:
    """Whether the bounding box is more than the margin that PyBullet puts around no shape at all.

    (Of the shapes themselves it tells nothing in maximal coordinates.)
    """
    margin = p.getDynamicsInfo(body, link, client)[11]
    low, high = p.getAABB(body, link, client)
    # A cube of half-width `margin`, turned to reach furthest.
    return bool(max(np.subtract(high, low)) > 2 * np.sqrt(3) * margin * (1 + SLACK))


def _felt(steps: Steps, model: Model, scenario: Scenario) -> set[str]:
    """Torques, drag and whatever slows the com, from what a step adds to the momenta."""
    p.setGravity(0, 0, 0, physicsClientId=model.client)
    steps.set_timestep(PROBE_STEP)
    if scenario.has_pivot and model.link == BASE:
        model.put_on_pivot()
    world_from_body = model.world_from_body()
    push_world = world_from_body.apply(np.array(scenario.torque_body)) + scenario.torque_world
    spin_world = world_from_body.apply(np.full(3, PROBE_SPIN))
    _, at_rest = _gains(steps, model, scenario, np.zeros(3))
    force, spinning = _gains(steps, model, scenario, spin_world)
    largest_moment = float(np.abs(scenario.body.inertia_origin).max())
    noise = SLACK * (PROBE_SPIN * largest_moment + float(np.linalg.norm(push_world)))
    found: set[str] = set()
    if _near(at_rest, push_world, noise):
        found |= scenario.called_for & {"torque_body", "torque_world"}
    else:
        found.add(f"a torque of {_size(at_rest)} N m at rest")
    if _near(spinning - at_rest, -scenario.drag * spin_world, noise):
        found |= scenario.called_for & {"drag"}
    else:
        found.add(f"a resistance of {_size(spinning - at_rest)} N m at {_size(spin_world)} rad/s")
    if not (
        scenario.has_pivot or _near(force, np.zeros(3), SLACK * PROBE_SPIN * scenario.body.mass)
    ):
        found.add(f"a force of {_size(force)} N at {_size(spin_world)} m/s")
    return found


def _gains(
    steps: Steps, model: Model, scenario: Scenario, omega_world: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Momentum gained, N, and angular momentum, N m, in a step that starts at this ω; (3,) each.

    A free body starts with a velocity besides, in m/s the same vector.
    """
    arm_world = model.world_from_body().apply(model.com)
    at_pivot = np.cross(omega_world, arm_world)
    model.set_velocity(omega_world, at_pivot if scenario.has_pivot else omega_world)
    before = model.read_state()
    steps.advance(1)
    after = model.read_state()
    pair = {name: np.array([value, getattr(after, name)]) for name, value in vars(before).items()}
    motion = Trajectory(t=np.array([0.0, PROBE_STEP]), **pair)
    L_world = angular_momentum_world(scenario, motion)
    force = scenario.body.mass * (after.velocity_world - before.velocity_world) / PROBE_STEP
    return force, np.asarray((L_world[1] - L_world[0]) / PROBE_STEP)


def _near(got: FloatArray, wanted: FloatArray, noise: float) -> bool:
    return bool(np.abs(got - wanted).max() <= SLACK * np.abs(wanted).max() + noise)


def _size(vector: FloatArray) -> str:
    return f"{np.linalg.norm(vector):.3g}"
