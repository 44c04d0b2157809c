"""Exudyn, flexible multibody dynamics with explicit and implicit integrators, in double precision.

What it does to a top by default, and how each effect was measured: docs/engines-more.md.
"""

import warnings
from functools import reduce
from importlib import import_module
from importlib.metadata import version
from typing import Any, final

import numpy as np

from ....scenarios import Scenario
from ...checks.read_back import BodyReading, EngineError
from ...engine import Engine, Method
from ...matrix_session import MatrixReading, MatrixSession
from ...native_output import native_output
from ...session import Session
from .held import R_BODY_NODE, Held, held, of_point
from .script import script
from .solvers import AS_SHIPPED, main_solver, solver_settings

EFFECTS = frozenset({"gravity", "pivot", "drag", "torque_body", "torque_world"})
#: Numbers of a node's coordinates that are its position.
PLACE = range(3)
#: Relative difference allowed of a step's length, as Exudyn sums up the time.
CLOCK_SLACK = 1e-6


def _method(name: str, order: int, summary: str) -> Method:
    return Method(name, order, order, summary, EFFECTS)


@final
class Exudyn(Engine):
    """A rigid body on a Lie-group node, its pivot three constrained coordinates."""

    name = "exudyn"
    package = "exudyn"
    step_seconds = 5e-6
    # SimulationSettings: a hundred steps to an end time of 1 s.
    stock_timestep = 0.01
    # Orders: its manual, "Explicit solvers" and "Implicit solvers"; measured in
    # docs/engines-more.md.
    methods = (
        _method("ExplicitEuler", 1, "explicit Euler, the attitude by the exponential map"),
        _method("ExplicitMidpoint", 2, "explicit midpoint rule"),
        _method("RK33", 3, "Runge-Kutta of third order"),
        _method("RK44", 4, "Runge-Kutta of fourth order"),
        _method("RK67", 6, "Runge-Kutta of sixth order, seven stages"),
        _method("TrapezoidalIndex2", 2, "implicit trapezoidal rule, constraints in velocities"),
        Method(
            "default",
            2,
            2,
            "as shipped: generalised α, spectral radius 0.9",
            EFFECTS,
            as_shipped=True,
        ),
    )

    @property
    def version(self) -> str:
        """Of the installed package."""
        return version("exudyn")

    def open(self, scenario: Scenario, method: Method, timestep: float) -> Session:
        """Assemble the system and set its start."""
        solver = AS_SHIPPED if method.as_shipped else method.name
        with native_output() as printed, warnings.catch_warnings():
            warnings.simplefilter("ignore")
            session = ExudynSession(scenario, solver, timestep)
        if "ERROR" in printed.text:
            raise EngineError(f"Exudyn: {' '.join(printed.text.split())}")
        return session

    def script(self, scenario: Scenario, method: Method, timestep: float) -> str:  # noqa: ARG002
        """The system as Python."""
        solver = AS_SHIPPED if method.as_shipped else method.name
        return script(held(scenario), scenario.has_pivot, solver)


@final
class ExudynSession(MatrixSession):
    """One body; with a pivot, its rotation about the pivot is stepped."""

    def __init__(self, scenario: Scenario, solver: str, timestep: float) -> None:
        exudyn: Any = import_module("exudyn")
        self._scenario, self._timestep = scenario, timestep
        self._variables = exudyn.OutputVariableType
        self._container = exudyn.SystemContainer()
        self._system = self._container.AddSystem()
        self._told = held(scenario)
        self._node, self._body, self._com = _assembled(self._system, self._told, scenario.has_pivot)
        self._settings = _settings(exudyn, solver, timestep)
        self._solver = getattr(exudyn, main_solver(solver))()
        self._system.Assemble()
        self._solver.InitializeSolver(self._system, self._settings)

    def read_body(self) -> BodyReading:
        """The body as the object holds it, from the node; its com is where gravity acts."""
        found = self._system.GetObject(self._body)
        com = R_BODY_NODE @ self._system.GetMarker(self._com)["localPosition"]
        xx, yy, zz, yz, xz, xy = found["inertia"]
        of_node = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        inertia = R_BODY_NODE @ of_node @ R_BODY_NODE.T
        mass = float(found["mass"])
        if self._scenario.has_pivot:
            inertia -= of_point(mass, com)
        else:
            com = com + self._scenario.body.com
        return BodyReading(mass, com, inertia)

    def read_matrix(self) -> MatrixReading:
        """The state now."""
        of_node, of_marker = self._system.GetNodeOutput, self._system.GetMarkerOutput
        names = self._variables
        R_world_node = np.array(of_node(self._node, names.RotationMatrix)).reshape(3, 3)
        return MatrixReading(
            R_world_node @ R_BODY_NODE.T,
            R_BODY_NODE @ of_node(self._node, names.AngularVelocityLocal),
            np.array(of_marker(self._com, names.Position)),
            np.array(of_marker(self._com, names.Velocity)),
        )

    def advance(self, steps: int) -> None:
        """One native loop; Exudyn's clock starts at 0 in each call, and sums up the steps.

        At another end, such as the product, a sliver of a step may be missing to it.
        """
        progress, end = self._solver.it, 0.0
        for _ in range(steps):
            end += self._timestep
        progress.currentTime, progress.endTime = 0.0, end
        if not self._solver.SolveSteps(self._system, self._settings):
            raise EngineError("Exudyn's solver gave up", "warning")
        # It counts from 1; as shipped, a step is halved if the solver fails.
        taken, last = progress.currentStepIndex - 1, progress.currentStepSize
        if taken != steps or abs(last - self._timestep) > CLOCK_SLACK * self._timestep:
            words = f"Exudyn took {taken} steps, the last of {last!r} s"
            raise EngineError(f"{words}, not {steps} of {self._timestep!r} s", "clock")

    def check(self) -> None:
        """Nothing to do: `advance` checks after each step."""

    def active(self) -> frozenset[str]:
        """What acts, from the loads and objects of the system and their strengths."""
        system, numbers = self._system, self._system.systemData
        acting = set()
        for number in range(numbers.NumberOfLoads()):
            acting.add(self._of_load(system.GetLoad(number)))
        kinds = []
        for number in range(numbers.NumberOfObjects()):
            found = system.GetObject(number)
            kinds.append(found["objectType"])
            if found["objectType"] == "ConnectorRigidBodySpringDamper":
                acting.add(self._of_damper(found))
        if kinds.count("ConnectorCoordinate") == len(PLACE):
            acting.add("pivot")
        expected_kinds = {
            "RigidBody",
            "Ground",
            "ConnectorCoordinate",
            "ConnectorRigidBodySpringDamper",
        }
        return frozenset(
            acting | {f"an object of type {kind}" for kind in set(kinds) - expected_kinds}
        )

    def _of_load(self, found: Any) -> str:
        vector, told = np.array(found["loadVector"]), self._told
        if found["loadType"] == "ForceVector":
            name, wanted = "gravity", told.weight
        elif found["bodyFixed"]:
            name, wanted = "torque_body", told.torque_node
        else:
            name, wanted = "torque_world", told.torque_world
        return name if np.array_equal(vector, wanted) else f"a load of {vector.tolist()}"

    def _of_damper(self, found: Any) -> str:
        wanted = self._told.damping
        is_drag = np.array_equal(found["damping"], wanted) and not np.any(found["stiffness"])
        return "drag" if is_drag else "a spring or damper"

    def close(self) -> None:
        """Drop the system."""
        self._solver.FinalizeSolver(self._system, self._settings)
        self._container.Reset()


def _settings(exudyn: Any, solver: str, timestep: float) -> Any:
    settings = exudyn.SimulationSettings()
    settings.solution.file.write = False
    integration = settings.timeIntegration
    integration.numberOfSteps, integration.endTime = 1, timestep
    integration.solverType = getattr(exudyn.DynamicSolverType, solver)
    for name, value in solver_settings(solver).items():
        *group, setting = name.split(".")
        setattr(reduce(getattr, group, integration), setting, value)
    return settings


def _assembled(system: Any, told: Held, has_pivot: bool) -> tuple[int, int, int]:
    """Build the body; returns the numbers of its node, object, and marker at the com."""
    items = import_module("exudyn.itemInterface")
    node = system.AddNode(
        items.NodeRigidBodyRotVecLG(
            referenceCoordinates=[*told.place], initialVelocities=[*told.velocity]
        )
    )
    number = system.AddObject(
        items.ObjectRigidBody(mass=told.mass, inertia=[*told.inertia], nodeNumber=node)
    )
    com = system.AddMarker(items.MarkerBodyPosition(bodyNumber=number, localPosition=[*told.com]))
    if has_pivot:
        _hold(system, items, node)
    _load(system, items, told, number, com)
    return node, number, com


def _hold(system: Any, items: Any, node: int) -> None:
    """Constrain the node's position."""
    ground = system.AddNode(items.NodePointGround())
    still = system.AddMarker(items.MarkerNodeCoordinate(nodeNumber=ground, coordinate=0))
    for coordinate in PLACE:
        pinned = system.AddMarker(
            items.MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate)
        )
        system.AddObject(items.ObjectConnectorCoordinate(markerNumbers=[still, pinned]))


def _load(system: Any, items: Any, told: Held, body: int, com: int) -> None:
    """Add the scene's torques, drag and gravity."""
    if told.weight.any():
        system.AddLoad(items.LoadForceVector(markerNumber=com, loadVector=[*told.weight]))
    whole = system.AddMarker(items.MarkerBodyRigid(bodyNumber=body))
    for torque, turns in ((told.torque_node, True), (told.torque_world, False)):
        if torque.any():
            system.AddLoad(
                items.LoadTorqueVector(markerNumber=whole, loadVector=[*torque], bodyFixed=turns)
            )
    if told.damping.any():
        still = system.AddMarker(
            items.MarkerBodyRigid(bodyNumber=system.AddObject(items.ObjectGround()))
        )
        system.AddObject(
            items.ObjectConnectorRigidBodySpringDamper(
                markerNumbers=[still, whole], damping=told.damping
            )
        )
