"""A Rapier world of one body, which needs `rapier3d` and numpy alone."""

import numpy as np
import rapier3d

from ...world_parts import is_pushed, matrix, push, quaternion, rotor_tensor

#: Gain of a drive, so large that the spin does not change.
FIRM = 1e9
#: Natural frequency of the spring that a joint is, Hz. With Rapier's default, 1e6, the spring gives
#: way in steps of a microsecond.
RIGID = 1e12


def wxyz(q):
    """Return a quaternion of Rapier as an array, w x y z, (4,)."""
    return np.array((q.w, q.i, q.j, q.k))


def xyz(v):
    """Return a vector of Rapier as an array, (3,)."""
    return np.array((v.x, v.y, v.z))


def count(mask):
    """Return the number of axes in a joint's mask, such as that of the axes that it locks."""
    return mask.bits.bit_count()


def is_soft(joint):
    """Whether a joint's spring is softer than `RIGID`, so that it gives way in short steps."""
    return joint.data.softness.natural_frequency < RIGID / 2


class World:
    """One body, a joint that holds it if it is not free, and its rotors with their hinges.

    Parameters
    ----------
    scene : the scene's record
    method : name of the method
    timestep : length of the steps, s
    """

    def __init__(self, scene, method, timestep):
        self.scene, self.method = scene, method
        self.restart(scene, timestep)

    def restart(self, motion, timestep):
        """Build a new world at another motion, so that nothing of earlier steps is left.

        Parameters
        ----------
        motion : a dict with `q`, `omega`, `com`, `velocity` and, with rotors, `spins` as in a scene
            record
        timestep : length of the steps from now on, s
        """
        self.scene = scene = self.scene | motion
        self.quarantined = False
        self.world = rapier3d.PhysicsWorld(gravity=tuple(scene["gravity"]))
        self.world.integration_parameters.dt = timestep
        upright = rapier3d.Rotation3(1.0, 0.0, 0.0, 0.0)
        self.body, carrier = self.add_body(scene, scene["moments"], upright)
        self.joint, self.rotors = None, []
        if scene["arm"]:
            ground = self.world.add_body(rapier3d.RigidBody.fixed())
            locked = sum(1 << axis for axis in range(3) if axis not in scene.get("slides", ()))
            joint = rapier3d.GenericJoint.builder(rapier3d.JointAxesMask(locked))
            joint = joint.local_anchor1((0.0, 0.0, scene.get("height", 0.0)))
            self.joint = self.add_joint(ground, carrier, joint.local_anchor2(tuple(scene["arm"])))
        for rotor, spin in zip(scene.get("rotors", ()), scene.get("spins", ()), strict=True):
            self.rotors.append(self.add_rotor(carrier, rotor, spin))

    def add_body(self, motion, moments, frame):
        """Add a body with its com at its origin; return Rapier's body and its handle.

        Parameters
        ----------
        motion : a dict with `mass`, `q`, `omega`, `com` and `velocity` as in a scene record
        moments : principal moments, kg m², (3,)
        frame : Rapier's rotation from the principal axes to the body's axes
        """
        mass = rapier3d.MassProperties((0.0, 0.0, 0.0), motion["mass"], tuple(moments), frame)
        described = rapier3d.RigidBody.dynamic().additional_mass_properties(mass)
        if self.method != "default":
            described = described.can_sleep(False).allow_fast_rotation(True)
        handle = self.world.add_body(described)
        body = self.world.rigid_bodies[handle]
        attitude = rapier3d.Rotation3(*motion["q"])
        body.position = rapier3d.Isometry3(tuple(motion["com"]), attitude)
        body.linvel = tuple(motion["velocity"])
        body.angvel = tuple(motion["omega"])
        # Without this call its mass would read 0 before the first step.
        body.recompute_mass_properties_from_colliders(self.world.colliders)
        return body, handle

    def add_rotor(self, carrier, rotor, spin):
        """Add a rotor whose axes coincide with its carrier's; return the rotor's body and joint.

        Parameters
        ----------
        carrier : handle of the body that carries the rotor
        rotor : the rotor's entry in the scene record
        spin : angular velocity about the rotor's axis, relative to the carrier, rad/s
        """
        scene, hinge = self.scene, rotor["hinge"]
        R = matrix(scene["q"])
        arm, axis = R @ rotor["place"], R @ rotor["axis"]
        motion = scene | {
            "mass": rotor["mass"],
            "com": scene["com"] + arm,
            "velocity": scene["velocity"] + np.cross(scene["omega"], arm),
            "omega": scene["omega"] + spin * axis,
        }
        moments, frame = np.linalg.eigh(rotor_tensor(rotor))
        frame[:, 0] *= np.linalg.det(frame)
        body, handle = self.add_body(motion, moments, rapier3d.Rotation3(*quaternion(frame)))
        masks = rapier3d.JointAxesMask
        locked = masks.LOCKED_FIXED_AXES if hinge == "locked" else masks.LOCKED_REVOLUTE_AXES
        joint = rapier3d.GenericJoint.builder(locked).local_anchor1(tuple(rotor["place"]))
        joint = joint.local_axis1(tuple(rotor["axis"])).local_axis2(tuple(rotor["axis"]))
        if hinge == "driven":
            joint = joint.motor_velocity(rapier3d.JointAxis.ANG_X, spin, FIRM)
        return body, self.add_joint(carrier, handle, joint)

    def add_joint(self, parent, child, described):
        """Add a joint between two bodies; return it.

        Parameters
        ----------
        parent, child : handles of the two bodies
        described : Rapier's builder of the joint
        """
        if self.method != "default":
            described = described.softness(rapier3d.SpringCoefficients(RIGID, 1.0))
        number = self.world.impulse_joints.insert(parent, child, described.build())
        return self.world.impulse_joints.get(number)

    def joints(self):
        """Return a list of joints: that which holds the body, if any, then those of the rotors."""
        return [self.joint] * (self.joint is not None) + [joint for _, joint in self.rotors]

    def motion(self):
        """Return the state as one array, (13 + rotors,), in world axes.

        It has attitude (w x y z), ω (rad/s), com (m), velocity of the com (m/s) and spins (rad/s).
        """
        body = self.body
        q, omega = wxyz(body.rotation), xyz(body.angvel)
        spun = [xyz(rotor.angvel) - omega for rotor, _ in self.rotors]
        axes = [matrix(q) @ rotor["axis"] for rotor in self.scene.get("rotors", ())]
        spins = [axis @ turned for axis, turned in zip(axes, spun, strict=True)]
        return np.concatenate([q, omega, xyz(body.center_of_mass), xyz(body.linvel), spins])

    def push(self):
        """Apply the sum of the scene's torques and drag to the body; return it.

        It is computed from the present state, N m, world axes, (3,). Rapier applies it in all
        steps until it is reset.
        """
        rotation = matrix(wxyz(self.body.rotation))
        torque = push(self.scene, rotation, xyz(self.body.angvel))
        self.body.reset_torques()
        self.body.add_torque(tuple(torque.tolist()))
        return torque

    def advance(self, steps):
        """Take `steps` steps."""
        pushed = is_pushed(self.scene)
        for _ in range(steps):
            if pushed:
                self.push()
            self.world.step()
            # Rapier quarantines a body whose numbers are not finite, and reports it after the step.
            self.quarantined |= not self.world.quarantine.is_empty()
