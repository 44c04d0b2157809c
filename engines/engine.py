"""One interface for every physics engine: what a run is, and the loop that all of them share."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from types import TracebackType
from typing import ClassVar, Literal, Self, final

import numpy as np
from numpy.typing import NDArray

from ..scenarios import FloatArray, Scenario, Trajectory
from .read_back import (
    READ_BACK_SLACK,
    READ_BACK_SLACK_SINGLE,
    BodyReading,
    EngineError,
    State,
    UnsupportedError,
    check_read_back,
)

Outcome = Literal["ok", "diverged", "unsupported", "failed"]


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
    """

    name: str
    order: int
    attitude_order: int
    summary: str
    effects: frozenset[str]
    requires: frozenset[str] = frozenset()
    max_rotation_per_step: float = np.inf


@dataclass(frozen=True, eq=False)
class Run:
    """How one scene went in one engine, with one method and timestep.

    Attributes
    ----------
    outcome : ok, diverged, unsupported or failed
    reason : why, in words; empty where the outcome is ok
    stopped_at : s, the time at which it diverged or failed, else None
    trajectory : the samples up to there, or None where there are none
    steps : whole steps that were taken
    active : what the engine says acted on the body (names out of `scenarios.EFFECTS`, and anything
        else the adapter found switched on)
    """

    engine: str
    engine_version: str
    method: str
    timestep: float
    outcome: Outcome
    reason: str = ""
    stopped_at: float | None = None
    trajectory: Trajectory | None = None
    steps: int = 0
    active: frozenset[str] = frozenset()


class Session(ABC):
    """A scene loaded in an engine: set to its start, ready to step.

    Raises
    ------
    EngineError
        From any method, when the engine reports trouble of its own.
    """

    @abstractmethod
    def read_body(self) -> BodyReading:
        """Mass, com and tensor as the engine holds them."""

    @abstractmethod
    def read_state(self) -> State:
        """The state now, nothing of it a step old."""

    @abstractmethod
    def advance(self, steps: int) -> None:
        """Take `steps` whole steps, natively: nothing but stepping happens in here."""

    @abstractmethod
    def check(self) -> None:
        """Raise `EngineError` if a step since the last check was not one: warning, reset, clock."""

    @abstractmethod
    def active(self) -> frozenset[str]:
        """What acts on the body, read back from the engine after the run.

        Names out of `scenarios.EFFECTS`, plus a name for whatever else is switched on. A mechanism
        that implements an effect (a constraint that is the pivot) counts as that effect.
        """

    @abstractmethod
    def close(self) -> None:
        """Free the engine's memory."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()


class Engine(ABC):
    """A physics engine. Subclasses fill `open`; the run loop lives here, once."""

    name: ClassVar[str]
    methods: ClassVar[tuple[Method, ...]]
    single_precision: ClassVar[bool] = False

    @property
    @abstractmethod
    def version(self) -> str:
        """The engine's own version."""

    @abstractmethod
    def open(self, scenario: Scenario, method: Method, timestep: float) -> Session:
        """Compile the scene, with its effects and nothing else, and set its start."""

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
    def unsupported(self, scenario: Scenario, method: Method) -> str:
        """Why this method cannot simulate the scene; empty if it can."""
        if beyond := sorted(scenario.called_for - method.effects):
            return f"{self.name} {method.name} cannot simulate {', '.join(beyond)}"
        if lacking := sorted(method.requires - scenario.called_for):
            return f"{self.name} {method.name} is for scenes with {', '.join(lacking)}"
        return ""

    @final
    def run(
        self, scenario: Scenario, method: Method, timestep: float, sample_steps: NDArray[np.int64]
    ) -> Run:
        """Simulate, reading the state at the given step counts; time is k · dt, never a sum.

        Parameters
        ----------
        sample_steps : (n,) increasing whole numbers of steps, the first of them 0
        """

        def ended(outcome: Outcome, reason: str = "", **known: object) -> Run:
            return Run(self.name, self.version, method.name, timestep, outcome, reason, **known)  # type: ignore[arg-type]

        if reason := self.unsupported(scenario, method):
            return ended("unsupported", reason)
        if turn := _clamped_turn(method, timestep, scenario.start.omega_body):
            return ended("unsupported", turn)
        slack = READ_BACK_SLACK_SINGLE if self.single_precision else READ_BACK_SLACK
        states: list[State] = []
        try:
            with self.open(scenario, method, timestep) as session:
                check_read_back(scenario, session.read_body(), session.read_state(), slack)
                outcome, reason = _step_through(session, method, timestep, sample_steps, states)
                active = session.active()
        except UnsupportedError as error:
            return ended("unsupported", str(error))
        except EngineError as error:
            return ended("failed", str(error))
        known: dict[str, object] = {
            "trajectory": _trajectory(states, np.asarray(sample_steps * timestep, dtype=float)),
            "steps": int(sample_steps[len(states) - 1]) if states else 0,
            "active": active,
        }
        if outcome != "ok":
            known["stopped_at"] = float(sample_steps[len(states)] * timestep)
        elif active != scenario.called_for:
            return ended("failed", _audit_message(active, scenario.called_for), **known)
        return ended(outcome, reason, **known)


def _step_through(
    session: Session,
    method: Method,
    timestep: float,
    sample_steps: NDArray[np.int64],
    states: list[State],
) -> tuple[Outcome, str]:
    """Fill `states` until the last sample, or until the engine diverges."""
    taken = 0
    for wanted in sample_steps:
        if wanted > taken:
            session.advance(int(wanted) - taken)
            taken = int(wanted)
        try:
            session.check()
            state = session.read_state()
        except EngineError as error:
            return "diverged", str(error)
        if not all(np.isfinite(values).all() for values in vars(state).values()):
            return "diverged", "the state is no longer finite"
        if turn := _clamped_turn(method, timestep, state.omega_body):
            return "diverged", turn
        states.append(state)
    return "ok", ""


def _clamped_turn(method: Method, timestep: float, omega_body: FloatArray) -> str:
    """Say so if the body turns further in a step than the engine lets it; else empty."""
    turn = float(np.linalg.norm(omega_body)) * timestep
    if turn <= method.max_rotation_per_step:
        return ""
    return (
        f"the rotation a step, {turn:.3g} rad, is beyond {method.max_rotation_per_step:.3g} rad, "
        "where the engine clamps it"
    )


def _trajectory(states: Sequence[State], times: FloatArray) -> Trajectory | None:
    if not states:
        return None
    columns = {name: np.array([getattr(s, name) for s in states]) for name in vars(states[0])}
    return Trajectory(t=times[: len(states)], **columns)


def _audit_message(active: frozenset[str], called_for: frozenset[str]) -> str:
    parts = []
    if extra := sorted(active - called_for):
        parts.append(f"active though the scene does not call for it: {', '.join(extra)}")
    if absent := sorted(called_for - active):
        parts.append(f"called for but not active: {', '.join(absent)}")
    return "; ".join(parts)
