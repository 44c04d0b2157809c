"""A Rapier world of one body, which needs `rapier3d` and numpy alone."""

import numpy as np
import rapier3d

from ...world_parts import is_pushed, matrix, push


def wxyz(q):
    """A quaternion of Rapier's as numbers."""
    return np.array((q.w, q.i, q.j, q.k))


def xyz(v):
    """A vector of Rapier's as numbers."""
    return np.array((v.x, v.y, v.z))


class World:
    """One body, and for a pivot the joint that holds it."""

    def __init__(self, scene, method, timestep):
        self.scene = scene
        self.quarantined = False
        self.world = rapier3d.PhysicsWorld(gravity=tuple(scene["gravity"]))
        upright = rapier3d.Rotation3(1.0, 0.0, 0.0, 0.0)
        mass = rapier3d.MassProperties(
            (0.0, 0.0, 0.0), scene["mass"], tuple(scene["moments"]), upright
        )
        described = rapier3d.RigidBody.dynamic().additional_mass_properties(mass)
        if method != "default":
            described = described.can_sleep(False).allow_fast_rotation(True)
        handle = self.world.add_body(described)
        self.body = self.world.rigid_bodies[handle]
        self.joint = None
        if scene["arm"]:
            anchored = rapier3d.SphericalJoint.builder().local_anchor2(tuple(scene["arm"]))
            ground = self.world.add_body(rapier3d.RigidBody.fixed())
            number = self.world.impulse_joints.insert(ground, handle, anchored.build())
            self.joint = self.world.impulse_joints.get(number)
        self.restart(scene, timestep)

    def restart(self, motion, timestep):
        """Set another motion and timestep."""
        self.world.integration_parameters.dt = timestep
        attitude = rapier3d.Rotation3(*motion["q"])
        self.body.position = rapier3d.Isometry3(tuple(motion["com"]), attitude)
        self.body.linvel = tuple(motion["velocity"])
        self.body.angvel = tuple(motion["omega"])
        # Until then its mass reads 0.
        self.body.recompute_mass_properties_from_colliders(self.world.colliders)

    def motion(self):
        """Attitude, w x y z, ω, com and its velocity, world axes."""
        body = self.body
        vectors = xyz(body.angvel), xyz(body.center_of_mass), xyz(body.linvel)
        return np.concatenate([wxyz(body.rotation), *vectors])

    def push(self):
        """Set the torque, which Rapier keeps until it is reset; returns it, N m, world axes."""
        rotation = matrix(wxyz(self.body.rotation))
        torque = push(self.scene, rotation, xyz(self.body.angvel))
        self.body.reset_torques()
        self.body.add_torque(tuple(torque.tolist()))
        return torque

    def advance(self, steps):
        """Take steps."""
        pushed = is_pushed(self.scene)
        for _ in range(steps):
            if pushed:
                self.push()
            self.world.step()
            # It stops a body whose numbers are not finite, and says so only after that step.
            self.quarantined |= not self.world.quarantine.is_empty()
