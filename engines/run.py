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
    reason : reason of the outcome, in words; empty if ok, except that for an engine as shipped it
        says how the engine differs from the scene
    cause : the reason in a word
    stopped_at : the time at which the run diverged or failed, s; else None
    trajectory : the valid samples, all of them before `stopped_at`; None if there are none
    steps : number of steps up to the last of these samples
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
