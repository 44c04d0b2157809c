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
    engine, engine_version, method : names of engine and method, and the engine's version
    timestep : length of the steps, s
    outcome : ok, diverged, unsupported or failed
    reason : reason of the outcome, in words. If the outcome is ok it is empty, or it says how
        body, start or effects differ from the scene, where `Engine.run` tolerates differences
    cause : the reason in one word; empty if `reason` is
    stopped_at : the time of the first invalid sample, s; None if all samples are valid, or if the
        run ended before its first step
    trajectory : the valid samples, all of them before `stopped_at`; None if there are none
    steps : number of steps from the start to the last valid sample
    active : what the engine says acted on the body (names out of `scenarios.EFFECTS`, and anything
        else the adapter found switched on); empty if the run was not made, failed, or cannot be
        audited
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
