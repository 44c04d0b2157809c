"""The loop of every run: step, read, and check the states that were read."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .fault import WRONG_AT_ANY_TIMESTEP, Cause, Fault
from .faults import Bounds, columns, faults
from .read_back import EngineError, State
from .run import Outcome
from .session import Session
from .turn_faults import Reading

#: States read before they are looked at, all at once: a look takes as long as thousands of steps,
#: at many states hardly longer than at few. A block has no fewer states than the first, takes no
#: fewer steps than `BLOCK_STEPS`, and is as long as all blocks before it, up to a limit: a run that
#: has gone wrong unnoticed is stepped on for no longer than it has gone so far, or a look would
#: have taken as long, and for no more readings than the longest block.
FIRST_BLOCK = 1 << 4
BLOCK_STEPS = 1 << 14
BLOCK = 1 << 11
#: A run of no more steps is read at every one of them: coarse ones are those that go wrong.
READ_THROUGHOUT = 1 << 10
#: Of any other, so many samples are read once more a step later, the first of them included.
READ_IN_PAIRS = 64


@dataclass(frozen=True, eq=False)
class Sampled:
    """The good samples of a run, and how it ended.

    Attributes
    ----------
    states : one a row; no rows where the first sample was bad
    reason, cause : why there are no more, in words and in a word; empty where the outcome is ok
    """

    states: State
    outcome: Outcome
    reason: str
    cause: Cause

    @property
    def count(self) -> int:
        """How many good samples there are."""
        return len(self.states.omega_body)


@dataclass(frozen=True, eq=False)
class _Block:
    """The good states of a block, samples or not, and how it ended."""

    states: State
    outcome: Outcome = "ok"
    reason: str = ""
    cause: Cause = ""


def sample(session: Session, sample_steps: NDArray[np.int64], bounds: Bounds) -> Sampled:
    """Step through all the samples, or until the engine diverges or fails.

    Parameters
    ----------
    sample_steps : (n,) increasing whole numbers of steps, the first of them 0
    """
    steps = steps_to_read(sample_steps)
    is_sample = np.zeros(len(steps), dtype=bool)
    is_sample[np.searchsorted(steps, sample_steps)] = True
    parts: list[State] = []
    start = _stacked([])
    end = _Block(start)
    last: list[Any] = []
    for first, beyond in _blocks(steps):
        taken = int(steps[first - 1]) if first else 0
        new, end = _read(session, np.diff(steps[first:beyond], prepend=taken).tolist())
        # The last state of the block before is looked at once more, beside the one after it.
        snapshots, first = last + new, first - len(last)
        if new:
            # What has blown up may overflow here; it is found to be infinite then.
            with np.errstate(all="ignore"):
                states = session.states(snapshots)
                start = start if first else _rows(states, slice(2))
                reading = Reading(states, steps[first : first + len(snapshots)], start)
                end = _checked(session, snapshots, reading, end, bounds)
        kept = is_sample[first : first + len(end.states.omega_body)].copy()
        kept[: len(last)] = False
        parts.append(_rows(end.states, kept))
        if end.outcome != "ok":
            break
        last = snapshots[-1:]
    return Sampled(_stacked(parts), end.outcome, end.reason, end.cause)


def _blocks(steps: NDArray[np.int64]) -> Iterator[tuple[int, int]]:
    """Beginning and end of each block of these readings."""
    first = 0
    while first < len(steps):
        worth_a_look = int(np.searchsorted(steps, steps[first] + BLOCK_STEPS))
        beyond = max(2 * first, FIRST_BLOCK, worth_a_look)
        beyond = min(beyond, first + BLOCK, len(steps))
        yield first, beyond
        first = beyond


def steps_to_read(sample_steps: NDArray[np.int64]) -> NDArray[np.int64]:
    """The samples, and steps next to each other besides: a step at a time faults have a name."""
    last = int(sample_steps[-1])
    if last <= READ_THROUGHOUT:
        return np.arange(last + 1)
    every = -(-len(sample_steps) // READ_IN_PAIRS)
    return np.union1d(sample_steps, sample_steps[:-1:every] + 1)


def _read(session: Session, strides: Sequence[int]) -> tuple[list[Any], _Block]:
    """Snapshots of a block; fewer where the engine stopped, and how it ended then."""
    snapshots: list[Any] = []
    nothing = _stacked([])
    try:
        session.record(strides, snapshots.append)
    except EngineError as error:
        blown_up = _blown_up(session)
        if blown_up and error.cause not in WRONG_AT_ANY_TIMESTEP:
            return snapshots, _Block(nothing, "diverged", str(error), error.cause or blown_up)
        return snapshots, _Block(nothing, "failed", str(error), error.cause or "refused")
    except (OSError, MemoryError):
        # The machine's, perhaps; whoever made the call can tell.
        raise
    except Exception as error:  # A bug in an adapter costs the rest of the run, not its beginning.
        return snapshots, _Block(nothing, "failed", f"{type(error).__name__}: {error}", "bug")
    return snapshots, _Block(nothing)


def _blown_up(session: Session) -> Cause:
    """The cause if an engine stopped at an invalid state; empty if that state is valid."""
    try:
        session.check()
        state = session.read_state()
    except EngineError as error:
        return error.cause or "warning"
    return "" if all(np.isfinite(values).all() for values in vars(state).values()) else "not-finite"


def _checked(
    session: Session, snapshots: list[Any], reading: Reading, end: _Block, bounds: Bounds
) -> _Block:
    """A block's states up to the first that is bad."""
    block_faults = list(faults(reading, bounds))
    if fault := session.first_fault(snapshots, reading.states):
        block_faults.insert(0, fault)
    elif end.outcome == "ok":
        try:
            session.check()
        except EngineError as error:
            # At an unknown step of the block.
            block_faults.insert(0, Fault(0, error.cause or "warning", str(error)))
    if not block_faults:
        return _Block(reading.states, end.outcome, end.reason, end.cause)
    worst = min(block_faults, key=lambda fault: fault.index)
    outcome: Outcome = "failed" if worst.cause in WRONG_AT_ANY_TIMESTEP else "diverged"
    return _Block(_rows(reading.states, slice(worst.index)), outcome, worst.reason, worst.cause)


def _rows(states: State, kept: slice | NDArray[np.bool_]) -> State:
    return State(*(column[kept] for column in columns(states)))


def _stacked(parts: Sequence[State]) -> State:
    """The rows of all parts."""
    if not parts:
        return State(np.empty((0, 4)), *(np.empty((0, 3)) for _ in range(3)))
    together = zip(*(columns(part) for part in parts), strict=True)
    return State(*(np.concatenate(column) for column in together))
