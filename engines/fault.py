"""The causes of a run's failure, one word each, and the sample at which it failed."""

from dataclasses import dataclass
from typing import Literal

#: The causes of failures; docs/explanation/outcomes.md says what each means and how it is detected.
Cause = Literal[
    "",
    # Causes of runs that diverged: the motion became wrong at some time.
    "not-finite",
    "not-unit",
    "reset",
    "clamp",
    "pivot",
    "energy",
    "warning",
    # Causes of runs that failed: the result is no motion of the scene, at any timestep.
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
    # Causes of runs that were not made ("clamp" above is one too).
    "effects",
    "body",
    "timestep",
    "scene",
    # Causes noted in runs that finished.
    "lost",
    "law",
]

#: Causes in the machine, not in the engine: the run may succeed if it is repeated.
ENVIRONMENTAL: frozenset[Cause] = frozenset({"killed", "environment"})
#: Causes that no smaller timestep removes: a run with one of these is `failed`, not `diverged`.
WRONG_AT_ANY_TIMESTEP: frozenset[Cause] = ENVIRONMENTAL | frozenset(
    {"clock", "crash", "time-out", "protocol"}
)


@dataclass(frozen=True)
class Fault:
    """What is wrong with a state of a run.

    A check of several states finds the first state that is wrong in this way.

    Attributes
    ----------
    index : index of the state among those that were checked
    cause : what is wrong with the state, in one word
    reason : what is wrong with the state, in a sentence
    """

    index: int
    cause: Cause
    reason: str
