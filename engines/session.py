"""The interface of a scene loaded in an engine, implemented by every adapter."""

import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from types import TracebackType
from typing import Any, Self

from .checks.read_back import BodyReading, State, stacked
from .derivative import Derivative
from .fault import Fault
from .interface import Adapted


class Session(Adapted, ABC):
    """A scene loaded in an engine: set to its start, ready to step.

    `read_state` and `check` are enough for most engines. If reading takes as long as stepping, an
    adapter can return raw readings (`snapshot`), convert many of them to states at once (`states`),
    and implement its own `record`.

    Raises
    ------
    EngineError
        From any method, when the engine reports trouble of its own.
    """

    @abstractmethod
    def read_body(self) -> BodyReading:
        """Return mass, com and tensor of inertia of the body as the engine holds them."""

    @abstractmethod
    def read_state(self) -> State:
        """Return the state after the last step; every quantity in it must be up to date."""

    @abstractmethod
    def advance(self, steps: int) -> None:
        """Take `steps` whole steps in the engine, and do nothing else: this call is timed."""

    def timed(self, steps: int) -> tuple[float, float]:
        """Take `steps` whole steps; return the CPU time and the wall time that they took, s.

        An engine in another process measures both times in that process.
        """
        wall, cpu = time.perf_counter(), time.process_time()
        self.advance(steps)
        return time.process_time() - cpu, time.perf_counter() - wall

    @property
    def can_restart(self) -> bool:
        """Whether `restart` is implemented; if not, a scene is opened anew at each start."""
        return False

    @property
    def restarts_to_the_last_bit(self) -> bool:
        """Whether a restart gives the same bits as opening the scene in that state.

        Otherwise both differ by rounding, as the engine's coordinates are not those of `State`.
        """
        return True

    def restart(self, state: State, timestep: float | None = None) -> None:
        """Set the body to a state as if the scene had been opened in it, without loading it again.

        Nothing of earlier steps may be left: clocks, warm starts, warnings. A body in reduced
        coordinates hangs by its pivot whatever `com_world` and `velocity_world` are.

        Parameters
        ----------
        timestep : of the steps from now on, s; unchanged if None
        """
        raise NotImplementedError(f"{type(self).__name__} cannot be restarted.")

    @abstractmethod
    def check(self) -> None:
        """Raise `EngineError` if the engine warned, was reset or clamped, or its clock is wrong."""

    @abstractmethod
    def active(self) -> frozenset[str]:
        """Return what acts on the body, read back from the engine after the run.

        These are names out of `scenarios.EFFECTS`, and descriptions of anything else that is
        switched on. A mechanism that implements an effect (a constraint as the pivot) counts as
        that effect.
        """

    @abstractmethod
    def close(self) -> None:
        """Free the engine's memory."""

    def snapshot(self) -> Any:
        """Return the present state in any format of the adapter's, which `states` converts.

        It raises `EngineError` for trouble that the engine has reported so far.
        """
        self.check()
        return self.read_state()

    def record(self, strides: Sequence[int], keep: Callable[[Any], object]) -> None:
        """Take steps and keep a snapshot, repeatedly: this is the whole run.

        Parameters
        ----------
        strides : number of steps before each snapshot, 0 or more
        keep : called with each snapshot
        """
        for steps in strides:
            if steps:
                self.advance(steps)
            keep(self.snapshot())

    def states(self, snapshots: Sequence[Any]) -> State:
        """Return the states of n snapshots as one state with n rows."""
        return stacked(snapshots)

    def first_fault(self, snapshots: Sequence[Any], states: State) -> Fault | None:  # noqa: ARG002
        """Return the first fault in n snapshots, with the snapshot's index; None if there is none.

        A fault here is trouble that `check` would have raised at the snapshot, in an adapter whose
        `snapshot` does not call `check`. `states` has the n states of the snapshots.
        """
        return None

    def derivatives(self) -> Mapping[str, Derivative]:
        """Return the engine's own derivatives by attitude and ω at the present state, by name.

        Since version 2 of the interface. Empty for an engine that computes none.
        """
        return {}

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()
