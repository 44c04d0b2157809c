"""An Exudyn system of one body, which needs `exudyn` and numpy alone."""

from functools import reduce

import exudyn
import exudyn.itemInterface
import numpy as np

from ...world_parts import matrix, quaternion, rotation_vector

items = exudyn.itemInterface
AS_SHIPPED = "GeneralizedAlpha"
#: Integrators that solve for accelerations at the end of a step.
IMPLICIT = (AS_SHIPPED, "TrapezoidalIndex2")
#: Tolerances, relative and in units of the residual; Exudyn's defaults are 1e-8 and 1e-10.
NEWTON_TOLERANCE = 1e-13
OF_TRAPEZOIDAL_RULE = {
    # As Exudyn's own SolveDynamic sets them for this solver name.
    "generalizedAlpha.useIndex2Constraints": True,
    "generalizedAlpha.useNewmark": True,
    # Solved to round-off, with a new Jacobian: so a step depends on the state alone.
    "newton.relativeTolerance": NEWTON_TOLERANCE,
    "newton.absoluteTolerance": NEWTON_TOLERANCE,
    "newton.useModifiedNewton": False,
}
#: The body's axes in another order, and in a third.
TURNED = [np.roll(np.eye(3), k, axis=0) for k in range(3)]


def settings(solver):
    """How the solver steps; of a default step that fails, Exudyn takes halves."""
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
    """One body on a Lie-group node, its pivot three constrained coordinates.

    Explicit solvers eliminate constraints wrongly if the com is not at the node. So the node is at
    the pivot, the tensor is taken about the pivot, and gravity is a force on a marker at the com.
    """

    def __init__(self, scene, method, timestep):
        solver = AS_SHIPPED if method == "default" else method
        self.is_free = scene["arm"] is None
        self.container = exudyn.SystemContainer()
        self.system = self.container.AddSystem()
        # Exudyn composes rotation vectors with an arc cosine, which loses half the digits of a
        # small one: from a start along the world's axes, rotations of less than 1.5e-8 rad a step
        # were lost. So the node's axes are the body's in the order that starts furthest from there.
        starts = [np.trace(matrix(scene["q"]) @ turned) for turned in TURNED]
        self.R_axes_node = TURNED[int(np.argmin(np.abs(starts)))]
        self.assemble(scene)
        self.settings = settings(solver)
        kind = "ImplicitSecondOrder" if solver in IMPLICIT else "Explicit"
        self.solver = getattr(exudyn, f"MainSolver{kind}")()
        self.system.Assemble()
        self.restart(scene, timestep)

    def assemble(self, scene):
        """Build the body, and what holds it and acts on it."""
        system, R = self.system, self.R_axes_node
        lever = -np.array(scene["arm"] or (0.0, 0.0, 0.0))  # from the node to the com
        about_node = scene["mass"] * (lever @ lever * np.eye(3) - np.outer(lever, lever))
        of_node = R.T @ (np.diag(scene["moments"]) + about_node) @ R
        self.node = system.AddNode(items.NodeRigidBodyRotVecLG())
        entries = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
        self.body = system.AddObject(
            items.ObjectRigidBody(
                mass=scene["mass"], inertia=[of_node[at] for at in entries], nodeNumber=self.node
            )
        )
        self.com = system.AddMarker(
            items.MarkerBodyPosition(bodyNumber=self.body, localPosition=[*(R.T @ lever)])
        )
        if not self.is_free:
            self.hold()
        if np.any(scene["gravity"]):
            weight = scene["mass"] * np.array(scene["gravity"])
            system.AddLoad(items.LoadForceVector(markerNumber=self.com, loadVector=[*weight]))
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

    def hold(self):
        """Constrain the node's position."""
        ground = self.system.AddNode(items.NodePointGround())
        still = self.system.AddMarker(items.MarkerNodeCoordinate(nodeNumber=ground, coordinate=0))
        for k in range(3):
            pinned = items.MarkerNodeCoordinate(nodeNumber=self.node, coordinate=k)
            pair = [still, self.system.AddMarker(pinned)]
            self.system.AddObject(items.ObjectConnectorCoordinate(markerNumbers=pair))

    def restart(self, motion, timestep):
        """Set another motion and timestep: a new start of the node, and a new run of the solver."""
        self.timestep = timestep
        R_world_axes = matrix(motion["q"])
        omega_node = self.R_axes_node.T @ R_world_axes.T @ np.array(motion["omega"])
        attitude = rotation_vector(quaternion(R_world_axes @ self.R_axes_node))
        still = [0.0, 0.0, 0.0]
        place = [*(motion["com"] if self.is_free else still), *attitude]
        velocity = [*(motion["velocity"] if self.is_free else still), *omega_node]
        self.system.SetNodeParameter(self.node, "referenceCoordinates", place)
        self.system.SetNodeParameter(self.node, "initialVelocities", velocity)
        self.system.Assemble()
        # The generalised-α solver begins with the accelerations that are there.
        accelerations = self.system.systemData.GetODE2Coordinates_tt()
        self.system.systemData.SetODE2Coordinates_tt(0 * accelerations)
        self.settings.timeIntegration.endTime = timestep
        self.solver.InitializeSolver(self.system, self.settings)

    def motion(self):
        """Attitude, w x y z, ω, com and its velocity, world axes."""
        of_node, of_marker = self.system.GetNodeOutput, self.system.GetMarkerOutput
        names = exudyn.OutputVariableType
        R_world_node = np.array(of_node(self.node, names.RotationMatrix)).reshape(3, 3)
        return np.concatenate(
            [
                quaternion(R_world_node @ self.R_axes_node.T),
                of_node(self.node, names.AngularVelocity),
                of_marker(self.com, names.Position),
                of_marker(self.com, names.Velocity),
            ]
        )

    def advance(self, steps):
        """One native loop; Exudyn's clock starts at 0 in each call, and sums up the steps.

        At another end, such as the product, a sliver of a step may be missing to it.
        """
        progress, end = self.solver.it, 0.0
        for _ in range(steps):
            end += self.timestep
        progress.currentTime, progress.endTime = 0.0, end
        if not self.solver.SolveSteps(self.system, self.settings):
            raise RuntimeError("Exudyn's solver gave up")
