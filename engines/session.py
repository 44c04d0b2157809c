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

    Most adapters implement the abstract methods alone. If reading a state takes as long as a step,
    an adapter can override `snapshot` to return raw numbers, `states` to convert many snapshots at
    once, and `record`.

    Raises
    ------
    EngineError
        From any method, if the engine reports trouble.
    """

    @abstractmethod
    def read_body(self) -> BodyReading:
        """Return the body as the engine holds it: mass, com, tensor of inertia, and rotors."""

    @abstractmethod
    def read_state(self) -> State:
        """Return the state after the last step; every quantity in it must be up to date."""

    @abstractmethod
    def advance(self, steps: int) -> None:
        """Take `steps` whole steps in the engine, and do nothing else, since the call is timed."""

    def timed(self, steps: int) -> tuple[float, float]:
        """Take `steps` whole steps; return the CPU time and the wall time that they took, s.

        An adapter whose engine runs in another process measures the times there.
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
        """Whether a restart at a state gives the same bits as opening the scene in that state.

        If not, the two differ by rounding, because the engine's coordinates are not those of
        `State`.
        """
        return True

    def restart(self, state: State, timestep: float | None = None) -> None:
        """Set the body to a state as if the scene had been opened in it, without loading it again.

        Nothing of earlier steps may be left: clocks, warm starts, warnings. An engine in reduced
        coordinates ignores `com_world` and `velocity_world` of a body on a pivot.

        Parameters
        ----------
        timestep : length of the steps from now on, s; unchanged if None
        """
        raise NotImplementedError(f"{type(self).__name__} cannot be restarted.")

    @abstractmethod
    def check(self) -> None:
        """Raise `EngineError` if the engine warned, was reset or clamped, or its clock is wrong."""

    @abstractmethod
    def active(self) -> frozenset[str]:
        """Return what acts on the body, as a set that is read back from the engine after the run.

        It has names out of `scenarios.EFFECTS`, and descriptions of anything else that is
        switched on. A mechanism that implements an effect, such as a constraint that is the pivot,
        is reported under the effect's name.
        """

    @abstractmethod
    def close(self) -> None:
        """Free the engine's memory."""

    def snapshot(self) -> Any:
        """Return the present state in a format of the adapter's own, which `states` converts.

        `EngineError` is raised if `check` raises it.
        """
        self.check()
        return self.read_state()

    def record(self, strides: Sequence[int], keep: Callable[[Any], object]) -> None:
        """Take steps and then a snapshot, again and again; pass each snapshot to `keep`.

        Parameters
        ----------
        strides : number of steps to take before each snapshot, 0 or more
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

        An adapter whose `snapshot` does not call `check` overrides this method, to find the trouble
        that `check` would have raised at a snapshot.

        Parameters
        ----------
        snapshots : the n snapshots
        states : the n states that they were converted to
        """
        return None

    def derivatives(self) -> Mapping[str, Derivative]:
        """Return the derivatives that the engine itself computes at the present state, by name.

        They are derivatives by attitude and ω, in the chart. The mapping is empty if the engine
        computes none. Since version 2 of the interface.
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
