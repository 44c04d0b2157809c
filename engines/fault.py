"""The causes of a run's failure, one word each, and the sample at which it failed."""

from dataclasses import dataclass
from typing import Literal

#: What each cause means and how it is detected: docs/explanation/outcomes.md.
Cause = Literal[
    "",
    # Of runs that diverged: the motion became wrong at some time.
    "not-finite",
    "not-unit",
    "reset",
    "clamp",
    "pivot",
    "energy",
    "warning",
    # Of runs that failed: the result is no motion of the scene, at any timestep.
    "read-back",
    "model",
    "clock",
    "refused",
    "bug",
    "crash",
    "time-out",
    "protocol",
    "killed",
    "environment",
    "unsolved",
    # Of runs that were not made ("clamp" too).
    "effects",
    "body",
    "timestep",
    "scene",
    # Of runs that finished.
    "lost",
    "law",
]

#: Causes in the machine, not in the engine: the run may succeed if repeated.
ENVIRONMENTAL: frozenset[Cause] = frozenset({"killed", "environment"})
#: Causes that no smaller timestep removes: such a run is `failed`, not `diverged`.
WRONG_AT_ANY_TIMESTEP: frozenset[Cause] = ENVIRONMENTAL | frozenset(
    {"clock", "crash", "time-out", "protocol"}
)


@dataclass(frozen=True)
class Fault:
    """The first bad state of several.

    Attributes
    ----------
    index : which one
    cause, reason : what is bad about it, in a word and in words
    """

    index: int
    cause: Cause
    reason: str
