"""One interface for every physics engine: what it can do, and how all of them are run."""

from abc import ABC, abstractmethod
from collections.abc import Collection, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Literal, final

import numpy as np
from numpy.typing import NDArray

from ..scenarios import FloatArray, Scenario, Trajectory
from .batch import Batch
from .checks.audit import audit
from .checks.equations import Equations
from .checks.faults import Bounds, clamped_turn
from .checks.read_back import (
    READ_BACK_SLACK,
    READ_BACK_SLACK_SINGLE,
    BodyReading,
    Difference,
    EngineError,
    State,
    UnsupportedError,
    differences,
    start_state,
    stated_body,
)
from .checks.shapes import check_shapes
from .interface import Adapted
from .method import Method, Release
from .models.description import PLAIN, Description
from .run import Run
from .sampling import Sampled, sample
from .session import Session


class Engine(Adapted, ABC):
    """A physics engine. Each adapter is a subclass that implements `open`; all share `run`.

    Attributes
    ----------
    interface : the version of `spincheck.engine` that the adapter is written for
    name : name of the engine, as users type it
    methods : the engine's methods that can be run
    single_precision : whether the engine holds its state in floats of 24 bits
    least_turn : rotation in one step, rad, below which the engine leaves the rotation out, be it by
        ω or by the correction of a constraint; 0 if there is no such limit
    stock_timestep : the engine's default timestep, s; None if users have to set one
    step_seconds, steps_in : no longer read; adapters may still state them
    package : a package that the engine needs and that may not be installed; it is imported when a
        scene is opened. Empty if there is none
    extra : the extra of spincheck that installs the package; if empty, it has the engine's name
    family : a name for several optional engines, by which users may ask for all of them; may be
        empty
    of_file : whether the engine reads the body from a user's model file; the scene then names a
        link of that file
    script_language : the language of the code that `script` returns
    has_batches : whether `open_batch` is implemented
    restarts_batches : whether `Batch.restart` is implemented
    describes : names of the features of a body's description (`Description.features`) that
        `open_with` supports
    varied : the one keyword argument, name and value, that a `VariedEngine` passes to `open_with`
        at each opening; empty for all other engines
    """

    interface: int
    name: str
    methods: tuple[Method, ...]
    single_precision: bool = False
    least_turn: float = 0.0
    stock_timestep: float | None = None
    step_seconds: float = 1e-6
    steps_in: str = ""
    package: str = ""
    extra: str = ""
    family: str = ""
    of_file: bool = False
    script_language: Literal["Python", "JavaScript"] = "Python"
    has_batches: bool = False
    restarts_batches: bool = False
    describes: frozenset[str] = frozenset()
    varied: Mapping[str, Any] = {}

    @property
    def is_optional(self) -> bool:
        """Whether the engine runs only if the user names it, even if it is installed."""
        return bool(self.package or self.family)

    @property
    def slack(self) -> float:
        """The relative tolerance of body and start when they are read back from the engine."""
        return READ_BACK_SLACK_SINGLE if self.single_precision else READ_BACK_SLACK

    @property
    def ulp(self) -> float:
        """The machine epsilon of the precision in which the engine holds its state."""
        return float(np.finfo(np.float32 if self.single_precision else np.float64).eps)

    @property
    @abstractmethod
    def version(self) -> str:
        """The version of the physics engine, not of its adapter."""

    @property
    def sources(self) -> tuple[Path, ...]:
        """The files that the engine's results depend on, besides those of its adapter."""
        return ()

    @property
    def arguments(self) -> tuple[str, ...]:
        """The words of a command line, other than files, on which the engine's results depend."""
        return ()

    @property
    def site(self) -> str:
        """The folder from which worker processes import modules first; empty if there is none."""
        return ""

    def at_version(self, version: str) -> Release | None:  # noqa: ARG002
        """Return what to install for another version of the engine, and the methods it then has.

        None says that the adapter does not support other versions.

        Parameters
        ----------
        version : such as 3.1.6
        """
        return None

    @abstractmethod
    def open(self, scenario: Scenario, method: Method, timestep: float) -> Session:
        """Load the scene into the engine and set its start; return the session.

        The scene's effects act, and nothing else, except in a method as shipped.

        Parameters
        ----------
        method : one of `methods`
        timestep : length of the steps, s

        Raises
        ------
        UnsupportedError
            If the engine is known to simulate the scene wrongly.
        EngineError
            If the engine refuses the scene.
        """

    def open_batch(
        self,
        scenarios: Sequence[Scenario],
        method: Method,
        timestep: float,
    ) -> Batch:
        """Open many worlds that are stepped together; return them as a batch.

        Since version 2 of the interface. An engine that implements this method sets `has_batches`;
        in any other the method raises NotImplementedError.

        Parameters
        ----------
        scenarios : the scene of each world; they differ only in numbers, and most are equal
        method : one of `methods`
        timestep : length of the steps, s
        """
        raise NotImplementedError(f"{self.name} steps one world at a time.")

    def use_device(self, name: str) -> None:
        """Make a device, such as cuda:0, step all scenes that this process opens from now on.

        Since version 2 of the interface.

        Parameters
        ----------
        name : the engine's own name of the device

        Raises
        ------
        UnsupportedError
            If the engine offers no choice of a device, or has no device of that name.
        """
        raise UnsupportedError(f"{self.name} leaves no choice of a device, '{name}' or another")

    def open_with(
        self,
        scenario: Scenario,
        method: Method,
        timestep: float,
        *,
        left_in: Collection[str] = (),
        defaults: Collection[str] | None = None,
        description: Description = PLAIN,
    ) -> Session:
        """Open a scene as `open` does, but with one thing changed, as a keyword argument states.

        In an engine that does not implement this method, NotImplementedError is raised.

        Parameters
        ----------
        left_in : parts of a model or of a step, named as by `Engine.left_out`, that `open` leaves
            out and that are left in here, so that their cost can be measured
        defaults : the engine's defaults that act, named as by `Engine.defaults`; None for those
            that act in the method anyway
        description : how the body is written into the engine's model; its `features` must be in
            `describes`
        """
        raise NotImplementedError(f"{self.name} opens a scene in one way.")

    def script(self, scenario: Scenario, method: Method, timestep: float) -> str:  # noqa: ARG002
        """Return code that builds and steps the scene with this engine's package alone.

        The code is in the language `script_language`. It is empty if the engine has no scripts.

        The code may use names that are defined around it: `TIMESTEP`, the functions `product`,
        `conjugate` and `turned` on quaternions w x y z, and in Python `np`. It must define
        `step(count)`, and `state()`, which returns the attitude, w x y z, and ω in body axes. It
        must not define `EXACT`, `LARGEST` or `main`.
        """
        return ""

    def left_out(self, scenario: Scenario, method: Method) -> tuple[str, ...]:  # noqa: ARG002
        """Return the names of the parts of a model or of a step that `open` leaves out.

        The scene does not call for them: they would cost time, but not change the motion.
        """
        return ()

    def defaults(self, scenario: Scenario, method: Method) -> tuple[str, ...]:  # noqa: ARG002
        """Return the names of the engine's default settings that change motions.

        They act in a method as shipped, and are switched off in all others.
        """
        return ()

    def differences(
        self,
        scenario: Scenario,
        method: str,  # noqa: ARG002
        body: BodyReading,
        state: State,
    ) -> list[Difference]:
        """Return the quantities of body and start whose values in the engine are not the scene's.

        Parameters
        ----------
        method : name of the method that the scene was opened for
        body, state : the body and the state, read back before the first step
        """
        return differences(scenario, body, state, self.slack)

    def applies_to(self, scenario: Scenario) -> bool:  # noqa: ARG002
        """Whether the engine can load the scene's body, be it stated in the scene or in a file."""
        return True

    @final
    def method(self, name: str) -> Method:
        """Return the method of a given name.

        Raises
        ------
        KeyError
            If the engine has no such method.
        """
        return {method.name: method for method in self.methods}[name]

    @final
    def methods_for(self, scenario: Scenario) -> list[Method]:
        """Return the methods whose required effects (`Method.requires`) a scene has.

        The list is empty if `applies_to` is false. A method in it may still be unable to simulate
        another effect of the scene; see `unsupported`.
        """
        if not self.applies_to(scenario):
            return []
        return [method for method in self.methods if method.requires <= scenario.called_for]

    @final
    def unsupported(self, scenario: Scenario, method: Method) -> str:
        """Return why a method cannot simulate the scene; empty if it can."""
        if beyond := sorted(scenario.called_for - method.effects):
            return f"{self.name} {method.name} cannot simulate {', '.join(beyond)}"
        if lacking := sorted(method.requires - scenario.called_for):
            return f"{self.name} {method.name} is for scenes with {', '.join(lacking)}"
        return ""

    @final
    def run(
        self,
        scenario: Scenario,
        method: Method,
        timestep: float,
        sample_steps: NDArray[np.int64],
        *,
        fails_if_unlike: bool = True,
    ) -> Run:
        """Simulate a scene and return its run, sampled after given numbers of steps.

        Parameters
        ----------
        method : one of `methods`
        timestep : length of the steps, s
        sample_steps : numbers of steps from the start to each of n samples, increasing from 0, (n,)
        fails_if_unlike : whether the run fails if body, start or effects differ from the scene. If
            it is false, or if the method is as shipped, `Run.reason` states the difference instead

        Raises
        ------
        OSError, MemoryError
            If the engine raises it: the machine may be at fault. Any other error that is raised
            while the engine steps ends the run as failed.
        """
        is_strict = fails_if_unlike and not method.as_shipped
        ended = partial(Run, self.name, self.version, method.name, timestep)
        if reason := self.unsupported(scenario, method):
            return ended("unsupported", reason, "effects")
        if turn := clamped_start(scenario, method, timestep):
            return ended("unsupported", turn, "clamp")
        try:
            with self.open(scenario, method, timestep) as session:
                body, state = read_at_start(session, scenario)
                unlike = self.differences(scenario, method.name, body, state)
                if unlike and is_strict:
                    return ended("failed", unlike[0].complaint, "read-back")
                most_turn = method.max_rotation_per_step
                bounds = Bounds(timestep, most_turn, _arm(scenario, body))
                sampled = sample(session, sample_steps, bounds)
                active, differs = audit(session, scenario, sampled)
        except UnsupportedError as error:
            return ended("unsupported", str(error), error.cause)
        except EngineError as error:
            return ended("failed", str(error), error.cause or "refused")
        ending = _samples(sampled, sample_steps, timestep) | {"active": active}
        if differs and is_strict:
            return ended("failed", differs, "model", **ending)
        remarks = [*(one.remark for one in unlike), differs, sampled.reason]
        cause = sampled.cause or ("read-back" if unlike else "model" if differs else "")
        return ended(sampled.outcome, "; ".join(filter(None, remarks)), cause, **ending)


def read_at_start(session: Session, scenario: Scenario) -> tuple[BodyReading, State]:
    """Return the body and the state that a newly opened session reads back.

    Raises
    ------
    EngineError
        If they cannot be read, or if their arrays have the wrong shapes.
    """
    kind, body, state = type(session).__name__, session.read_body(), session.read_state()
    check_shapes(body, stated_body(scenario), f"{kind}.read_body")
    check_shapes(state, start_state(scenario), f"{kind}.read_state")
    return body, state


def _arm(scenario: Scenario, body: BodyReading) -> FloatArray | None:
    """Return the vector from the pivot to the com as read back, m, body axes, (3,).

    It is None if the scene has no pivot, or if the com is at the pivot.
    """
    has_arm = float(np.linalg.norm(body.com)) > READ_BACK_SLACK * Equations(scenario).reach
    return body.com if has_arm and scenario.constraint.is_pivot else None


def clamped_start(scenario: Scenario, method: Method, timestep: float) -> str:
    """Return a message if the engine would clamp the turn of body or rotors in the first step.

    It is empty if they turn no further than the method allows in a step.
    """
    speed = float(np.linalg.norm(scenario.start.omega_body))
    if method.clamps_parts:
        speed += float(np.abs(start_state(scenario).spins).max(initial=0.0))
    return clamped_turn(speed, timestep, method.max_rotation_per_step)


def _samples(sampled: Sampled, sample_steps: NDArray[np.int64], timestep: float) -> dict[str, Any]:
    """Return the fields of a `Run`, by name, that follow from its samples.

    `sampled` has the valid samples, and `sample_steps` the numbers of steps from the start to each
    sample. The fields `trajectory` and `steps` are there if any sample is valid, and `stopped_at`,
    the time of the first invalid sample, if the outcome is not ok.
    """
    fields: dict[str, Any] = {}
    count = sampled.count
    if count:
        times = np.asarray(sample_steps[:count] * timestep, dtype=float)
        fields["trajectory"] = Trajectory(t=times, **vars(sampled.states))
        fields["steps"] = int(sample_steps[count - 1])
    if sampled.outcome != "ok":
        fields["stopped_at"] = float(sample_steps[count] * timestep)
    return fields
