"""A Drake plant and its steps as Python that needs `pydrake` and numpy alone."""

from collections.abc import Iterator

from ....scenarios import Scenario
from ...models.text import python_list

_START = """\
import pydrake.all as drake

COM = np.array({com})  # m, body axes, from the body's origin
builder = drake.DiagramBuilder()
{plant}
# kg m^2 about the com: xx, yy, zz, xy, xz, yz.
inertia = drake.RotationalInertia{inertia}
held = drake.SpatialInertia.MakeFromCentralInertia({mass!r}, COM, inertia)  # kg
body = plant.AddRigidBody("top", held)
joint = plant.AddJoint(
    drake.{joint}("joint", plant.world_frame(), body.body_frame(), {drag!r})  # N m s
)
plant.mutable_gravity_field().set_gravity_vector({gravity})  # m/s^2
plant.Finalize()
"""
_PLANT = "plant = builder.AddSystem(drake.MultibodyPlant(time_step={timestep}))"
_PLANT_AS_SHIPPED = """\
config = drake.MultibodyPlantConfig(time_step=TIMESTEP)
plant, scene_graph = drake.AddMultibodyPlant(config, builder)"""
_TORQUE = """

class Torque(drake.LeafSystem):
    \"\"\"Constant torques, N m, one in body axes and one in world axes.\"\"\"

    def __init__(self):
        super().__init__()
        poses = drake.Value[list[drake.RigidTransform]]()
        self.poses = self.DeclareAbstractInputPort("poses", poses)
        kind = drake.Value[list[drake.ExternallyAppliedSpatialForce]]
        self.DeclareAbstractOutputPort("torque", kind, self.torque)

    def torque(self, context, output):
        R_world_body = self.poses.Eval(context)[int(body.index())].rotation().matrix()
        torque_world = R_world_body @ {torque_body} + {torque_world}
        force = drake.ExternallyAppliedSpatialForce()
        force.body_index = body.index()
        force.F_Bq_W = drake.SpatialForce(torque_world, np.zeros(3))
        output.set_value([force])


torque = builder.AddSystem(Torque())
builder.Connect(plant.get_body_poses_output_port(), torque.get_input_port())
builder.Connect(torque.get_output_port(), plant.get_applied_spatial_force_input_port())
"""
_SIMULATOR = """\
simulator = drake.Simulator(builder.Build())
context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
"""
_INTEGRATOR = """\
config = drake.SimulatorConfig(
    integration_scheme="{method}", max_step_size=TIMESTEP, use_error_control=False
)
drake.ApplySimulatorConfig(config, simulator)
"""
_ATTITUDE = """\
attitude = drake.Quaternion({attitude})  # w x y z
R_world_body = drake.RotationMatrix(attitude).matrix()
omega_world = R_world_body @ {omega}  # rad/s
"""
_HELD = """\
joint.set_angles(context, drake.RollPitchYaw(drake.RotationMatrix(attitude)).vector())
joint.set_angular_velocity(context, omega_world)
"""
_FREE = """\
arm = R_world_body @ COM
joint.SetQuaternion(context, attitude)
joint.SetTranslation(context, {position} - arm)  # m
joint.set_angular_velocity(context, omega_world)
joint.set_translational_velocity(context, {velocity} - np.cross(omega_world, arm))  # m/s
"""
_DISCRETE_STEPS = """\
simulator.Initialize()
taken = 0


def step(count):
    # The plant steps at multiples of the timestep, the first at 0: to a time between two.
    global taken
    taken += count
    simulator.AdvanceTo((taken - 0.5) * TIMESTEP)
"""
_STEPS = """\
simulator.Initialize()
clock = 0.0


def step(count):
    # Drake sums up the steps: to any other time it takes a sliver of a step besides.
    global clock
    for _ in range(count):
        clock += TIMESTEP
    simulator.AdvanceTo(clock)
"""
_STATE = """

def state():
    \"\"\"Attitude, w x y z, body to world, and angular velocity in body axes.\"\"\"
    rotation = body.EvalPoseInWorld(context).rotation()
    omega_world = body.EvalSpatialVelocityInWorld(context).rotational()
    return rotation.ToQuaternion().wxyz(), rotation.matrix().T @ omega_world
"""


def script(scenario: Scenario, method: str, is_discrete: bool, inertia: list[float]) -> str:
    """The plant as a method has it.

    Parameters
    ----------
    inertia : kg m², in the order of Drake's constructor
    """
    return "".join(_parts(scenario, method, is_discrete, inertia))


def _parts(
    scenario: Scenario, method: str, is_discrete: bool, inertia: list[float]
) -> Iterator[str]:
    body, start = scenario.body, scenario.start
    plant = _PLANT.format(timestep="TIMESTEP" if is_discrete else "0.0")
    yield _START.format(
        com=python_list(body.com),
        plant=_PLANT_AS_SHIPPED if method == "default" else plant,
        inertia=tuple(inertia),
        mass=float(body.mass),
        joint="BallRpyJoint" if scenario.has_pivot else "QuaternionFloatingJoint",
        drag=float(scenario.drag),
        gravity=python_list(scenario.gravity_world),
    )
    torques = scenario.torque_body, scenario.torque_world
    if any(torque.any() for torque in torques):
        in_body, in_world = map(python_list, torques)
        yield _TORQUE.format(torque_body=in_body, torque_world=in_world)
    yield _SIMULATOR
    if not is_discrete:
        yield _INTEGRATOR.format(method=method)
    yield _ATTITUDE.format(
        attitude=python_list(start.q_world_body_wxyz), omega=python_list(start.omega_body)
    )
    if scenario.has_pivot:
        yield _HELD
    else:
        yield _FREE.format(
            position=python_list(start.position_world), velocity=python_list(start.velocity_world)
        )
    yield _DISCRETE_STEPS if is_discrete else _STEPS
    yield _STATE
