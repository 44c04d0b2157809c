"""The result of simulating one scene with one method and timestep."""

from dataclasses import dataclass
from typing import Literal

from ..scenarios import Trajectory
from .fault import Cause

Outcome = Literal["ok", "diverged", "unsupported", "failed"]


@dataclass(frozen=True, eq=False)
class Run:
    """The run of one scene in one engine, with one method and timestep.

    Attributes
    ----------
    outcome : ok, diverged, unsupported or failed
    reason : why, in words; of a run that is ok empty, unless its method is the engine as shipped:
        then what differs from the scene
    cause : the same in a word
    stopped_at : s, the time at which it diverged or failed, else None
    trajectory : the samples up to there, or None where there are none
    steps : whole steps up to the last of these samples
    active : what the engine says acted on the body (names out of `scenarios.EFFECTS`, and anything
        else the adapter found switched on)
    """

    engine: str
    engine_version: str
    method: str
    timestep: float
    outcome: Outcome
    reason: str = ""
    cause: Cause = ""
    stopped_at: float | None = None
    trajectory: Trajectory | None = None
    steps: int = 0
    active: frozenset[str] = frozenset()
