"""A Rapier world and its steps as Python that needs `rapier3d` and numpy alone."""

from collections.abc import Iterator

import numpy as np

from ....scenarios import FloatArray, Scenario
from .held import Held

_START = """\
import rapier3d

world = rapier3d.PhysicsWorld(gravity={gravity})  # m/s^2
world.integration_parameters.dt = TIMESTEP
# Principal axes in the body's, w x y z; com, m, mass, kg, principal moments, kg m^2.
axes = rapier3d.Rotation3{axes}
held = rapier3d.MassProperties({com}, {mass!r}, {moments}, axes)
attitude = rapier3d.Rotation3{attitude}  # w x y z
described = (
    rapier3d.RigidBody.dynamic()
    .position(rapier3d.Isometry3({origin}, attitude))  # m
    .linvel({velocity})  # m/s, of the com
    .angvel({omega})  # rad/s, world axes
    .additional_mass_properties(held)
{settings})
handle = world.add_body(described)
body = world.rigid_bodies[handle]
# Its mass reads 0 until it is recomputed.
body.recompute_mass_properties_from_colliders(world.colliders)
"""
_SETTINGS = """\
    .can_sleep(False)
    .allow_fast_rotation(True)
"""
_PIVOT = """\
ground = world.add_body(rapier3d.RigidBody.fixed())
world.impulse_joints.insert(ground, handle, rapier3d.SphericalJoint.builder().build())
"""
_STEPS = """

def motion():
    \"\"\"Attitude, w x y z, body to world, and angular velocity in world axes.\"\"\"
    q, omega = body.rotation, body.angvel
    q_wxyz = np.array([q.w, q.i, q.j, q.k])
    return q_wxyz / np.linalg.norm(q_wxyz), np.array([omega.x, omega.y, omega.z])


def step(count):
    for _ in range(count):
{pushes}        world.step()


def state():
    \"\"\"Attitude, w x y z, body to world, and angular velocity in body axes.\"\"\"
    q, omega_world = motion()
    return q, turned(conjugate(q), omega_world)
"""


def script(scenario: Scenario, told: Held, as_shipped: bool) -> str:
    """The world, and its steps with the scene's torques before each."""
    start = _START.format(
        gravity=_tuple(scenario.gravity_world),
        axes=_tuple(told.q_body_axes_wxyz),
        com=_tuple(told.com),
        mass=told.mass,
        moments=_tuple(told.moments),
        origin=_tuple(told.origin_world),
        attitude=_tuple(told.q_world_body_wxyz),
        velocity=_tuple(told.velocity_world),
        omega=_tuple(told.omega_world),
        settings="" if as_shipped else _SETTINGS,
    )
    pushes = "".join(f"        {line}\n" for line in _pushes(scenario))
    return start + (_PIVOT if scenario.has_pivot else "") + _STEPS.format(pushes=pushes)


def _pushes(scenario: Scenario) -> Iterator[str]:
    """The torque now, N m, world axes, which Rapier keeps until it is reset."""
    torques = []
    if scenario.torque_world.any():
        torques.append(f"np.array({_tuple(scenario.torque_world)})")
    if scenario.torque_body.any():
        torques.append(f"turned(q, {_tuple(scenario.torque_body)})")
    if scenario.drag:
        torques.append(f"{-scenario.drag!r} * omega_world")
    if torques:
        yield "q, omega_world = motion()"
        yield f"torque = {' + '.join(torques)}  # N m, world axes"
        yield "body.reset_torques()"
        yield "body.add_torque(tuple(torque.tolist()))"


def _tuple(values: FloatArray) -> str:
    return repr(tuple(np.asarray(values, dtype=float).tolist()))
