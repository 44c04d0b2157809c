"""An Exudyn system of one body and its rotors, which needs `exudyn` and numpy alone."""

from collections import namedtuple
from functools import reduce

import exudyn
import exudyn.itemInterface
import numpy as np

from ...world_parts import matrix, quaternion, rotation_vector, rotor_tensor

items = exudyn.itemInterface
AS_SHIPPED = "GeneralizedAlpha"
#: Integrators that solve for the accelerations at the end of a step.
IMPLICIT = (AS_SHIPPED, "TrapezoidalIndex2")
#: Relative and absolute tolerance of Newton's iteration; Exudyn's defaults are 1e-8 and 1e-10.
NEWTON_TOLERANCE = 1e-13
OF_TRAPEZOIDAL_RULE = {
    # Exudyn's own SolveDynamic sets these two for the trapezoidal rule.
    "generalizedAlpha.useIndex2Constraints": True,
    "generalizedAlpha.useNewmark": True,
    # Solved to round-off with a new Jacobian each step, so that a step depends on the state alone.
    "newton.relativeTolerance": NEWTON_TOLERANCE,
    "newton.absoluteTolerance": NEWTON_TOLERANCE,
    "newton.useModifiedNewton": False,
    # A rotor that turns by a radian a step takes more iterations than the default of 25.
    "newton.maxIterations": 100,
}
#: Rounding error allowed in the residual of a rotor, relative to the size of its terms, which are
#: the torque ω x I ω and a joint's force. With 64 in place of 256 the solver gave up on a rotor at
#: 600 rad/s on a table.
ROUNDING = 256 * float(np.finfo(float).eps)
#: The three rotations that the node's axes may have relative to the body's: cyclic orders of the
#: same axes.
TURNED = [np.roll(np.eye(3), k, axis=0) for k in range(3)]
#: Indices of the entries of an inertia tensor, in the order in which Exudyn's objects take them.
ENTRIES = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))

#: A rotor in the system: the numbers of its node, object, joint and drive, then its position from
#: the com of the body, m, and its axis, both in the axes of the record. The drive is None if the
#: hinge is free or locked.
Rotor = namedtuple("Rotor", "node body joint drive place axis")


def settings(solver):
    """Return Exudyn's `SimulationSettings` for the solver of a given name.

    Only the solver as shipped is left free to halve steps that fail to converge.
    """
    own = OF_TRAPEZOIDAL_RULE if solver == "TrapezoidalIndex2" else {}
    steady = {} if solver == AS_SHIPPED else {"adaptiveStep": False}
    simulation = exudyn.SimulationSettings()
    simulation.solution.file.write = False
    simulation.timeIntegration.numberOfSteps = 1
    simulation.timeIntegration.solverType = getattr(exudyn.DynamicSolverType, solver)
    for name, value in (own | steady).items():
        *group, setting = name.split(".")
        setattr(reduce(getattr, group, simulation.timeIntegration), setting, value)
    return simulation


class World:
    """One body on a Lie-group node, held by constraints on coordinates; its rotors are on joints.

    Explicit solvers eliminate constraints wrongly for an object whose com is not at its node. So a
    body on a pivot has its node there, and its object states the pivot as its com and the tensor
    about the pivot; gravity is a force on a marker at the true com. A body on a table has its node
    at the tip, and its object states the true com. Were another point constrained, the constraint's
    first forces would be wrong, and the trapezoidal rule would oscillate about the right ones.

    Parameters
    ----------
    scene : the scene's record
    method : name of the method
    timestep : length of the steps, s
    """

    def __init__(self, scene, method, timestep):
        self.as_shipped = method == "default"
        solver = AS_SHIPPED if self.as_shipped else method
        self.is_free, self.gravity = scene["arm"] is None, np.array(scene["gravity"])
        self.scene, self.R_axes_node = scene, None
        self.kept_axes = [k for k in range(3) if k not in scene.get("slides", ())]
        self.container = exudyn.SystemContainer()
        self.settings = settings(solver)
        self.kind = "ImplicitSecondOrder" if solver in IMPLICIT else "Explicit"
        self.restart(scene, timestep)

    def face(self, R_world_axes):
        """Choose the axes of the body's node by the attitude; rebuild the system if they change.

        Exudyn composes rotation vectors with an arc cosine, which loses half the digits of a small
        vector: in a run that started along the world's axes, rotations of less than 1.5e-8 rad a
        step were lost. So the node's axes are the body's axes in the cyclic order that is turned
        furthest from the world's axes at the start. The errors of joints depend on these axes, so
        every restart chooses them anew, as a first start does.

        Parameters
        ----------
        R_world_axes : the attitude of the scene record's axes at the start, (3, 3)
        """
        starts = [np.trace(R_world_axes @ turned) for turned in TURNED]
        best = TURNED[int(np.argmin(np.abs(starts)))]
        if best is self.R_axes_node:
            return
        if self.R_axes_node is not None:
            self.close()
        self.R_axes_node = best
        self.system = self.container.AddSystem()
        self.assemble(self.scene)
        self.solver = getattr(exudyn, f"MainSolver{self.kind}")()
        self.system.Assemble()

    def close(self):
        """Finalize the solver, and remove the system."""
        self.solver.FinalizeSolver(self.system, self.settings)
        self.container.Reset()

    def assemble(self, scene):
        """Add the body of a scene record to the system, with its constraints, loads and rotors."""
        system, R = self.system, self.R_axes_node
        lever = -np.array(scene["arm"] or (0.0, 0.0, 0.0))  # from the node to the com
        about_node = scene["mass"] * (lever @ lever * np.eye(3) - np.outer(lever, lever))
        of_node = R.T @ (np.diag(scene["moments"]) + about_node) @ R
        self.node, self.body, self.com = self.add_body(scene, of_node, R.T @ lever)
        if not self.is_free:
            self.hold()
        whole = system.AddMarker(items.MarkerBodyRigid(bodyNumber=self.body))
        torque_node = R.T @ np.array(scene["torque_body"])
        for torque, turns in ((torque_node, True), (scene["torque_world"], False)):
            if np.any(torque):
                system.AddLoad(
                    items.LoadTorqueVector(
                        markerNumber=whole, loadVector=[*torque], bodyFixed=turns
                    )
                )
        if scene["drag"]:
            still = system.AddMarker(
                items.MarkerBodyRigid(bodyNumber=system.AddObject(items.ObjectGround()))
            )
            damping = np.diag([0.0] * 3 + [scene["drag"]] * 3)
            system.AddObject(
                items.ObjectConnectorRigidBodySpringDamper(
                    markerNumbers=[still, whole], damping=damping
                )
            )
        self.rotors = [self.add_rotor(rotor, lever) for rotor in scene.get("rotors", [])]

    def add_body(self, part, tensor, com):
        """Add a body and its weight; return the numbers of its node, object and marker at the com.

        Parameters
        ----------
        part : the record of the scene, or a rotor's entry in it; only `mass` is used
        tensor : tensor of inertia about the node, in the node's axes, kg m², (3, 3)
        com : position of the com from the node, in the node's axes, m, (3,)
        """
        system, mass = self.system, part["mass"]
        node = system.AddNode(items.NodeRigidBodyRotVecLG())
        entries = [tensor[at] for at in ENTRIES]
        inertial = {"mass": mass, "inertia": entries}
        if "slides" in self.scene:
            inertial["centerOfMass"] = [*com]
        body = system.AddObject(items.ObjectRigidBody(nodeNumber=node, **inertial))
        at_com = items.MarkerBodyPosition(bodyNumber=body, localPosition=[*com])
        marker = system.AddMarker(at_com)
        if np.any(self.gravity):
            weight = [*(mass * self.gravity)]
            system.AddLoad(items.LoadForceVector(markerNumber=marker, loadVector=weight))
        return node, body, marker

    def add_rotor(self, rotor, lever):
        """Add a rotor on its hinge, with a drive if the hinge is driven; return its `Rotor`.

        Parameters
        ----------
        rotor : the rotor's entry in the scene record
        lever : vector from the body's node to its com, m, in the scene record's axes, (3,)
        """
        system, R = self.system, self.R_axes_node
        node, body, _ = self.add_body(rotor, R.T @ rotor_tensor(rotor) @ R, np.zeros(3))
        axis, place = np.array(rotor["axis"]), R.T @ (lever + rotor["place"])
        # The joint turns about the z axis of its frame.
        across = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
        across /= np.linalg.norm(across)
        frame = np.eye(4)
        frame[:3, :3] = R.T @ np.column_stack([across, np.cross(axis, across), axis])
        ends = []
        for number, at in ((self.body, place), (body, np.zeros(3))):
            frame[:3, 3] = at
            end = items.MarkerBodyRigid(bodyNumber=number, localHT=frame.copy())
            ends.append(system.AddMarker(end))
        if rotor["hinge"] == "locked":
            hinge = items.ObjectJointGeneric(markerNumbers=ends, constrainedAxes=[1] * 6)
        else:
            hinge = items.ObjectJointRevoluteZ(markerNumbers=ends)
        drive = self.drive(body, place, R.T @ axis) if rotor["hinge"] == "driven" else None
        joint = system.AddObject(hinge)
        return Rotor(node, body, joint, drive, np.array(rotor["place"]), axis)

    def drive(self, rotor, place, axis):
        """Add the constraint that keeps a rotor's spin; return the number of its object.

        Parameters
        ----------
        rotor : number of the rotor's object
        place : position of the hinge from the body's node, m, in the node's axes, (3,)
        axis : axis of the hinge, in the node's axes, (3,)
        """
        system = self.system
        turn = items.MarkerBodiesRelativeRotationCoordinate(
            bodyNumbers=[self.body, rotor], localPosition0=[*place], axis0=[*axis]
        )
        pair = [self.still(), system.AddMarker(turn)]
        return system.AddObject(
            items.ObjectConnectorCoordinate(markerNumbers=pair, velocityLevel=True)
        )

    def still(self):
        """Add a coordinate that stays 0; return the number of its marker."""
        ground = self.system.AddNode(items.NodePointGround())
        return self.system.AddMarker(items.MarkerNodeCoordinate(nodeNumber=ground, coordinate=0))

    def hold(self):
        """Constrain the node's position along all axes except those along which it may slide."""
        still = self.still()
        for k in self.kept_axes:
            pinned = items.MarkerNodeCoordinate(nodeNumber=self.node, coordinate=k)
            pair = [still, self.system.AddMarker(pinned)]
            self.system.AddObject(items.ObjectConnectorCoordinate(markerNumbers=pair))

    def restart(self, motion, timestep):
        """Set another motion and timestep, and initialize the solver.

        Parameters
        ----------
        motion : a dict with `q`, `omega`, `com`, `velocity` and, with rotors, `spins` as in a scene
            record
        timestep : length of the steps from now on, s
        """
        self.timestep = timestep
        R_world_axes, omega = matrix(motion["q"]), np.array(motion["omega"])
        self.face(R_world_axes)
        R_world_node = R_world_axes @ self.R_axes_node
        place, velocity = np.array(motion["com"]), np.array(motion["velocity"])
        if not self.is_free:
            arm = R_world_axes @ self.scene["arm"]
            place, velocity = place + arm, velocity + np.cross(omega, arm)
            place[self.kept_axes] = self.scene.get("height", 0.0)
            velocity[self.kept_axes] = 0.0
        self.start(self.node, R_world_node, omega, place, velocity)
        self.spins_set, of_rotors = motion.get("spins", []), 0.0
        for rotor, spin in zip(self.rotors, self.spins_set, strict=True):
            arm = R_world_axes @ rotor.place
            velocity = motion["velocity"] + np.cross(omega, arm)
            turning = omega + spin * R_world_axes @ rotor.axis
            self.start(rotor.node, R_world_node, turning, motion["com"] + arm, velocity)
            of_rotors += self.terms(rotor.body, turning, rotor.place, omega)
            if rotor.drive is not None:
                self.system.SetObjectParameter(rotor.drive, "offset", spin)
        self.system.Assemble()
        # The generalised-α solver would begin with the accelerations of the last step.
        accelerations = self.system.systemData.GetODE2Coordinates_tt()
        self.system.systemData.SetODE2Coordinates_tt(0 * accelerations)
        self.settings.timeIntegration.endTime = timestep
        if not self.as_shipped:
            # The residual of a small body has small terms: the tolerance must be as small.
            least = NEWTON_TOLERANCE * min(1.0, self.terms(self.body, omega, np.zeros(3), omega))
            newton = self.settings.timeIntegration.newton
            newton.absoluteTolerance = least + ROUNDING * of_rotors
        self.solver.InitializeSolver(self.system, self.settings)

    def terms(self, body, turning, place, omega):
        """Return the size of the terms that the body or a rotor adds to the solver's residual.

        The tolerance of Newton's iteration grows with this size, a torque, N m, plus a force, N.
        The torque is the largest moment times ω², the size of the terms of ω × I ω. The force is
        the mass times the sum of g and the com's centripetal acceleration. Of the vectors only the
        lengths are used, so that their axes do not matter.

        Parameters
        ----------
        body : number of the object of the body or rotor
        turning : angular velocity of this object, rad/s, (3,)
        place : vector from the com of the body to the com of this object, m, (3,)
        omega : angular velocity of the body, rad/s, (3,)
        """
        found = self.system.GetObject(body)
        swing = np.linalg.norm(place) * (omega @ omega) + np.linalg.norm(self.gravity)
        torque = np.max(found["inertia"]) * (turning @ turning)
        return torque + found["mass"] * swing

    def start(self, node, R_world_node, omega, place, velocity):
        """Set the attitude, ω, position and velocity with which a node starts.

        Parameters
        ----------
        node : number of the node
        R_world_node : the attitude, node to world, (3, 3)
        omega : angular velocity, rad/s, world axes, (3,)
        place : position of the node, m, world axes, (3,)
        velocity : velocity of the node, m/s, world axes, (3,)
        """
        start = {
            "referenceCoordinates": [*place, *rotation_vector(quaternion(R_world_node))],
            "initialVelocities": [*velocity, *(R_world_node.T @ omega)],
        }
        for name, coordinates in start.items():
            self.system.SetNodeParameter(node, name, coordinates)

    def spins(self, omega, R_world_axes):
        """Return a list of the rotors' spins, rad/s.

        Parameters
        ----------
        omega : ω of the body, rad/s, world axes, (3,)
        R_world_axes : the attitude of the scene record's axes, (3, 3)
        """
        turning = exudyn.OutputVariableType.AngularVelocity
        each = ((rotor, self.system.GetNodeOutput(rotor.node, turning)) for rotor in self.rotors)
        return [(R_world_axes @ rotor.axis) @ (of_rotor - omega) for rotor, of_rotor in each]

    def motion(self):
        """Return the state as one array, (13 + rotors,), in world axes.

        It has attitude (w x y z), ω (rad/s), com (m), velocity of the com (m/s) and spins (rad/s).
        """
        of_node, of_marker = self.system.GetNodeOutput, self.system.GetMarkerOutput
        names = exudyn.OutputVariableType
        R_world_node = np.array(of_node(self.node, names.RotationMatrix)).reshape(3, 3)
        R_world_axes = R_world_node @ self.R_axes_node.T
        omega = of_node(self.node, names.AngularVelocity)
        return np.concatenate(
            [
                quaternion(R_world_axes),
                omega,
                of_marker(self.com, names.Position),
                of_marker(self.com, names.Velocity),
                self.spins(omega, R_world_axes),
            ]
        )

    def advance(self, steps):
        """Take `steps` steps in one native loop, up to an end time.

        Exudyn's clock starts at 0 in each call, and timesteps are added to it. The end time is
        added up in the same way, since the rounded product steps · timestep might leave a fraction
        of a step. For a method that is not as shipped, it is then set half a step earlier: without
        this margin Exudyn took one step too many in a run to 1e6 s. Exudyn does not shorten the
        last step. As shipped, steps may be halved, and there is no such margin.

        Raises
        ------
        RuntimeError
            If the solver gives up.
        """
        progress, end = self.solver.it, 0.0
        for _ in range(steps):
            end += self.timestep
        if not self.as_shipped:
            end -= self.timestep / 2
        progress.currentTime, progress.endTime = 0.0, end
        if not self.solver.SolveSteps(self.system, self.settings):
            raise RuntimeError("Exudyn's solver gave up")
