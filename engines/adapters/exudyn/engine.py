"""Exudyn, flexible multibody dynamics with explicit and implicit integrators, in double precision.

docs/measured/engines-more.md says what the engine does to a top by default, and how effects were
measured.
"""

import warnings
from collections.abc import Iterator, Sequence
from typing import Any, final

import numpy as np
from spincheck.engine import (
    COMMON_EFFECTS,
    EngineError,
    FloatArray,
    Method,
    Scenario,
    Session,
    State,
    UnsupportedError,
)

from ...native_output import native_output
from ...scene_record import HeldRotor, WorldBody
from ...world_engine import WorldEngine
from ...world_session import WorldSession

#: Types of Exudyn's objects that a scene needs besides joints of rotors.
KINDS = frozenset({"RigidBody", "Ground", "ConnectorCoordinate", "ConnectorRigidBodySpringDamper"})
#: Effects that the implicit integrators can simulate. The explicit ones refuse joints between
#: bodies, and so rotors. They also simulate constraints wrongly if the com is not at the body's
#: node, as for a body on a table.
IMPLICIT_EFFECTS = COMMON_EFFECTS | {"rotors", "table"}
#: Largest rotation of a rotor in a step, rad, for which Newton's iteration converges. An iteration
#: multiplies the error by about half the rotation (0.36 at 0.73 rad, measured), so that the 100
#: iterations that `world` allows reduce it to 1e-13.
MOST_TURN = 1.5
#: Types of Exudyn's joints for rotors, by kind of hinge.
HINGES = {"free": "JointRevoluteZ", "driven": "JointRevoluteZ", "locked": "JointGeneric"}
#: Allowed relative difference of a step's length; Exudyn computes it from a sum of times.
CLOCK_SLACK = 1e-6


def _method(
    name: str, order: int, summary: str, effects: frozenset[str] = COMMON_EFFECTS
) -> Method:
    """Return the method that uses a solver of Exudyn's.

    Parameters
    ----------
    name : the solver's name, a member of `DynamicSolverType`
    order : declared order of accuracy, of ω and of the attitude
    summary : the method in a few words
    effects : names of the effects that the method can simulate
    """
    setup = f"""\
settings = exudyn.SimulationSettings()
settings.timeIntegration.endTime = duration
settings.timeIntegration.numberOfSteps = round(duration / TIMESTEP)
mbs.SolveDynamic(settings, solverType=exudyn.DynamicSolverType.{name})"""
    return Method(name, order, order, summary, effects, setup=setup)


@final
class ExudynSession(WorldSession):
    """A session of one body in an Exudyn system.

    The body's node, at which Exudyn has its coordinates, is the point that is held, or the com of a
    free body.
    """

    def world_body(self) -> WorldBody:
        """Return the body as Exudyn holds it: mass, com, tensor, held point and rotors.

        The origin is the node; axes are those of the scene record. The com is read from the marker
        at which gravity acts.
        """
        system, R_axes_node = self.world.system, self.world.R_axes_node
        com = R_axes_node @ system.GetMarker(self.world.com)["localPosition"]
        mass, about_node = self._mass_of(self.world.body)
        inertia_com = about_node - mass * (com @ com * np.eye(3) - np.outer(com, com))
        arm = None if self.world.is_free else np.zeros(3)
        rotors = [self._rotor(rotor) for rotor in self.world.rotors]
        return WorldBody(mass, com, inertia_com, arm, rotors)

    def _mass_of(self, body: int) -> tuple[float, FloatArray]:
        """Return an object's mass, kg, and its tensor of inertia about its node, kg m².

        The tensor, (3, 3), is in the axes of the scene's record. `body` is the object's number.
        """
        found, R_axes_node = self.world.system.GetObject(body), self.world.R_axes_node
        xx, yy, zz, yz, xz, xy = found["inertia"]
        of_node = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        return float(found["mass"]), R_axes_node @ of_node @ R_axes_node.T

    def _rotor(self, rotor: Any) -> HeldRotor:
        """Return a rotor in the pose that its joint gives it relative to the body.

        In this pose the joint's frame on the rotor coincides with that on the body. `rotor` has the
        numbers of the rotor's objects in the system (`Rotor` in `world.py`).
        """
        system, R = self.world.system, self.world.R_axes_node
        joint = system.GetObject(rotor.joint)
        in_body, in_rotor = (
            np.array(system.GetMarker(end)["localHT"]) for end in joint["markerNumbers"]
        )
        place = in_body @ np.linalg.inv(in_rotor)
        mass, tensor = self._mass_of(rotor.body)
        # At the start the nodes of body and rotor have the same axes. The joint would turn the
        # rotor against the body by the rotation in `place`.
        turn = R @ place[:3, :3] @ R.T
        turns = joint["objectType"] == HINGES["free"]
        axis = R @ in_body[:3, 2] if turns else np.zeros(3)
        return HeldRotor(mass, R @ place[:3, 3], turn @ tensor @ turn.T, axis)

    #: Why the solver gave up; empty if it has not.
    _trouble = ""

    def restart(self, state: State, timestep: float | None = None) -> None:
        """Set the body to a state, and the timestep, s, if one is given (`Session.restart`)."""
        self._trouble = ""
        super().restart(state, timestep)

    def advance(self, steps: int) -> None:
        """Let the world take `steps` steps; compare their number and length with Exudyn's counts.

        Raises
        ------
        EngineError
            If the solver gave up, or took steps of another number or length.
        """
        try:
            self.world.advance(steps)
        except RuntimeError as error:
            self._trouble = str(error)
        # Exudyn counts its steps from 1.
        progress = self.world.solver.it
        taken, last = progress.currentStepIndex - 1, progress.currentStepSize
        if not self._trouble and (
            taken != steps or abs(last - self.timestep) > CLOCK_SLACK * self.timestep
        ):
            words = f"Exudyn took {taken} steps, the last of {last!r} s"
            words = f"{words}, not {steps} of {self.timestep!r} s"
            # As shipped, Exudyn halves a step that fails to converge. A shorter timestep removes
            # this, so that the cause is not the clock.
            if not (self.world.as_shipped and taken > steps):
                raise EngineError(words, "clock")
            self._trouble = words
        self.check()

    def check(self) -> None:
        """Raise `EngineError` if the solver gave up."""
        if self._trouble:
            raise EngineError(self._trouble, "warning")

    def active(self) -> frozenset[str]:
        """Return names of the effects that act, and descriptions of all else that acts.

        Both are read from the system.
        """
        system = self.world.system
        numbers = system.systemData
        loads = [self._of_load(system.GetLoad(k)) for k in range(numbers.NumberOfLoads())]
        acting = {*loads}
        if "gravity" in acting and loads.count("gravity") != 1 + len(self.world.rotors):
            acting.add(f"gravity on {loads.count('gravity')} of body and rotors")
        objects = [system.GetObject(k) for k in range(numbers.NumberOfObjects())]
        hinges = {
            int(number)
            for rotor in self.world.rotors
            for number in (rotor.joint, rotor.drive)
            if number is not None
        }
        kinds = [one["objectType"] for k, one in enumerate(objects) if k not in hinges]
        acting |= {
            self._of_damper(found)
            for found in objects
            if found["objectType"] == "ConnectorRigidBodySpringDamper"
        }
        acting |= self._of_constraints(objects)
        if self.world.rotors:
            acting |= {"rotors", *self._wrong_hinges(objects)}
        return frozenset(acting | {f"an object of type {kind}" for kind in {*kinds} - KINDS})

    def _wrong_hinges(self, objects: Sequence[Any]) -> Iterator[str]:
        """Yield, in words, how joints and drives of rotors differ from what the scene states.

        `objects` are all objects of the system, in the order of their numbers.
        """
        described = zip(self.scene["rotors"], self.world.rotors, self.world.spins_set, strict=True)
        for number, (wanted, rotor, spin) in enumerate(described, start=1):
            joint, hinge = objects[int(rotor.joint)], wanted["hinge"]
            is_whole = hinge != "locked" or np.all(joint["constrainedAxes"])
            if joint["objectType"] != HINGES[hinge] or not (joint["activeConnector"] and is_whole):
                yield f"rotor {number} on another joint than that of a {hinge} hinge"
            if (rotor.drive is not None) != (hinge == "driven"):
                yield f"rotor {number} with another drive than that of a {hinge} hinge"
            elif rotor.drive is not None:
                drive = objects[int(rotor.drive)]
                if not drive["activeConnector"] or drive["offset"] != spin:
                    yield f"rotor {number} driven to another spin than {spin:g} rad/s"

    def _of_constraints(self, objects: Sequence[Any]) -> set[str]:
        """Return the effect that the constraints on the node's position implement, as a set.

        The set is {"pivot"} or {"table"}, or empty if no coordinate is constrained. If the
        constraints are those of neither effect, it has a description of them.

        Parameters
        ----------
        objects : all objects of the system
        """
        constrained = []
        for found in objects:
            if found["objectType"] == "ConnectorCoordinate" and not found["velocityLevel"]:
                _, marker = map(self.world.system.GetMarker, found["markerNumbers"])
                is_kept = found["activeConnector"] and int(marker["nodeNumber"]) == int(
                    self.world.node
                )
                constrained.append(int(marker["coordinate"]) if is_kept else -1)
        kinds = {(): set(), (0, 1, 2): {"pivot"}, (2,): {"table"}}
        return kinds.get((*constrained,), {f"other constrained coordinates: {constrained}"})

    def _of_load(self, found: Any) -> str:
        """Return the name of the effect that a load implements, or else a description of the load.

        `found` is Exudyn's dict of the load. A load implements an effect if it is of the right kind
        and its vector is the scene's.
        """
        vector, scene, system = np.array(found["loadVector"]), self.scene, self.world.system
        if found["loadType"] == "ForceVector":
            of = system.GetObject(system.GetMarker(found["markerNumber"])["bodyNumber"])
            name, wanted = "gravity", of["mass"] * np.array(scene["gravity"])
        elif found["bodyFixed"]:
            name, wanted = "torque_body", self.world.R_axes_node.T @ scene["torque_body"]
        else:
            name, wanted = "torque_world", scene["torque_world"]
        return name if np.array_equal(vector, wanted) else f"a load of {vector.tolist()}"

    def _of_damper(self, found: Any) -> str:
        """Return "drag" if a connector is exactly the scene's drag, else a description of it.

        `found` is Exudyn's dict of the connector.
        """
        damping = np.diag(found["damping"])
        # A node's rotational coordinates come last, but `damped_by` takes them first.
        (name,) = self.damped_by(np.roll(damping, 3).tolist())
        is_damper = np.array_equal(found["damping"], np.diag(damping))
        return name if is_damper and not np.any(found["stiffness"]) else "a spring or damper"

    def close(self) -> None:
        """Finalize the solver, and remove the system."""
        self.world.close()


def _check_turns(scenario: Scenario, timestep: float) -> None:
    """Raise `UnsupportedError` if a rotor may turn by more than `MOST_TURN`, rad, in a step."""
    omega = float(np.linalg.norm(scenario.start.omega_body))
    fastest = omega + float(np.abs(scenario.rotors.start_spins).max())
    if fastest * timestep > MOST_TURN:
        raise UnsupportedError(
            f"a rotor turns by {np.degrees(fastest * timestep):.3g}° a step, beyond "
            f"{np.degrees(MOST_TURN):.3g}°, where Exudyn's Newton iteration does not converge; use "
            f"a timestep of less than {MOST_TURN / fastest:.2g} s, or another engine",
            "clamp",
        )


@final
class Exudyn(WorldEngine):
    """The engine Exudyn, with the body on a Lie-group node, and rotors on joints.

    A pivot is implemented by constraints on the three coordinates of the node's position.
    """

    session = ExudynSession
    name = "exudyn"
    package = "exudyn"
    # The defaults of SimulationSettings are a hundred steps and an end time of 1 s.
    stock_timestep = 0.01
    # Orders are those of Exudyn's manual, "Explicit solvers" and "Implicit solvers"; they were
    # confirmed by measurement (docs/measured/engines-more.md).
    methods = (
        _method("ExplicitEuler", 1, "explicit Euler, the attitude by the exponential map"),
        _method("ExplicitMidpoint", 2, "explicit midpoint rule"),
        _method("RK33", 3, "Runge-Kutta of third order"),
        _method("RK44", 4, "Runge-Kutta of fourth order"),
        _method("RK67", 6, "Runge-Kutta of sixth order, seven stages"),
        # Second order without rotors. With rotors, the accelerations at the start leave out that
        # the joints turn: a first step has an error of first order, which alternates in a run.
        _method(
            "TrapezoidalIndex2",
            1,
            "implicit trapezoidal rule, constraints in velocities",
            IMPLICIT_EFFECTS,
        ),
        Method(
            "default",
            2,
            2,
            "as shipped: generalised α, spectral radius 0.9",
            IMPLICIT_EFFECTS,
            as_shipped=True,
        ),
    )

    def open(self, scenario: Scenario, method: Method, timestep: float) -> Session:
        """Assemble the system with the scene at its start; return the session.

        Raises
        ------
        UnsupportedError
            If a rotor turns too far in a step; not raised by the method as shipped.
        EngineError
            If Exudyn prints an error.
        """
        if scenario.rotors and not method.as_shipped:
            _check_turns(scenario, timestep)
        with native_output() as printed, warnings.catch_warnings():
            warnings.simplefilter("ignore")
            session = super().open(scenario, method, timestep)
        if "ERROR" in printed.text:
            raise EngineError(f"Exudyn: {' '.join(printed.text.split())}")
        return session
