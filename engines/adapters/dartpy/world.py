"""A DART world of one body, which needs `dartpy` and numpy alone."""

import dartpy as dart
import numpy as np

from ...world_parts import is_pushed, matrix, rotation_vector, rotor_tensor

#: Mass of the link that slides on the table, in units of the body's mass: DART accepts no link
#: without mass.
LIGHT = 2.0**-80


class World:
    """One body on a free joint at its com, or on a ball joint where it is held.

    On a table the ball joint is on a planar slide. Rotors are on revolute joints; locked ones are
    welded to the body.

    Parameters
    ----------
    scene : the scene's record
    method : name of the method
    timestep : length of the steps, s
    """

    def __init__(self, scene, method, timestep):
        self.scene, self.is_pushed = scene, is_pushed(scene)
        self.world = dart.simulation.World("world")
        self.world.setGravity(np.array(scene["gravity"]))
        if method != "default":
            options = self.world.getDeactivationOptions()
            options.mEnabled = False
            self.world.setDeactivationOptions(options)
        self.is_free, self.slide = scene["arm"] is None, None
        self.skeleton = dart.dynamics.Skeleton("top")
        create = f"create{'Free' if self.is_free else 'Ball'}JointAndBodyNodePair"
        self.joint, self.body = getattr(self.skeleton, create)(*self.slid(scene))
        self.lever = -np.array(scene["arm"] or (0.0, 0.0, 0.0))  # from the joint to the com
        inertia = dart.dynamics.Inertia(scene["mass"], self.lever, np.diag(scene["moments"]))
        self.body.setInertia(inertia)
        for k in range(3):
            self.joint.setDampingCoefficient(k, scene["drag"])
        self.rotors = [self.add_rotor(rotor) for rotor in scene.get("rotors", [])]
        self.world.addSkeleton(self.skeleton)
        self.restart(scene, timestep)

    def slid(self, scene):
        """Return the parent node of the body's joint as a tuple of one node.

        The tuple is empty if the parent is the world. For a body on a table a slide in the table's
        plane and a node on it, with next to no mass, are added; this node is the parent.
        """
        if "slides" not in scene:
            return ()
        self.slide, node = self.skeleton.createTranslationalJoint2DAndBodyNodePair()
        at = dart.math.Isometry3(np.eye(3), np.array([0.0, 0.0, scene["height"]]))
        self.slide.setTransformFromParentBodyNode(at)
        tensor = LIGHT * min(scene["moments"]) * np.eye(3)
        node.setInertia(dart.dynamics.Inertia(LIGHT * scene["mass"], np.zeros(3), tensor))
        return (node,)

    def add_rotor(self, rotor):
        """Add a rotor, given its entry in the scene record; return its joint and its body node."""
        kind = "Weld" if rotor["hinge"] == "locked" else "Revolute"
        joint, node = getattr(self.skeleton, f"create{kind}JointAndBodyNodePair")(self.body)
        at = dart.math.Isometry3(np.eye(3), self.lever + rotor["place"])
        joint.setTransformFromParentBodyNode(at)
        tensor = rotor_tensor(rotor)
        node.setInertia(dart.dynamics.Inertia(rotor["mass"], np.zeros(3), tensor))
        if kind == "Revolute":
            joint.setAxis(np.array(rotor["axis"]))
        if rotor["hinge"] == "driven":
            # The joint's command is an angular acceleration, which is 0 by default.
            joint.setActuatorType(dart.dynamics.ActuatorType.ACCELERATION)
        return joint, node

    def spins(self):
        """Return a list of the rotors' spins, rad/s; that of a locked rotor is 0."""
        return [joint.getVelocity(0) if joint.getNumDofs() else 0.0 for joint, _ in self.rotors]

    def restart(self, motion, timestep):
        """Set another motion, and the timestep, s.

        `motion` has the keys of a scene record that state the start: `q`, `omega`, `com`,
        `velocity` and, with rotors, `spins`.
        """
        self.world.setTimeStep(timestep)
        for (joint, _), spin in zip(self.rotors, motion.get("spins", ()), strict=True):
            if joint.getNumDofs():
                joint.setPosition(0, 0.0)
                joint.setVelocity(0, spin)
        R = matrix(motion["q"])
        omega = R.T @ np.array(motion["omega"])
        if not self.is_free:
            self.joint.setPositions(rotation_vector(motion["q"]))
            self.joint.setVelocities(omega)
            if self.slide:
                arm = R @ self.lever
                self.slide.setPositions((motion["com"] - arm)[:2])
                self.slide.setVelocities((motion["velocity"] - np.cross(motion["omega"], arm))[:2])
            return
        self.joint.setTransform(dart.math.Isometry3(R, np.array(motion["com"])))
        velocity = np.array([*omega, *(R.T @ np.array(motion["velocity"]))])
        self.joint.setSpatialVelocity(velocity, dart.dynamics.Frame.World(), self.body)

    def motion(self):
        """Return the state as one array, (13 + rotors,), in world axes.

        It has attitude (w x y z), ω (rad/s), com (m), velocity of the com (m/s) and spins (rad/s).
        """
        body = self.body
        attitude = body.getWorldTransform()
        omega = attitude.rotation() @ body.getSpatialVelocity()[:3]
        motion = omega, body.getCOM(), body.getCOMLinearVelocity(), self.spins()
        return np.concatenate([attitude.quaternion().wxyz(), *motion])

    def push(self):
        """Apply the scene's torques to the body for the next step, after which DART clears them."""
        self.body.clearExternalForces()
        self.body.addExtTorque(np.array(self.scene["torque_body"]), True)
        self.body.addExtTorque(np.array(self.scene["torque_world"]), False)

    def advance(self, steps):
        """Take `steps` steps one by one."""
        for _ in range(steps):
            if self.is_pushed:
                self.push()
            self.world.step()
