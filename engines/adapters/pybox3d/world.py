"""A world of one body, which needs `pybox3d` and numpy alone."""

import numpy as np
import pybox3d

from ...world_parts import is_pushed, matrix, push


def wxyz(q):
    """Return a quaternion of pybox3d as an array, w x y z, (4,)."""
    return np.array((q.w, q.x, q.y, q.z))


def xyz(v):
    """Return a vector of pybox3d as an array, (3,)."""
    return np.array((v.x, v.y, v.z))


def half_extents(mass, moments):
    """Return half the lengths of a uniform box's edges, m, (3,), given its mass and moments.

    The mass is in kg. The moments, kg m², (3,), are about the axes through the box's centre that
    are parallel to its edges.
    """
    squares = np.sum(moments) / 2 - np.array(moments)
    return np.sqrt(3 / mass * np.maximum(squares, 0.0))


class World:
    """A box with its centre at the com, and a spherical joint at the pivot if there is one.

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
        motion : a dict with `q`, `omega`, `com` and `velocity` as in a scene record
        timestep : length of the steps from now on, s
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
            # Without this filter the fixed body and the box would collide.
            self.world.add_filter_joint(ground, self.body)

    def motion(self):
        """Return the state as one array, (13,), in world axes.

        It has attitude (w x y z), ω (rad/s), com (m) and velocity of the com (m/s).
        """
        body = self.body
        vectors = body.angular_velocity, body.position, body.linear_velocity
        return np.concatenate([wxyz(body.orientation), *map(xyz, vectors)])

    def push(self):
        """Apply the scene's torques and drag for the next step, as a couple of forces.

        Box3D clears the forces after the step.
        """
        place = xyz(self.body.position)
        torque = push(
            self.scene, matrix(wxyz(self.body.orientation)), xyz(self.body.angular_velocity)
        )
        across = np.cross(torque, np.eye(3)[np.argmin(np.abs(torque))])
        if not across.any():
            return
        # The arm is at least as long as the com is far from the origin: the com's coordinates are
        # rounded, and this would change a short arm.
        arm = across / np.linalg.norm(across) * (1 + np.linalg.norm(place))
        force = np.cross(torque, arm) / (2 * arm @ arm)
        self.body.apply_force(tuple(force), tuple(place + arm))
        self.body.apply_force(tuple(-force), tuple(place - arm))

    def advance(self, steps):
        """Take `steps` steps."""
        pushed = is_pushed(self.scene)
        for _ in range(steps):
            if pushed:
                self.push()
            self.world.step(self.timestep)
