"""Worlds that an engine steps together."""

import time
from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any


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

    @abstractmethod
    def close(self) -> None:
        """Free the engine's memory."""
