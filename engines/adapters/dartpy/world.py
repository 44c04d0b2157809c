"""A DART world of one body, which needs `dartpy` and numpy alone."""

import dartpy as dart
import numpy as np

from ...world_parts import is_pushed, matrix, rotation_vector


class World:
    """One body, on a ball joint at its pivot or on a free joint at its com."""

    def __init__(self, scene, method, timestep):
        self.scene, self.is_pushed = scene, is_pushed(scene)
        self.world = dart.simulation.World("world")
        self.world.setGravity(np.array(scene["gravity"]))
        if method != "default":
            options = self.world.getDeactivationOptions()
            options.mEnabled = False
            self.world.setDeactivationOptions(options)
        self.is_free = scene["arm"] is None
        skeleton = dart.dynamics.Skeleton("top")
        create = f"create{'Free' if self.is_free else 'Ball'}JointAndBodyNodePair"
        self.joint, self.body = getattr(skeleton, create)()
        lever = -np.array(scene["arm"] or (0.0, 0.0, 0.0))  # from the joint to the com
        inertia = dart.dynamics.Inertia(scene["mass"], lever, np.diag(scene["moments"]))
        self.body.setInertia(inertia)
        for k in range(3):
            self.joint.setDampingCoefficient(k, scene["drag"])
        self.world.addSkeleton(skeleton)
        self.restart(scene, timestep)

    def restart(self, motion, timestep):
        """Set another motion and timestep."""
        self.world.setTimeStep(timestep)
        R = matrix(motion["q"])
        omega = R.T @ np.array(motion["omega"])
        if not self.is_free:
            self.joint.setPositions(rotation_vector(motion["q"]))
            self.joint.setVelocities(omega)
            return
        self.joint.setTransform(dart.math.Isometry3(R, np.array(motion["com"])))
        velocity = np.array([*omega, *(R.T @ np.array(motion["velocity"]))])
        self.joint.setSpatialVelocity(velocity, dart.dynamics.Frame.World(), self.body)

    def motion(self):
        """Attitude, w x y z, ω, com and its velocity, world axes."""
        body = self.body
        attitude = body.getWorldTransform()
        omega = attitude.rotation() @ body.getSpatialVelocity()[:3]
        motion = omega, body.getCOM(), body.getCOMLinearVelocity()
        return np.concatenate([attitude.quaternion().wxyz(), *motion])

    def push(self):
        """Set the torques, which DART clears after each step."""
        self.body.clearExternalForces()
        self.body.addExtTorque(np.array(self.scene["torque_body"]), True)
        self.body.addExtTorque(np.array(self.scene["torque_world"]), False)

    def advance(self, steps):
        """Take steps one by one."""
        for _ in range(steps):
            if self.is_pushed:
                self.push()
            self.world.step()
