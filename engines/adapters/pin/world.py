"""A Pinocchio model of one body and its steps, which need `pinocchio` and numpy alone."""

import math

import numpy as np
import pinocchio

from ...world_parts import is_pushed, push

#: The classical Runge-Kutta rule (Hairer, Nørsett & Wanner I, II.1): nodes of the stages, and their
#: weights in sixths.
STAGES = ((0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0))


class World:
    """One body, on a spherical joint at its pivot or on a free-flyer joint at its com."""

    def __init__(self, scene, method, timestep):
        self.scene, self.is_pushed = scene, is_pushed(scene)
        self.step = self.runge_kutta if method == "RK4" else self.semi_implicit
        self.model = pinocchio.Model()
        self.lever = -np.array(scene["arm"] or (0.0, 0.0, 0.0))  # from the joint to the com
        self.is_free = scene["arm"] is None
        kind = pinocchio.JointModelFreeFlyer if self.is_free else pinocchio.JointModelSpherical
        upright = pinocchio.SE3.Identity()
        joint = self.model.addJoint(0, kind(), upright, "top")
        inertia = pinocchio.Inertia(scene["mass"], self.lever, np.diag(scene["moments"]))
        self.model.appendBodyToJoint(joint, inertia, upright)
        self.model.gravity.linear = np.array(scene["gravity"])
        self.data = self.model.createData()
        self.restart(scene, timestep)

    def restart(self, motion, timestep):
        """Set another motion and timestep."""
        self.timestep = timestep
        w, x, y, z = motion["q"]
        self.q = np.array((x, y, z, w))
        R = pinocchio.Quaternion(self.q).matrix()
        self.v = R.T @ np.array(motion["omega"])
        if self.is_free:
            # The position of the com, and its velocity in the body's axes, come first.
            self.q = np.array([*motion["com"], *self.q])
            self.v = np.array([*(R.T @ np.array(motion["velocity"])), *self.v])

    def motion(self):
        """Attitude, w x y z, ω, com and its velocity, world axes."""
        x, y, z, w = self.q[-4:]
        R = pinocchio.Quaternion(self.q[-4:]).matrix()
        omega = R @ self.v[-3:]
        com = self.q[:3] if self.is_free else R @ self.lever
        velocity = R @ self.v[:3] if self.is_free else np.cross(omega, com)
        return np.array([w, x, y, z, *omega, *com, *velocity])

    def advance(self, steps):
        """Take steps one by one: Pinocchio has no native loop."""
        for _ in range(steps):
            self.step()

    def semi_implicit(self):
        """Step as Pinocchio's examples do."""
        self.v = self.v + self.timestep * self.acceleration(self.q, self.v)
        self.q = pinocchio.integrate(self.model, self.q, self.timestep * self.v)

    def runge_kutta(self):
        """Step position, quaternion (as plain numbers) and velocity."""
        h, q, v = self.timestep, self.q, self.v
        q_rate, v_rate = np.zeros(len(q)), np.zeros(len(v))
        q_gain, v_gain = np.zeros(len(q)), np.zeros(len(v))
        for at, weight in STAGES:
            stage_q, stage_v = normalised(q + at * h * q_rate), v + at * h * v_rate
            q_rate = self.rate(stage_q, stage_v)
            v_rate = self.acceleration(stage_q, stage_v)
            q_gain += weight * q_rate
            v_gain += weight * v_rate
        self.q, self.v = normalised(q + h / 6 * q_gain), v + h / 6 * v_gain

    def rate(self, q, v):
        """Time derivative of the coordinates; of the quaternion, half its product with ω."""
        # As Python's floats: numpy's cost several times as much one by one.
        (x, y, z, w), (a, b, c) = q[-4:].tolist(), v[-3:].tolist()
        turning = (
            w * a + y * c - z * b,
            w * b + z * a - x * c,
            w * c + x * b - y * a,
            -x * a - y * b - z * c,
        )
        moving = pinocchio.Quaternion(q[-4:]).matrix() @ v[:-3] if self.is_free else ()
        return np.array([*moving, *(part / 2 for part in turning)])

    def acceleration(self, q, v):
        """The acceleration by the articulated-body algorithm."""
        torque = np.zeros(len(v))
        if self.is_pushed:
            R = pinocchio.Quaternion(q[-4:]).matrix()
            torque[-3:] = R.T @ push(self.scene, R, R @ v[-3:])
        return pinocchio.aba(self.model, self.data, q, v, torque)


def normalised(q):
    """Coordinates with a quaternion of norm 1, x y z w, at their end."""
    q[-4:] /= math.sqrt(q[-4:] @ q[-4:])
    return q
