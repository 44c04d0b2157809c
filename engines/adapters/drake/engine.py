"""Drake, multibody dynamics with integrators of fixed step, in double precision.

What it does to a top by default, and how each effect was measured: docs/engines-more.md.
"""

from importlib import import_module
from importlib.metadata import version
from typing import Any, final

import numpy as np

from ....scenarios import FloatArray, Scenario
from ...checks.read_back import BodyReading, EngineError
from ...engine import Engine, Method
from ...matrix_session import MatrixReading, MatrixSession
from ...session import Session
from .script import script

EFFECTS = frozenset({"gravity", "pivot", "drag", "torque_body", "torque_world"})
TORQUES = frozenset({"torque_body", "torque_world"})
#: Entries of a tensor in the order of Drake's constructor.
ENTRIES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
#: Relative rounding of a torque that was rotated.
SLACK = 16 * float(np.finfo(float).eps)
#: Methods in which the plant steps itself, without an integrator.
DISCRETE = frozenset({"discrete", "default"})


def _method(name: str, order: int, summary: str, as_shipped: bool = False) -> Method:
    return Method(name, order, order, summary, EFFECTS, as_shipped=as_shipped, by_angles=True)


@final
class Drake(Engine):
    """A body on a quaternion joint, or on a ball joint of roll, pitch and yaw at its pivot."""

    name = "drake"
    package = "pydrake"
    step_seconds = 15e-6
    # MultibodyPlantConfig.time_step.
    stock_timestep = 1e-3
    # Orders: its documentation of the integrators; measured in docs/engines-more.md.
    methods = (
        _method("runge_kutta5", 5, "Runge-Kutta of fifth order"),
        _method("runge_kutta3", 3, "Runge-Kutta of third order"),
        _method("semi_explicit_euler", 1, "semi-implicit Euler"),
        _method("discrete", 1, "the plant's own steps, without an integrator"),
        _method("default", 1, "as shipped: as discrete, with a scene graph", as_shipped=True),
    )

    @property
    def version(self) -> str:
        """Of the installed package."""
        return version("drake")

    def open(self, scenario: Scenario, method: Method, timestep: float) -> Session:
        """Build a diagram of the plant and of a system that applies the scene's torques, if any."""
        return DrakeSession(scenario, method.name, timestep)

    def script(self, scenario: Scenario, method: Method, timestep: float) -> str:  # noqa: ARG002
        """The plant as Python."""
        return script(scenario, method.name, method.name in DISCRETE, _entries(scenario))


@final
class DrakeSession(MatrixSession):
    """One body in a plant of its own; its frame is the scene's body frame.

    Raises
    ------
    EngineError
        If the ball joint is singular, at a pitch of 90°; with Drake's message.
    """

    def __init__(self, scenario: Scenario, method: str, timestep: float) -> None:
        drake: Any = import_module("pydrake.all")
        self._drake, self._scenario, self._timestep = drake, scenario, timestep
        self._is_discrete = method in DISCRETE
        builder = drake.DiagramBuilder()
        self._plant, self._body, self._joint = _plant(
            drake, builder, scenario, timestep if self._is_discrete else 0.0, method == "default"
        )
        _push(drake, builder, self._plant, self._body, scenario)
        self._simulator = drake.Simulator(builder.Build())
        root = self._simulator.get_mutable_context()
        self._context = self._plant.GetMyMutableContextFromRoot(root)
        if not self._is_discrete:
            config = drake.SimulatorConfig(
                integration_scheme=method, max_step_size=timestep, use_error_control=False
            )
            drake.ApplySimulatorConfig(config, self._simulator)
        _set_start(drake, self._joint, self._context, scenario)
        self._simulator.Initialize()
        self._taken, self._clock = 0, 0.0

    def read_body(self) -> BodyReading:
        """The body as the plant's context holds it; com from the joint."""
        held = self._body.CalcSpatialInertiaInBodyFrame(self._context)
        mass, com = held.get_mass(), np.array(held.get_com())
        about_origin = held.CalcRotationalInertia()
        about_com = about_origin.ShiftToCenterOfMass(mass, com).CopyToFullMatrix3()
        return BodyReading(float(mass), com, np.array(about_com))

    def read_matrix(self) -> MatrixReading:
        """The state now."""
        body, context = self._body, self._context
        pose, moving = body.EvalPoseInWorld(context), body.EvalSpatialVelocityInWorld(context)
        R_world_body, omega_world = np.array(pose.rotation().matrix()), moving.rotational()
        return MatrixReading(
            R_world_body,
            R_world_body.T @ omega_world,
            np.asarray(pose @ body.CalcCenterOfMassInBodyFrame(context)),
            np.array(body.CalcCenterOfMassTranslationalVelocityInWorld(context)),
        )

    def advance(self, steps: int) -> None:
        """One native loop, up to the time that Drake's own clock reaches by summing steps.

        A discrete plant steps at multiples of the timestep, the first at 0, so it is advanced to a
        time between two of them. With any other end time Drake would take a tiny extra step, or one
        step less.
        """
        self._taken += steps
        until = (self._taken - 0.5) * self._timestep
        if not self._is_discrete:
            for _ in range(steps):
                self._clock += self._timestep
            until = self._clock
        try:
            self._simulator.AdvanceTo(until)
        except RuntimeError as error:
            words = " ".join(str(error).split())
            singular = "singularity" in words
            raise EngineError(f"Drake: {words}", "warning" if singular else "refused") from None

    def check(self) -> None:
        """Check that Drake took the right number of steps."""
        simulator = self._simulator
        if self._is_discrete:
            count = simulator.get_num_unrestricted_updates()
        else:
            count = simulator.get_integrator().get_num_steps_taken()
        if count != self._taken:
            raise EngineError(f"Drake took {count} steps, not {self._taken}", "clock")

    def active(self) -> frozenset[str]:
        """What acts, as reported by plant, joint and input port."""
        plant, scenario = self._plant, self._scenario
        gravity = np.array(plant.gravity_field().gravity_vector())
        right = np.array_equal(gravity, scenario.gravity_world)
        damping = np.array(self._joint.GetDampingVector(self._context))
        is_drag = np.array_equal(damping, _damping(self._joint, scenario))
        torque, wanted = self._felt_torque(), self._torque()
        pushes = np.linalg.norm(torque - wanted) <= SLACK * np.linalg.norm(wanted)
        named = {
            "gravity" if right else f"a gravity of {gravity.tolist()} m/s²": gravity.any(),
            "drag" if is_drag else f"a joint damping of {damping.tolist()}": damping.any(),
            "pivot": self._joint.type_name() == self._drake.BallRpyJoint.kTypeName,
            f"a torque of {torque.tolist()} N m": not pushes,
            "joints": plant.num_joints() > 1,
            # Gravity is one of them.
            "force elements": plant.num_force_elements() > 1,
            "actuators": plant.num_actuators() > 0,
            "contact geometry": plant.geometry_source_is_registered(),
        }
        acting = frozenset(name for name, acts in named.items() if acts)
        return acting | (scenario.called_for & TORQUES if torque.any() else frozenset())

    def close(self) -> None:
        """Drop plant and simulator."""
        del self._context, self._body, self._joint, self._plant, self._simulator

    def _felt_torque(self) -> FloatArray:
        """The torque at the plant's input port, N m, world axes."""
        port = self._plant.get_applied_spatial_force_input_port()
        forces = port.Eval(self._context) if port.HasValue(self._context) else []
        return sum((np.array(force.F_Bq_W.rotational()) for force in forces), np.zeros(3))

    def _torque(self) -> FloatArray:
        """The torque that the scene has, N m, world axes."""
        R_world_body = self._body.EvalPoseInWorld(self._context).rotation().matrix()
        return np.asarray(R_world_body @ self._scenario.torque_body + self._scenario.torque_world)


def _plant(
    drake: Any, builder: Any, scenario: Scenario, own_timestep: float, as_shipped: bool
) -> tuple[Any, Any, Any]:
    """The plant, its body, and the body's joint."""
    if as_shipped:
        config = drake.MultibodyPlantConfig(time_step=own_timestep)
        plant, _ = drake.AddMultibodyPlant(config, builder)
    else:
        plant = builder.AddSystem(drake.MultibodyPlant(time_step=own_timestep))
    held = scenario.body
    about_com = drake.RotationalInertia(*_entries(scenario))
    central = drake.SpatialInertia.MakeFromCentralInertia
    body = plant.AddRigidBody("top", central(held.mass, np.array(held.com), about_com))
    frames = plant.world_frame(), body.body_frame()
    if scenario.has_pivot:
        joint = drake.BallRpyJoint("pivot", *frames, scenario.drag)
    else:
        joint = drake.QuaternionFloatingJoint("free", *frames, scenario.drag)
    joint = plant.AddJoint(joint)
    plant.mutable_gravity_field().set_gravity_vector(np.array(scenario.gravity_world))
    plant.Finalize()
    return plant, body, joint


def _push(drake: Any, builder: Any, plant: Any, body: Any, scenario: Scenario) -> None:
    """Connect a system that computes the scene's torques, if any, at each evaluation."""
    if not scenario.called_for & TORQUES:
        return
    force = drake.ExternallyAppliedSpatialForce()
    force.body_index = body.index()

    def torque(context: Any, output: Any) -> None:
        R_world_body = system.poses.Eval(context)[int(body.index())].rotation().matrix()
        turned = R_world_body @ scenario.torque_body + scenario.torque_world
        force.F_Bq_W = drake.SpatialForce(turned, np.zeros(3))
        output.set_value([force])

    system = drake.LeafSystem()
    system.poses = system.DeclareAbstractInputPort(
        "poses", drake.Value[list[drake.RigidTransform]]()
    )
    kind = drake.Value[list[drake.ExternallyAppliedSpatialForce]]
    system.DeclareAbstractOutputPort("torque", kind, torque)
    builder.AddSystem(system)
    builder.Connect(plant.get_body_poses_output_port(), system.get_input_port())
    builder.Connect(system.get_output_port(), plant.get_applied_spatial_force_input_port())


def _set_start(drake: Any, joint: Any, context: Any, scenario: Scenario) -> None:
    start, com = scenario.start, scenario.body.com
    attitude = drake.Quaternion(start.q_world_body_wxyz)
    turned = drake.RotationMatrix(attitude)
    R_world_body = turned.matrix()
    omega_world = R_world_body @ start.omega_body
    if scenario.has_pivot:
        joint.set_angles(context, drake.RollPitchYaw(turned).vector())
        joint.set_angular_velocity(context, omega_world)
        return
    origin = start.position_world - R_world_body @ com
    velocity = start.velocity_world - np.cross(omega_world, R_world_body @ com)
    joint.SetQuaternion(context, attitude)
    joint.SetTranslation(context, origin)
    joint.set_angular_velocity(context, omega_world)
    joint.set_translational_velocity(context, velocity)


def _entries(scenario: Scenario) -> list[float]:
    """The tensor about the com in the order of Drake's constructor, kg m²."""
    return [float(scenario.body.inertia_com[row, column]) for row, column in ENTRIES]


def _damping(joint: Any, scenario: Scenario) -> FloatArray:
    """Damping of a joint whose first three velocities are rotations."""
    return np.array([scenario.drag] * 3 + [0.0] * (joint.num_velocities() - 3))
