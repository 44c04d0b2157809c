"""The loop that every run goes through: step, read, and look at what was read."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from ..scenarios import FloatArray, Trajectory
from .read_back import EngineError, State
from .run import Outcome
from .session import Session

#: Samples read before they are looked at, all at once: one by one, looking takes longer than ten
#: steps do. A run that has gone wrong unnoticed is stepped on for so many samples at most.
BLOCK = 512


@dataclass(frozen=True, eq=False)
class Sampled:
    """The good samples of a run, and how it ended.

    Attributes
    ----------
    states : one a row; no rows where the first sample was bad
    reason : why there are no more; empty where the outcome is ok
    """

    states: State
    outcome: Outcome
    reason: str

    @property
    def count(self) -> int:
        """How many good samples there are."""
        return len(self.states.omega_body)


def sample(session: Session, sample_steps: Sequence[int], timestep: float, most: float) -> Sampled:
    """Step through all the samples, or until the engine diverges or fails.

    Parameters
    ----------
    sample_steps : increasing whole numbers of steps, the first of them 0
    timestep : s
    most : rad a step, beyond which the engine clamps the rotation
    """
    parts: list[Sampled] = []
    taken = 0
    for first in range(0, len(sample_steps), BLOCK):
        block = sample_steps[first : first + BLOCK]
        snapshots, outcome, reason = _read(session, taken, block)
        taken = block[-1]
        if snapshots:
            # What has blown up may overflow here; it is found to be infinite then.
            with np.errstate(all="ignore"):
                parts.append(_looked_at(session, snapshots, outcome, reason, timestep, most))
            outcome, reason = parts[-1].outcome, parts[-1].reason
        if outcome != "ok":
            break
    return Sampled(_stacked([part.states for part in parts]), outcome, reason)


def clamped_turn(speed: float, timestep: float, most: float) -> str:
    """Say so if the body turns further in a step than the engine lets it; else empty.

    Parameters
    ----------
    speed, timestep, most : |ω| in rad/s, s, and rad a step
    """
    if speed * timestep <= most:
        return ""
    return (
        f"the rotation a step, {speed * timestep:.3g} rad, is beyond {most:.3g} rad, "
        "where the engine clamps it"
    )


def _read(
    session: Session, taken: int, sample_steps: Sequence[int]
) -> tuple[list[Any], Outcome, str]:
    """Snapshots of a block; fewer where the engine stopped, how it ended then, and why."""
    snapshots: list[Any] = []
    advance, snapshot, keep = session.advance, session.snapshot, snapshots.append
    try:
        for wanted in sample_steps:
            if wanted > taken:
                advance(wanted - taken)
                taken = wanted
            keep(snapshot())
    except EngineError as error:
        return snapshots, "diverged" if _blew_up(session) else "failed", str(error)
    except Exception as error:  # A bug in an adapter costs the rest of the run, not its beginning.
        return snapshots, "failed", f"{type(error).__name__}: {error}"
    return snapshots, "ok", ""


def _blew_up(session: Session) -> bool:
    """Whether it is the motion that an engine stopped for, and not some trouble of its own."""
    try:
        session.check()
        state = session.read_state()
    except EngineError:
        return True
    return not all(np.isfinite(values).all() for values in vars(state).values())


def _looked_at(
    session: Session,
    snapshots: list[Any],
    outcome: Outcome,
    reason: str,
    timestep: float,
    most: float,
) -> Sampled:
    """A block's states up to the first that is bad."""
    states = session.states(snapshots)
    faults = list(_faults(states, timestep, most))
    if found := session.first_fault(snapshots, states):
        faults.insert(0, found)
    elif outcome == "ok":
        try:
            session.check()
        except EngineError as error:
            # It happened somewhere in the block.
            faults.insert(0, (0, str(error)))
    if not faults:
        return Sampled(states, outcome, reason)
    kept, fault = min(faults, key=lambda index_and_reason: index_and_reason[0])
    return Sampled(_stacked([states], kept), "diverged", fault)


def _faults(states: State, timestep: float, most: float) -> Iterator[tuple[int, str]]:
    """Index and reason of the first sample that is bad, for each way in which it can be."""
    finite = [np.isfinite(column) for column in _columns(states)]
    if not all(part.all() for part in finite):
        yield _first(~np.hstack(finite).all(axis=1)), "the state is no longer finite"
    norms = np.linalg.norm(states.q_world_body_wxyz, axis=1)
    off = np.abs(norms - 1) > Trajectory.UNIT_NORM_SLACK
    if off.any():
        yield _first(off), f"the attitude's quaternion is of norm {norms[_first(off)]:.3g}"
    speeds = np.linalg.norm(states.omega_body, axis=1)
    clamped = speeds * timestep > most
    if clamped.any():
        yield _first(clamped), clamped_turn(float(speeds[_first(clamped)]), timestep, most)


def _first(bad: Any) -> int:
    return int(np.argmax(bad))


def _columns(states: State) -> list[FloatArray]:
    return [getattr(states, field.name) for field in fields(State)]


def _stacked(parts: Sequence[State], count: int | None = None) -> State:
    """The rows of all parts, or the first `count` of them."""
    if not parts:
        return State(np.empty((0, 4)), *(np.empty((0, 3)) for _ in range(3)))
    columns = zip(*(_columns(part) for part in parts), strict=True)
    return State(*(np.concatenate(column)[:count] for column in columns))
