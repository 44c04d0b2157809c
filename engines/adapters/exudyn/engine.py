"""Exudyn, flexible multibody dynamics with explicit and implicit integrators, in double precision.

What it does to a top by default, and how each effect was measured: docs/measured/engines-more.md.
"""

import warnings
from typing import Any, final

import numpy as np

from ....scenarios import Scenario
from ...checks.read_back import EngineError
from ...method import COMMON_EFFECTS, Method
from ...native_output import native_output
from ...scene_record import WorldBody
from ...session import Session
from ...world_engine import WorldEngine
from ...world_session import WorldSession

#: Types of the objects that a scene needs.
KINDS = frozenset({"RigidBody", "Ground", "ConnectorCoordinate", "ConnectorRigidBodySpringDamper"})
#: Relative difference allowed of a step's length, as Exudyn sums up the time.
CLOCK_SLACK = 1e-6


def _method(name: str, order: int, summary: str) -> Method:
    setup = f"""\
settings = exudyn.SimulationSettings()
settings.timeIntegration.endTime = duration
settings.timeIntegration.numberOfSteps = round(duration / TIMESTEP)
mbs.SolveDynamic(settings, solverType=exudyn.DynamicSolverType.{name})"""
    return Method(name, order, order, summary, COMMON_EFFECTS, setup=setup)


@final
class ExudynSession(WorldSession):
    """One body; with a pivot, its rotation about the pivot is stepped."""

    @property
    def restarts_to_the_last_bit(self) -> bool:
        """No: its node keeps the axes that suit the start it was opened with."""
        return False

    def world_body(self) -> WorldBody:
        """The body as the object holds it, from the node; its com is where gravity acts."""
        system, R_axes_node = self.world.system, self.world.R_axes_node
        found = system.GetObject(self.world.body)
        com = R_axes_node @ system.GetMarker(self.world.com)["localPosition"]
        xx, yy, zz, yz, xz, xy = found["inertia"]
        of_node = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        mass = float(found["mass"])
        of_com = mass * (com @ com * np.eye(3) - np.outer(com, com))
        inertia_com = R_axes_node @ of_node @ R_axes_node.T - of_com
        return WorldBody(mass, com, inertia_com, None if self.world.is_free else np.zeros(3))

    def advance(self, steps: int) -> None:
        """As the world does; checks that it took so many steps of the right length."""
        try:
            self.world.advance(steps)
        except RuntimeError as error:
            raise EngineError(str(error), "warning") from None
        # It counts from 1; as shipped, a step is halved if the solver fails.
        progress = self.world.solver.it
        taken, last = progress.currentStepIndex - 1, progress.currentStepSize
        if taken != steps or abs(last - self.timestep) > CLOCK_SLACK * self.timestep:
            words = f"Exudyn took {taken} steps, the last of {last!r} s"
            raise EngineError(f"{words}, not {steps} of {self.timestep!r} s", "clock")

    def active(self) -> frozenset[str]:
        """What acts, from the loads and objects of the system and their strengths."""
        system = self.world.system
        numbers = system.systemData
        acting = {self._of_load(system.GetLoad(k)) for k in range(numbers.NumberOfLoads())}
        objects = [system.GetObject(k) for k in range(numbers.NumberOfObjects())]
        kinds = [found["objectType"] for found in objects]
        acting |= {
            self._of_damper(found)
            for found in objects
            if found["objectType"] == "ConnectorRigidBodySpringDamper"
        }
        if kinds.count("ConnectorCoordinate") == 3:
            acting.add("pivot")
        return frozenset(acting | {f"an object of type {kind}" for kind in {*kinds} - KINDS})

    def _of_load(self, found: Any) -> str:
        vector, scene = np.array(found["loadVector"]), self.scene
        if found["loadType"] == "ForceVector":
            name, wanted = "gravity", scene["mass"] * np.array(scene["gravity"])
        elif found["bodyFixed"]:
            name, wanted = "torque_body", self.world.R_axes_node.T @ scene["torque_body"]
        else:
            name, wanted = "torque_world", scene["torque_world"]
        return name if np.array_equal(vector, wanted) else f"a load of {vector.tolist()}"

    def _of_damper(self, found: Any) -> str:
        damping = np.diag(found["damping"])
        # Rotations come last.
        (name,) = self.damped_by(np.roll(damping, 3).tolist())
        is_damper = np.array_equal(found["damping"], np.diag(damping))
        return name if is_damper and not np.any(found["stiffness"]) else "a spring or damper"

    def close(self) -> None:
        """Drop the system."""
        self.world.solver.FinalizeSolver(self.world.system, self.world.settings)
        self.world.container.Reset()


@final
class Exudyn(WorldEngine):
    """A rigid body on a Lie-group node, its pivot three constrained coordinates."""

    session = ExudynSession
    name = "exudyn"
    package = "exudyn"
    step_seconds = 5e-6
    # SimulationSettings: a hundred steps to an end time of 1 s.
    stock_timestep = 0.01
    # Orders: its manual, "Explicit solvers" and "Implicit solvers"; measured in
    # docs/measured/engines-more.md.
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
            COMMON_EFFECTS,
            as_shipped=True,
        ),
    )

    def open(self, scenario: Scenario, method: Method, timestep: float) -> Session:
        """Assemble the system and set its start."""
        with native_output() as printed, warnings.catch_warnings():
            warnings.simplefilter("ignore")
            session = super().open(scenario, method, timestep)
        if "ERROR" in printed.text:
            raise EngineError(f"Exudyn: {' '.join(printed.text.split())}")
        return session
