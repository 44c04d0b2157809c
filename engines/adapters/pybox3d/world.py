"""A world of one body, which needs `pybox3d` and numpy alone."""

import numpy as np
import pybox3d

from ...world_parts import is_pushed, matrix, push


def wxyz(q):
    """Return one of pybox3d's quaternions as numbers, w x y z, (4,)."""
    return np.array((q.w, q.x, q.y, q.z))


def xyz(v):
    """Return one of pybox3d's vectors as numbers, (3,)."""
    return np.array((v.x, v.y, v.z))


def half_extents(mass, moments):
    """Return half the edges, m, (3,), of the uniform box with a mass, kg, and moments, kg m²."""
    squares = np.sum(moments) / 2 - np.array(moments)
    return np.sqrt(3 / mass * np.maximum(squares, 0.0))


class World:
    """A box at the com of the body, and for a pivot a spherical joint to a fixed point.

    Parameters
    ----------
    scene : the scene's record
    method : name of the method
    timestep : s
    """

    def __init__(self, scene, method, timestep):
        self.scene, self.method = scene, method
        self.restart(scene, timestep)

    def restart(self, motion, timestep):
        """Build a new world with another motion, keyed as in the scene's record, and timestep, s.

        Nothing of earlier steps is left.
        """
        self.scene = scene = self.scene | motion
        self.timestep = timestep
        self.world = pybox3d.World(gravity=tuple(scene["gravity"]))
        if self.method != "default":
            self.world.sleeping_enabled = False
        box = tuple(half_extents(scene["mass"], scene["moments"]))
        self.body = self.world.add_body(pybox3d.RigidBody(scene["com"], box, mass=scene["mass"]))
        w, x, y, z = scene["q"]
        self.body.orientation = pybox3d.Quat(x, y, z, w)
        self.body.linear_velocity = tuple(scene["velocity"])
        self.body.angular_velocity = tuple(scene["omega"])
        self.joint = None
        if scene["arm"]:
            nowhere = (0.0, 0.0, 0.0)
            ground = self.world.add_body(pybox3d.RigidBody(nowhere, nowhere))
            self.joint = self.world.add_spherical_joint(
                ground, self.body, anchor_b=tuple(scene["arm"])
            )
            # Without the filter the fixed point and the box collide.
            self.world.add_filter_joint(ground, self.body)

    def motion(self):
        """Return attitude, w x y z, ω, com and its velocity, in world axes, (13,)."""
        body = self.body
        vectors = body.angular_velocity, body.position, body.linear_velocity
        return np.concatenate([wxyz(body.orientation), *map(xyz, vectors)])

    def push(self):
        """Add the torque, N m, world axes, as a couple of forces, which the next step clears."""
        place = xyz(self.body.position)
        torque = push(
            self.scene, matrix(wxyz(self.body.orientation)), xyz(self.body.angular_velocity)
        )
        across = np.cross(torque, np.eye(3)[np.argmin(np.abs(torque))])
        if not across.any():
            return
        # The couple's arm is as long as the com is far away, or else rounding of the com's place
        # would change it.
        arm = across / np.linalg.norm(across) * (1 + np.linalg.norm(place))
        force = np.cross(torque, arm) / (2 * arm @ arm)
        self.body.apply_force(tuple(force), tuple(place + arm))
        self.body.apply_force(tuple(-force), tuple(place - arm))

    def advance(self, steps):
        """Take steps."""
        pushed = is_pushed(self.scene)
        for _ in range(steps):
            if pushed:
                self.push()
            self.world.step(self.timestep)
