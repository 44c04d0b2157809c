"""The loop of every run: step, read, and check the states that were read."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .checks.bounds import Bounds
from .checks.faults import faults
from .checks.read_back import EngineError, State, stacked
from .checks.turn_faults import Reading
from .fault import WRONG_AT_ANY_TIMESTEP, Cause, Fault
from .run import Outcome
from .session import Session

#: States are checked in blocks: a check takes as long as thousands of steps, and hardly longer for
#: many states than for few. A block has at least `FIRST_BLOCK` states and `BLOCK_STEPS` steps, and
#: is as long as all blocks before it, up to `BLOCK` states. So the steps taken after an undetected
#: fault at most double the run, or cost no more than a check.
FIRST_BLOCK = 1 << 4
BLOCK_STEPS = 1 << 14
BLOCK = 1 << 11
#: States of which there are none.
NOTHING = State(np.empty((0, 4)), *(np.empty((0, 3)) for _ in range(3)))
#: A run of no more steps is read at every step: coarse timesteps are those that fail.
READ_THROUGHOUT = 1 << 10
#: In longer runs, so many samples, the first included, are read once more one step later.
READ_IN_PAIRS = 64


@dataclass(frozen=True, eq=False)
class Sampled:
    """The valid samples of a run, or states of a block of it, and how it ended.

    Attributes
    ----------
    states : one a row; no rows if the first was bad
    reason, cause : why there are no more, in words and in a word; empty if the outcome is ok
    """

    states: State
    outcome: Outcome = "ok"
    reason: str = ""
    cause: Cause = ""

    @property
    def count(self) -> int:
        """Number of valid ones."""
        return len(self.states.omega_body)


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
    start = NOTHING
    end = Sampled(start)
    last: list[Any] = []
    for first, beyond in _blocks(steps):
        taken = int(steps[first - 1]) if first else 0
        new, end = _read(session, np.diff(steps[first:beyond], prepend=taken).tolist())
        # The last state of the previous block is checked again, together with the one after it.
        snapshots, first = last + new, first - len(last)
        if new:
            # After a blow-up this may overflow; the state is then detected as infinite.
            with np.errstate(all="ignore"):
                states = session.states(snapshots)
                start = start if first else states.rows(slice(2))
                reading = Reading(states, steps[first : first + len(snapshots)], start)
                end = _checked(session, snapshots, reading, end, bounds)
            kept = is_sample[first : first + end.count].copy()
            kept[: len(last)] = False
            parts.append(end.states.rows(kept))
        if end.outcome != "ok":
            break
        last = snapshots[-1:]
    return replace(end, states=stacked(parts or [NOTHING]))


def _blocks(steps: NDArray[np.int64]) -> Iterator[tuple[int, int]]:
    """First and last reading of each block."""
    first = 0
    while first < len(steps):
        worth_a_look = int(np.searchsorted(steps, steps[first] + BLOCK_STEPS))
        beyond = max(2 * first, FIRST_BLOCK, worth_a_look)
        beyond = min(beyond, first + BLOCK, len(steps))
        yield first, beyond
        first = beyond


def steps_to_read(sample_steps: NDArray[np.int64]) -> NDArray[np.int64]:
    """The samples, and additional steps next to each other, as faults show best in single steps."""
    last = int(sample_steps[-1])
    if last <= READ_THROUGHOUT:
        return np.arange(last + 1)
    every = -(-len(sample_steps) // READ_IN_PAIRS)
    return np.union1d(sample_steps, sample_steps[:-1:every] + 1)


def _read(session: Session, strides: Sequence[int]) -> tuple[list[Any], Sampled]:
    """Snapshots of a block, fewer if the engine stopped; and how it ended."""
    snapshots: list[Any] = []
    try:
        session.record(strides, snapshots.append)
    except EngineError as error:
        blown_up = _blown_up(session)
        if blown_up and error.cause not in WRONG_AT_ANY_TIMESTEP:
            return snapshots, Sampled(NOTHING, "diverged", str(error), error.cause or blown_up)
        return snapshots, Sampled(NOTHING, "failed", str(error), error.cause or "refused")
    except (OSError, MemoryError):
        # Possibly the machine's fault: decided by the caller.
        raise
    except Exception as error:  # After a bug in an adapter the samples so far are kept.
        return snapshots, Sampled(NOTHING, "failed", f"{type(error).__name__}: {error}", "bug")
    return snapshots, Sampled(NOTHING)


def _blown_up(session: Session) -> Cause:
    """The cause if an engine stopped at an invalid state; empty if the state is valid."""
    try:
        session.check()
        state = session.read_state()
    except EngineError as error:
        return error.cause or "warning"
    return "" if all(np.isfinite(values).all() for values in vars(state).values()) else "not-finite"


def _checked(
    session: Session, snapshots: list[Any], reading: Reading, end: Sampled, bounds: Bounds
) -> Sampled:
    """A block's states up to the first that is bad."""
    block_faults = list(faults(reading, bounds))
    if fault := session.first_fault(snapshots, reading.states):
        block_faults.insert(0, fault)
    elif end.outcome == "ok":
        try:
            session.check()
        except EngineError as error:
            # At a step of the block that is not known.
            block_faults.insert(0, Fault(0, error.cause or "warning", str(error)))
    if not block_faults:
        return replace(end, states=reading.states)
    worst = min(block_faults, key=lambda fault: fault.index)
    outcome: Outcome = "failed" if worst.cause in WRONG_AT_ANY_TIMESTEP else "diverged"
    return Sampled(reading.states.rows(slice(worst.index)), outcome, worst.reason, worst.cause)
