"""A Pinocchio model of one body and its steps, which need `pinocchio` and numpy alone."""

import math

import numpy as np
import pinocchio

from ...world_parts import drive, is_pushed, push, rotor_tensor

#: The classical Runge-Kutta rule (Hairer, Nørsett & Wanner I, II.1). Each stage has its time, in
#: units of the step, and its weight, in sixths.
STAGES = ((0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0))


class World:
    """One body on a free-flyer joint at its com, or on a spherical joint where it is held.

    On a table the spherical joint is on two slides. Rotors are on revolute joints; a locked one is
    part of the body.

    Parameters
    ----------
    scene : the scene's record
    method : name of the method
    timestep : length of the steps, s
    """

    def __init__(self, scene, method, timestep):
        self.scene, self.is_pushed = scene, is_pushed(scene)
        self.step = self.runge_kutta if method == "RK4" else self.semi_implicit
        self.model = pinocchio.Model()
        self.lever = -np.array(scene["arm"] or (0.0, 0.0, 0.0))  # from the joint to the com
        self.is_free, self.slides = scene["arm"] is None, scene.get("slides", [])
        self.height = np.array((0.0, 0.0, scene.get("height", 0.0)))
        self.add_body(scene)
        self.rotors = [self.add_rotor(rotor) for rotor in scene.get("rotors", [])]
        self.model.gravity.linear = np.array(scene["gravity"])
        self.data = self.model.createData()
        moving = 3 if self.is_free else len(self.slides)
        self.q_turning, self.v_turning = slice(moving, moving + 4), slice(moving, moving + 3)
        self.restart(scene, timestep)

    def add_body(self, scene):
        """Add the body and its joint; for a body on a table, add slides before that joint."""
        kind = pinocchio.JointModelFreeFlyer if self.is_free else pinocchio.JointModelSpherical
        parent, at = 0, pinocchio.SE3(np.eye(3), self.height)
        for axis in self.slides:
            slide = pinocchio.JointModelPrismaticUnaligned(np.eye(3)[axis])
            parent = self.model.addJoint(parent, slide, at, f"slide-{axis}")
            at = pinocchio.SE3.Identity()
        self.joint = self.model.addJoint(parent, kind(), at, "top")
        inertia = pinocchio.Inertia(scene["mass"], self.lever, np.diag(scene["moments"]))
        self.model.appendBodyToJoint(self.joint, inertia, pinocchio.SE3.Identity())

    def add_rotor(self, rotor):
        """Add a rotor, given its entry in the scene record; return the number of its joint.

        A locked rotor has no joint and is merged into the body; the number is then 0.
        """
        at = pinocchio.SE3(np.eye(3), self.lever + rotor["place"])
        inertia = pinocchio.Inertia(rotor["mass"], np.zeros(3), rotor_tensor(rotor))
        if rotor["hinge"] == "locked":
            self.model.appendBodyToJoint(self.joint, inertia, at)
            return 0
        hinge = pinocchio.JointModelRevoluteUnaligned(np.array(rotor["axis"]))
        joint = self.model.addJoint(self.joint, hinge, at, f"hinge-{self.model.njoints}")
        self.model.appendBodyToJoint(joint, inertia, pinocchio.SE3.Identity())
        armature = np.array(self.model.armature)
        armature[self.model.joints[joint].idx_v] = drive(rotor)
        self.model.armature = armature
        return joint

    def restart(self, motion, timestep):
        """Set another motion, and the timestep, s.

        `motion` is a dict with `q`, `omega`, `com`, `velocity` and, with rotors, `spins` as in a
        scene record.
        """
        self.timestep = timestep
        w, x, y, z = motion["q"]
        R = pinocchio.Quaternion(np.array((x, y, z, w))).matrix()
        omega, com, velocity = (np.array(motion[key]) for key in ("omega", "com", "velocity"))
        if self.is_free:
            # A free-flyer joint has its velocity in body axes.
            place, speed = com, R.T @ velocity
        else:
            place = (com - R @ self.lever)[self.slides]
            speed = (velocity - np.cross(omega, R @ self.lever))[self.slides]
        spins = [
            spin for spin, joint in zip(motion.get("spins", ()), self.rotors, strict=True) if joint
        ]
        self.q = np.array([*place, x, y, z, w, *(0.0 for _ in spins)])
        self.v = np.array([*speed, *(R.T @ omega), *spins])

    def motion(self):
        """Return the state as one array, (13 + rotors,), in world axes.

        It has attitude (w x y z), ω (rad/s), com (m), velocity of the com (m/s) and spins (rad/s).
        """
        x, y, z, w = self.q[self.q_turning]
        R = pinocchio.Quaternion(self.q[self.q_turning]).matrix()
        omega, arm = R @ self.v[self.v_turning], R @ self.lever
        com, velocity = arm + self.height, np.cross(omega, arm)
        if self.is_free:
            com, velocity = self.q[:3], R @ self.v[:3]
        for number, axis in enumerate(self.slides):
            com[axis] += self.q[number]
            velocity[axis] += self.v[number]
        return np.array([w, x, y, z, *omega, *com, *velocity, *self.spins()])

    def spins(self):
        """Return a list of the rotors' spins, rad/s; that of a locked rotor is 0."""
        joints = self.model.joints
        return [self.v[joints[joint].idx_v] if joint else 0.0 for joint in self.rotors]

    def advance(self, steps):
        """Take `steps` steps one by one, because Pinocchio has no native loop."""
        for _ in range(steps):
            self.step()

    def semi_implicit(self):
        """Take a semi-implicit Euler step: the new velocities move the coordinates.

        Pinocchio's examples step in this way.
        """
        self.v = self.v + self.timestep * self.acceleration(self.q, self.v)
        self.q = pinocchio.integrate(self.model, self.q, self.timestep * self.v)

    def runge_kutta(self):
        """Take a classical Runge-Kutta step.

        The quaternion is integrated as four plain numbers, and normalised in each stage.
        """
        h, q, v = self.timestep, self.q, self.v
        q_rate, v_rate = np.zeros(len(q)), np.zeros(len(v))
        q_gain, v_gain = np.zeros(len(q)), np.zeros(len(v))
        for at, weight in STAGES:
            stage_q, stage_v = self.normalised(q + at * h * q_rate), v + at * h * v_rate
            q_rate = self.rate(stage_q, stage_v)
            v_rate = self.acceleration(stage_q, stage_v)
            q_gain += weight * q_rate
            v_gain += weight * v_rate
        self.q, self.v = self.normalised(q + h / 6 * q_gain), v + h / 6 * v_gain

    def rate(self, q, v):
        """Return the time derivative of the coordinates q, given q and the velocities v.

        The derivative of the quaternion is ½ q (0, ω).
        """
        # Python's floats: single numbers of numpy would take several times as long.
        (x, y, z, w), (a, b, c) = q[self.q_turning].tolist(), v[self.v_turning].tolist()
        turning = (
            w * a + y * c - z * b,
            w * b + z * a - x * c,
            w * c + x * b - y * a,
            -x * a - y * b - z * c,
        )
        moving = v[: self.v_turning.start]
        if self.is_free:
            moving = pinocchio.Quaternion(q[self.q_turning]).matrix() @ moving
        spins = v[self.v_turning.stop :]
        return np.array([*moving, *(part / 2 for part in turning), *spins])

    def acceleration(self, q, v):
        """Return the time derivative of the velocities v, by the articulated-body algorithm.

        `q` are the coordinates. The scene's torques are included.
        """
        torque = np.zeros(len(v))
        if self.is_pushed:
            R = pinocchio.Quaternion(q[self.q_turning]).matrix()
            torque[self.v_turning] = R.T @ push(self.scene, R, R @ v[self.v_turning])
        return pinocchio.aba(self.model, self.data, q, v, torque)

    def normalised(self, q):
        """Scale the quaternion in the coordinates q to norm 1, in place; return q."""
        turning = q[self.q_turning]
        turning /= math.sqrt(turning @ turning)
        return q
