"""A DART world and its steps as Python that needs `dartpy` and numpy alone."""

from collections.abc import Iterator

from ....scenarios import Scenario
from ...models.text import python_list
from .start import start_of

_START = """\
import dartpy as dart

world = dart.simulation.World("world")
world.setTimeStep(TIMESTEP)
world.setGravity(np.array({gravity}))  # m/s^2
"""
_AWAKE = """\
options = world.getDeactivationOptions()
options.mEnabled = False
world.setDeactivationOptions(options)
"""
_BODY = """\
skeleton = dart.dynamics.Skeleton("top")
joint, body = skeleton.create{joint}JointAndBodyNodePair()
# m, body axes, from the joint; kg m^2, about the com.
com = np.array({com})
inertia = np.array({inertia})
body.setInertia(dart.dynamics.Inertia({mass!r}, com, inertia))  # kg
"""
_DRAG = """\
for k in range(3):
    joint.setDampingCoefficient(k, {drag!r})  # N m s
"""
_HELD = """\
joint.setPositions(np.array({rotation}))  # a rotation vector, rad
joint.setVelocities(np.array({omega}))  # rad/s, body axes
"""
_FREE = """\
# Position of the body's origin, m; rad/s, then m/s of that origin, body axes.
attitude = np.array({attitude})
joint.setTransform(dart.math.Isometry3(attitude, np.array({origin})))
velocity = np.array({velocity})
joint.setSpatialVelocity(velocity, dart.dynamics.Frame.World(), body)
"""
_STEPS = """\
world.addSkeleton(skeleton)


def step(count):
    for _ in range(count):
{pushes}        world.step()


def state():
    \"\"\"Attitude, w x y z, body to world, and angular velocity in body axes.\"\"\"
    return body.getWorldTransform().quaternion().wxyz(), body.getSpatialVelocity()[:3]
"""


def script(scenario: Scenario, as_shipped: bool) -> str:
    """The world, and its steps with the scene's torques before each."""
    return "".join(_parts(scenario, as_shipped))


def _parts(scenario: Scenario, as_shipped: bool) -> Iterator[str]:
    body, start = scenario.body, start_of(scenario)
    yield _START.format(gravity=python_list(scenario.gravity_world))
    if not as_shipped:
        yield _AWAKE
    yield _BODY.format(
        joint="Ball" if scenario.has_pivot else "Free",
        com=python_list(body.com),
        inertia=python_list(body.inertia_com),
        mass=float(body.mass),
    )
    if scenario.drag:
        yield _DRAG.format(drag=scenario.drag)
    if scenario.has_pivot:
        rotation, omega = python_list(start.rotation_vector), python_list(start.omega_body)
        yield _HELD.format(rotation=rotation, omega=omega)
    else:
        yield _FREE.format(
            attitude=python_list(start.R_world_body),
            origin=python_list(start.origin_world),
            velocity=python_list([*start.omega_body, *start.velocity_body]),
        )
    yield _STEPS.format(pushes="".join(f"        {line}\n" for line in _pushes(scenario)))


def _pushes(scenario: Scenario) -> Iterator[str]:
    """Torques, N m, which DART clears after each step."""
    for torque, in_body in ((scenario.torque_body, True), (scenario.torque_world, False)):
        if torque.any():
            axes = "body axes" if in_body else "world axes"
            yield f"body.addExtTorque(np.array({python_list(torque)}), {in_body})  # N m, {axes}"
