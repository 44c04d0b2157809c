"""Worlds that an engine steps together."""

import time
from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any

from .checks.read_back import State


class Batch(ABC):
    """Many worlds that are stepped by one call, each a scene of its own.

    Attributes
    ----------
    device : the device that steps them: the CPU, or the name of a GPU
    """

    device: str = "CPU"

    @abstractmethod
    def advance(self, steps: int) -> None:
        """Take `steps` steps of every world; return when they are taken."""

    def timed(self, steps: int) -> float:
        """Take `steps` steps of every world; return the wall time that the steps took, s."""
        began = time.perf_counter()
        self.advance(steps)
        return time.perf_counter() - began

    @abstractmethod
    def snapshots(self, places: Sequence[int]) -> Sequence[Any]:
        """Return a snapshot, as `Session.snapshot` does, of each world whose index is in `places`.

        It raises no error for a world that blew up.
        """

    def restart(self, states: State, timestep: float) -> None:
        """Set each of n worlds of one scene to a state of its own, as `Session.restart` does.

        An engine that implements it says so with `Engine.restarts_batches`; without an
        implementation it raises NotImplementedError.

        Parameters
        ----------
        states : n states
        timestep : length of the steps from now on, s
        """
        raise NotImplementedError(f"{type(self).__name__} cannot be restarted.")

    @abstractmethod
    def close(self) -> None:
        """Free the engine's memory."""
