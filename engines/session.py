"""A scene loaded in an engine: what every adapter fills in."""

import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from types import TracebackType
from typing import Any, Self

import numpy as np

from .fault import Fault
from .read_back import BodyReading, State


class Session(ABC):
    """A scene loaded in an engine: set to its start, ready to step.

    An engine whose readings take as long as its steps gives them raw, as `snapshot`, turns them
    into states many at a time, and may have a `record` of its own; for any other `read_state` and
    `check` are enough.

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
        """The state after the last step; every quantity of it is current."""

    @abstractmethod
    def advance(self, steps: int) -> None:
        """Take `steps` whole steps, natively: nothing but stepping happens in here."""

    def timed(self, steps: int) -> tuple[float, float]:
        """Take whole steps; CPU and wall time that they took, s.

        An engine in another process measures there.
        """
        wall, cpu = time.perf_counter(), time.process_time()
        self.advance(steps)
        return time.process_time() - cpu, time.perf_counter() - wall

    @abstractmethod
    def check(self) -> None:
        """Raise `EngineError` if a step so far was not one: warning, reset, clamp, clock."""

    @abstractmethod
    def active(self) -> frozenset[str]:
        """What acts on the body, read back from the engine after the run.

        Names out of `scenarios.EFFECTS`, plus a name for whatever else is switched on. A mechanism
        that implements an effect (a constraint that is the pivot) counts as that effect.
        """

    @abstractmethod
    def close(self) -> None:
        """Free the engine's memory."""

    def snapshot(self) -> Any:
        """What is read at a sample, in the engine's own terms.

        Raises `EngineError` for trouble that the engine has reported by now.
        """
        self.check()
        return self.read_state()

    def record(self, strides: Sequence[int], keep: Callable[[Any], object]) -> None:
        """Again and again take some steps, then keep a snapshot: what every run consists of.

        Parameters
        ----------
        strides : steps before each snapshot, 0 or more
        keep : takes a snapshot as soon as it is made
        """
        for steps in strides:
            if steps:
                self.advance(steps)
            keep(self.snapshot())

    def states(self, snapshots: Sequence[Any]) -> State:
        """The states of n snapshots, one a row of each column."""
        return State(**{name: np.array([getattr(s, name) for s in snapshots]) for name in _COLUMNS})

    def first_fault(self, snapshots: Sequence[Any], states: State) -> Fault | None:  # noqa: ARG002
        """The first snapshot that is not a step's outcome; None if all are.

        Reports what `check` would have raised there, for the part that `snapshot` does not check.
        """
        return None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()


_COLUMNS = tuple(State.__dataclass_fields__)
