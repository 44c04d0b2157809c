"""One interface for every physics engine: what it can do, and how all of them are run."""

from abc import ABC, abstractmethod
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, final

import numpy as np
from numpy.typing import NDArray

from ..scenarios import Scenario, Trajectory
from ..scenarios.fastest_rate import decay_rate
from .checks.audit import audit
from .checks.bounds import Bounds
from .checks.equation_residuals import equation_residuals
from .checks.faults import clamped_turn
from .checks.precision import single_precision
from .checks.read_back import (
    READ_BACK_SLACK,
    READ_BACK_SLACK_SINGLE,
    BodyReading,
    Difference,
    EngineError,
    State,
    UnsupportedError,
    differences,
)
from .fault import ENVIRONMENTAL, Cause
from .models.description import Description
from .run import Outcome, Run
from .sampling import Sampled, sample
from .session import Session

#: What engines of jointed rigid bodies can simulate: not all that a scene can call for. A method
#: that has a further effect names it besides.
COMMON_EFFECTS = frozenset({"gravity", "pivot", "drag", "torque_body", "torque_world"})


@dataclass(frozen=True)
class Method:
    """One way an engine can simulate a top: an integrator, a formulation.

    Attributes
    ----------
    name : as users type it
    order : order of accuracy of ω in the timestep, as the adapter declares it
    attitude_order : likewise of the attitude
    summary : one line for tables
    effects : names out of `scenarios.EFFECTS` that it can simulate
    requires : effects without which it makes no sense, such as a pivot for a pivot constraint
    max_rotation_per_step : rad; beyond it the engine silently clamps, so it is not run
    as_shipped : the engine with all its defaults: how it differs from the scene is reported as a
        remark, and does not fail a run
    by_angles : whether the attitude of a held body is stepped as roll, pitch and yaw
    damping : 1/s, at which it slows bodies that nothing slows
    reader : whether it differs from a method of another engine only in how models are read
    setup : what users of the engine write to have it, with `TIMESTEP` for the timestep in s; empty
        if that is no matter of a few lines
    """

    name: str
    order: int
    attitude_order: int
    summary: str
    effects: frozenset[str]
    requires: frozenset[str] = frozenset()
    max_rotation_per_step: float = np.inf
    as_shipped: bool = False
    by_angles: bool = False
    damping: float = 0.0
    reader: bool = False
    setup: str = ""

    @property
    def is_recommendable(self) -> bool:
        """Whether it may be recommended to users: it simulates the scene as no other does."""
        return not (self.as_shipped or self.reader)


@dataclass(frozen=True)
class Release:
    """One version of an engine.

    Attributes
    ----------
    requirements : distributions, as pip takes them, with nothing that they depend on but what this
        version needs otherwise than the newest does
    methods : with their orders in that version
    installed_as : the engine whose installed versions it shares; its own name if empty
    surplus : packages that come along and that no run imports: they are not kept
    """

    requirements: tuple[str, ...]
    methods: tuple[Method, ...]
    installed_as: str = ""
    surplus: tuple[str, ...] = ()


class Engine(ABC):
    """A physics engine. Subclasses implement `open`; the run is implemented here, once.

    Attributes
    ----------
    name : as users type it
    methods : what it can simulate with
    single_precision : whether it holds its state in 24 bits
    stock_timestep : s, the default timestep; None where users have to set one
    step_seconds : CPU time of a step, roughly; what the estimate of a run's time rests on
    package : of an optional engine, the package that it needs, imported when a scene is opened
    extra : the extra of spincheck that installs that; the engine's name if empty
    family : a name for several optional engines, by which users may ask for all of them
    of_file : whether it loads the link that a scene names out of the user's own model file
    script_language : what `script` is written in
    steps_in : the native function in which its steps are taken, as valgrind names it, `*` for any
        characters; empty if they are not all native
    describes : features of `Description` that `open_as` can write
    """

    name: str
    methods: tuple[Method, ...]
    single_precision: bool = False
    stock_timestep: float | None = None
    step_seconds: float = 1e-6
    package: str = ""
    extra: str = ""
    family: str = ""
    of_file: bool = False
    script_language: Literal["Python", "JavaScript"] = "Python"
    steps_in: str = ""
    describes: frozenset[str] = frozenset()

    @property
    def is_optional(self) -> bool:
        """Whether it runs only if it is named, wherever it is installed."""
        return bool(self.package or self.family)

    @property
    def slack(self) -> float:
        """Relative tolerance of body and start when they are read back."""
        return READ_BACK_SLACK_SINGLE if self.single_precision else READ_BACK_SLACK

    @property
    def ulp(self) -> float:
        """The relative distance of two neighbouring numbers of its state."""
        return float(np.finfo(np.float32 if self.single_precision else np.float64).eps)

    @property
    @abstractmethod
    def version(self) -> str:
        """The engine's own version."""

    @property
    def sources(self) -> tuple[Path, ...]:
        """Files that its results depend on, besides its adapter."""
        return ()

    @property
    def site(self) -> str:
        """A folder from which its worker imports modules first; empty if none."""
        return ""

    def at_version(self, version: str) -> Release | None:  # noqa: ARG002
        """Another version of the engine; None if other versions are not supported."""
        return None

    @abstractmethod
    def open(self, scenario: Scenario, method: Method, timestep: float) -> Session:
        """Compile the scene, with its effects and nothing else, and set its start."""

    def open_as(
        self, scenario: Scenario, method: Method, timestep: float, description: Description
    ) -> Session:
        """As `open`, with the body described in another way; see `describes`."""
        raise NotImplementedError(f"{self.name} has one way to describe a body.")

    def script(self, scenario: Scenario, method: Method, timestep: float) -> str:  # noqa: ARG002
        """Code that builds the scene with this engine's package alone; empty if there is none.

        It may use `TIMESTEP`, of quaternions, w x y z, `product`, `conjugate` and `turned`, and in
        Python `np`; it defines `step(count)`, and `state()`: attitude, w x y z, and ω in body axes.
        `EXACT`, `LARGEST` and `main` are taken.
        """
        return ""

    def left_out(self, scenario: Scenario, method: Method) -> tuple[str, ...]:  # noqa: ARG002
        """What `open` leaves out that costs time and changes no motion, by the engine's names."""
        return ()

    def open_with(
        self, scenario: Scenario, method: Method, timestep: float, left_in: Collection[str]
    ) -> Session:
        """As `open`, with some of `left_out` left in, to time what they cost."""
        raise NotImplementedError(f"{self.name} leaves nothing out.")

    @final
    def open_unpruned(
        self,
        scenario: Scenario,
        method: Method,
        timestep: float,
        left_in: Collection[str] | None = None,
    ) -> Session | None:
        """As `open_with`, or with all of `left_out` if None; None if nothing is left out."""
        names = self.left_out(scenario, method)
        kept = names if left_in is None else left_in
        return self.open_with(scenario, method, timestep, kept) if names else None

    def defaults(self, scenario: Scenario, method: Method) -> tuple[str, ...]:  # noqa: ARG002
        """The defaults of a method as shipped that alter motions, by the engine's names."""
        return ()

    def open_with_defaults(
        self, scenario: Scenario, method: Method, timestep: float, defaults: Collection[str]
    ) -> Session:
        """As `open`, with only these of a method's defaults.

        Parameters
        ----------
        defaults : names out of `defaults`
        """
        raise NotImplementedError(f"{self.name} {method.name} has no defaults that alter motions.")

    def differences(
        self,
        scenario: Scenario,
        method: str,  # noqa: ARG002
        body: BodyReading,
        state: State,
    ) -> list[Difference]:
        """Differences between a freshly loaded model and the scene."""
        return differences(scenario, body, state, self.slack)

    def steps_angles(self, scenario: Scenario, method: Method) -> bool:
        """Whether the attitude is stepped as three angles."""
        return method.by_angles and not scenario.constraint.is_free

    def applies_to(self, scenario: Scenario) -> bool:  # noqa: ARG002
        """Whether the engine can load anything of the scene."""
        return True

    @final
    def method(self, name: str) -> Method:
        """The method of that name.

        Raises
        ------
        KeyError
            If there is none.
        """
        return {method.name: method for method in self.methods}[name]

    @final
    def methods_for(self, scenario: Scenario) -> list[Method]:
        """The methods that are made for a scene: it has the effects that they require."""
        if not self.applies_to(scenario):
            return []
        return [method for method in self.methods if method.requires <= scenario.called_for]

    @final
    def unsupported(self, scenario: Scenario, method: Method) -> str:
        """Why this method cannot simulate the scene; empty if it can."""
        if beyond := sorted(scenario.called_for - method.effects):
            return f"{self.name} {method.name} cannot simulate {', '.join(beyond)}"
        if lacking := sorted(method.requires - scenario.called_for):
            return f"{self.name} {method.name} is for scenes with {', '.join(lacking)}"
        return ""

    @final
    def equation_residuals(self, scenario: Scenario, method: Method) -> str:
        """How the engine's steps from the start differ from the scene's equations, in words.

        Empty if they do not, also for an engine as shipped, which need not obey them, and where the
        engine raises an `EngineError` before these steps are done.

        Raises
        ------
        EngineError
            If the machine is to blame for that.
        """
        if method.as_shipped or self.unsupported(scenario, method):
            return ""
        try:
            return equation_residuals(
                lambda scene, timestep: self.open(scene, method, timestep),
                scenario,
                self.slack if self.of_file else 0.0,
                is_single=self.single_precision,
            )
        except EngineError as error:
            if error.cause in ENVIRONMENTAL:
                raise
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
        """Simulate, reading the state at the given step counts; time is k · dt, never a sum.

        Parameters
        ----------
        sample_steps : (n,) increasing whole numbers of steps, the first of them 0
        fails_if_unlike : whether another body, start or effects than the scene's fail the run, or
            are a remark; of a method as shipped they always are a remark
        """
        is_strict = fails_if_unlike and not method.as_shipped

        def ended(outcome: Outcome, reason: str, cause: Cause, **fields: object) -> Run:
            named = (self.name, self.version, method.name, timestep)
            return Run(*named, outcome, reason, cause, **fields)  # type: ignore[arg-type]

        if reason := self.unsupported(scenario, method):
            return ended("unsupported", reason, "effects")
        most = method.max_rotation_per_step
        if turn := clamped_turn(float(np.linalg.norm(scenario.start.omega_body)), timestep, most):
            return ended("unsupported", turn, "clamp")
        try:
            with self.open(scenario, method, timestep) as session:
                read_back = session.read_body(), session.read_state()
                unlike = self.differences(scenario, method.name, *read_back)
                if unlike and is_strict:
                    return ended("failed", unlike[0].complaint, "read-back")
                arm = read_back[0].com if scenario.constraint.is_pivot else None
                decay = decay_rate(scenario) + method.damping
                by_angles = self.steps_angles(scenario, method)
                bounds = Bounds(timestep, most, self.slack, decay, arm, by_angles)
                sampled = sample(session, sample_steps, bounds)
                audited = audit(session, scenario, sampled)
        except UnsupportedError as error:
            return ended("unsupported", str(error), error.cause)
        except EngineError as error:
            return ended("failed", str(error), error.cause or "refused")
        fields = _samples(sampled, sample_steps, timestep) | {"active": audited.active}
        if audited.differs and is_strict:
            return ended("failed", audited.differs, "model", **fields)
        bits = "" if self.single_precision else single_precision(sampled.states)
        remarks = [
            *(difference.remark for difference in unlike),
            audited.differs,
            sampled.reason,
            bits,
        ]
        cause = sampled.cause or ("read-back" if unlike else "model" if audited.differs else "")
        if bits and is_strict and not cause:
            cause = "precision"
        return ended(sampled.outcome, "; ".join(part for part in remarks if part), cause, **fields)


def _samples(
    sampled: Sampled, sample_steps: NDArray[np.int64], timestep: float
) -> dict[str, object]:
    """The good samples as a trajectory, how many steps they took, and where they end."""
    fields: dict[str, object] = {}
    count = sampled.count
    if count:
        times = np.asarray(sample_steps[:count] * timestep, dtype=float)
        fields["trajectory"] = Trajectory(t=times, **vars(sampled.states))
        fields["steps"] = int(sample_steps[count - 1])
    if sampled.outcome != "ok":
        fields["stopped_at"] = float(sample_steps[count] * timestep)
    return fields
