"""A Drake plant of one body and its simulator, which need `pydrake` and numpy alone."""

import numpy as np
import pydrake.all as drake

from ...world_parts import drive, matrix, push, rotor_tensor

#: Names of the methods with a discrete plant, which steps itself, without an integrator.
DISCRETE = ("discrete", "default")


class Torque(drake.LeafSystem):
    """A Drake system whose output is the scene's constant torques on the body.

    Parameters
    ----------
    scene : the scene's record
    body : the plant's body
    """

    def __init__(self, scene, body):
        super().__init__()
        # Drag is left out: it is implemented as damping of the joint.
        self.scene, self.body = scene | {"drag": 0.0}, body
        poses = drake.Value[list[drake.RigidTransform]]()
        self.poses = self.DeclareAbstractInputPort("poses", poses)
        kind = drake.Value[list[drake.ExternallyAppliedSpatialForce]]
        self.DeclareAbstractOutputPort("torque", kind, self.torque)

    def torque(self, context, output):
        """Set the value `output` of the output port to the torque on the body.

        The torque is that at the body's attitude in `context`, the context of this system.
        """
        R = self.poses.Eval(context)[int(self.body.index())].rotation().matrix()
        force = drake.ExternallyAppliedSpatialForce()
        force.body_index = self.body.index()
        force.F_Bq_W = drake.SpatialForce(push(self.scene, R, np.zeros(3)), np.zeros(3))
        output.set_value([force])


class World:
    """One body on a quaternion joint, or on a ball joint of roll, pitch and yaw where it is held.

    On a table the ball joint is on slides. Rotors are on revolute joints; locked ones are welded to
    the body.

    Parameters
    ----------
    scene : the scene's record
    method : name of the method
    timestep : length of the steps, s
    """

    def __init__(self, scene, method, timestep):
        self.method, self.is_discrete = method, method in DISCRETE
        self.is_free = scene["arm"] is None
        builder = drake.DiagramBuilder()
        own_timestep = timestep if self.is_discrete else 0.0
        if method == "default":
            config = drake.MultibodyPlantConfig(time_step=own_timestep)
            self.plant, _ = drake.AddMultibodyPlant(config, builder)
        else:
            self.plant = builder.AddSystem(drake.MultibodyPlant(time_step=own_timestep))
        self.add_body(scene)
        if np.any([scene["torque_body"], scene["torque_world"]]):
            torque = builder.AddSystem(Torque(scene, self.body))
            builder.Connect(self.plant.get_body_poses_output_port(), torque.get_input_port())
            applied = self.plant.get_applied_spatial_force_input_port()
            builder.Connect(torque.get_output_port(), applied)
        self.simulator = drake.Simulator(builder.Build())
        root = self.simulator.get_mutable_context()
        self.context = self.plant.GetMyMutableContextFromRoot(root)
        if not self.is_discrete:
            config = drake.SimulatorConfig(
                integration_scheme=method, max_step_size=timestep, use_error_control=False
            )
            drake.ApplySimulatorConfig(config, self.simulator)
        self.restart(scene, timestep)

    def add_body(self, scene):
        """Add the body, its joints, its rotors and gravity to the plant; finalize the plant.

        The body's frame is at its joint, along the scene record's axes.
        """
        lever = -np.array(scene["arm"] or (0.0, 0.0, 0.0))  # from the joint to the com
        inertia = drake.SpatialInertia.MakeFromCentralInertia(
            scene["mass"], lever, drake.RotationalInertia(*scene["moments"])
        )
        self.body = self.plant.AddRigidBody("top", inertia)
        self.slides = []
        world, frame = self.slid(scene), self.body.body_frame()
        # Roll, pitch and yaw turn the scene's body axes, not the principal axes of the record.
        self.R_frame_own = np.eye(3) if self.is_free else matrix(scene["axes"]).T
        if self.is_free:
            joint = drake.QuaternionFloatingJoint("free", world, frame, scene["drag"])
        else:
            turned = drake.RigidTransform(drake.RotationMatrix(self.R_frame_own))
            own = self.plant.AddFrame(drake.FixedOffsetFrame("own", frame, turned))
            joint = drake.BallRpyJoint("pivot", world, own, scene["drag"])
        self.joint = self.plant.AddJoint(joint)
        self.rotors = [self.add_rotor(rotor, lever) for rotor in scene.get("rotors", [])]
        self.plant.mutable_gravity_field().set_gravity_vector(scene["gravity"])
        self.plant.Finalize()

    def slid(self, scene):
        """Return the parent frame of the body's joint: the world's, or that of the last slide.

        One slide without mass is added for each axis along which a body on a table may move.
        """
        frame, height = self.plant.world_frame(), [0.0, 0.0, scene.get("height", 0.0)]
        if any(height):
            frame = self.offset("plane", frame, height)
        for axis in scene.get("slides", []):
            slide = self.plant.AddRigidBody(f"slide-{axis}", drake.SpatialInertia.Zero())
            joint = drake.PrismaticJoint(
                f"slide-{axis}", frame, slide.body_frame(), np.eye(3)[axis]
            )
            self.slides.append(self.plant.AddJoint(joint))
            frame = slide.body_frame()
        return frame

    def add_rotor(self, rotor, lever):
        """Add a rotor to the body, on the joint of its kind of hinge; return the joint.

        Parameters
        ----------
        rotor : the rotor's entry in the scene record
        lever : vector from the body's joint to its com, m, in the scene record's axes, (3,)
        """
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = rotor_tensor(rotor)
        inertia = drake.SpatialInertia.MakeFromCentralInertia(
            rotor["mass"], np.zeros(3), drake.RotationalInertia(xx, yy, zz, xy, xz, yz)
        )
        name = f"rotor-{self.plant.num_joints()}"
        part = self.plant.AddRigidBody(name, inertia).body_frame()
        hub = self.offset(f"hub-{name}", self.body.body_frame(), lever + rotor["place"])
        if rotor["hinge"] == "locked":
            upright = drake.RigidTransform.Identity()
            return self.plant.AddJoint(drake.WeldJoint(name, hub, part, upright))
        joint = self.plant.AddJoint(drake.RevoluteJoint(name, hub, part, rotor["axis"]))
        if rotor["hinge"] == "driven":
            actuator = self.plant.AddJointActuator(f"drive-{name}", joint)
            actuator.set_default_rotor_inertia(drive(rotor))
        return joint

    def offset(self, name, frame, place):
        """Add a frame named `name`, at the position `place` in `frame`, m, (3,); return it."""
        at = drake.RigidTransform(np.array(place))
        return self.plant.AddFrame(drake.FixedOffsetFrame(name, frame, at))

    def restart(self, motion, timestep):
        """Set another motion, and the timestep, s.

        `motion` is a dict with `q`, `omega`, `com`, `velocity` and, with rotors, `spins` as in a
        scene record. A discrete plant must have been built with the same timestep.
        """
        self.timestep, self.taken, self.clock = timestep, 0, 0.0
        self.simulator.get_mutable_context().SetTime(0.0)
        if not self.is_discrete:
            integrator = self.simulator.get_mutable_integrator()
            integrator.set_maximum_step_size(timestep)
            if integrator.get_initial_step_size_target() > timestep:
                integrator.request_initial_step_size_target(timestep)
        joint, context = self.joint, self.context
        if self.is_free:
            joint.SetQuaternion(context, drake.Quaternion(motion["q"]))
            joint.SetTranslation(context, motion["com"])
            joint.set_translational_velocity(context, motion["velocity"])
        else:
            attitude = drake.RotationMatrix(matrix(motion["q"]) @ self.R_frame_own)
            joint.set_angles(context, drake.RollPitchYaw(attitude).vector())
        joint.set_angular_velocity(context, motion["omega"])
        if self.slides:
            self.slide_to(motion)
        for rotor, spin in zip(self.rotors, motion.get("spins", ()), strict=True):
            if rotor.num_velocities():
                rotor.set_angle(context, 0.0)
                rotor.set_angular_rate(context, spin)
        self.simulator.Initialize()
        self.simulator.ResetStatistics()

    def slide_to(self, motion):
        """Set the slides so that the com has the position and velocity of a motion.

        `motion` is a dict with `q`, `omega`, `com` and `velocity` as in a scene record. No other
        coordinate of the plant is set.
        """
        body, context = self.body, self.context
        arm = matrix(motion["q"]) @ body.CalcCenterOfMassInBodyFrame(context)
        place = motion["com"] - arm
        speed = motion["velocity"] - np.cross(motion["omega"], arm)
        for slide in self.slides:
            slide.set_translation(context, slide.translation_axis() @ place)
            slide.set_translation_rate(context, slide.translation_axis() @ speed)

    def motion(self):
        """Return the state as one array, (13 + rotors,), in world axes.

        It has attitude (w x y z), ω (rad/s), com (m), velocity of the com (m/s) and spins (rad/s).
        """
        body, context = self.body, self.context
        pose, moving = body.EvalPoseInWorld(context), body.EvalSpatialVelocityInWorld(context)
        return np.concatenate(
            [
                pose.rotation().ToQuaternion().wxyz(),
                moving.rotational(),
                pose @ body.CalcCenterOfMassInBodyFrame(context),
                body.CalcCenterOfMassTranslationalVelocityInWorld(context),
                [j.get_angular_rate(context) if j.num_velocities() else 0.0 for j in self.rotors],
            ]
        )

    def advance(self, steps):
        """Take `steps` steps in one native call, up to an end time.

        With an integrator, the end time is the sum of the timesteps, added up as Drake does. A
        discrete plant steps at multiples of the timestep, the first at 0; its end time is halfway
        between two multiples. With other end times Drake might take a tiny extra step, or one less.
        """
        self.taken += steps
        until = (self.taken - 0.5) * self.timestep
        if not self.is_discrete:
            for _ in range(steps):
                self.clock += self.timestep
            until = self.clock
        self.simulator.AdvanceTo(until)
