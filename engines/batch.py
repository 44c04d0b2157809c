"""Worlds that an engine steps together."""

import time
from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any

from .checks.read_back import State


class Batch(ABC):
    """Many independent worlds, each with its own scene, that one call steps together.

    Attributes
    ----------
    device : name of the device that steps the worlds: "CPU", or the name of a GPU
    """

    device: str = "CPU"

    @abstractmethod
    def advance(self, steps: int) -> None:
        """Take `steps` steps of every world; return only when all are taken."""

    def timed(self, steps: int) -> float:
        """Take `steps` steps of every world; return the wall time that the steps took, s."""
        began = time.perf_counter()
        self.advance(steps)
        return time.perf_counter() - began

    @abstractmethod
    def snapshots(self, places: Sequence[int]) -> Sequence[Any]:
        """Return a snapshot of each world whose index is in `places`, in that order.

        The format is that of the engine's `Session.snapshot`. A world that blew up raises no error.
        """

    def restart(self, states: State, timestep: float) -> None:
        """Set n worlds of one scene to n states, one each, without loading the scene again.

        Nothing of earlier steps may be left. An engine that implements this method sets
        `Engine.restarts_batches`; in any other the method raises NotImplementedError.

        Parameters
        ----------
        states : n states, the k-th for the world of index k
        timestep : length of the steps from now on, s
        """
        raise NotImplementedError(f"{type(self).__name__} cannot be restarted.")

    @abstractmethod
    def close(self) -> None:
        """Free the engine's memory."""
