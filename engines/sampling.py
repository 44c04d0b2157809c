"""The loop of every run: step, read, and check the states that were read."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .checks.faults import Bounds, faults
from .checks.read_back import EngineError, State, stacked
from .checks.shapes import check_shapes
from .fault import WRONG_AT_ANY_TIMESTEP, Cause, Fault
from .run import Outcome
from .session import Session

#: States are checked in blocks, because a check takes as long as thousands of steps, and hardly
#: longer for many states than for few. A block has at least `FIRST_BLOCK` states, about
#: `BLOCK_STEPS` steps, and as many states as all blocks before it, but never more than `BLOCK`
#: states. So the steps that are taken between a fault and its detection are at most as many as
#: those before it, or cost no more than a check.
FIRST_BLOCK = 1 << 4
BLOCK_STEPS = 1 << 14
BLOCK = 1 << 11
#: No states: arrays without rows.
NOTHING = State(np.empty((0, 4)), *(np.empty((0, 3)) for _ in range(3)))


@dataclass(frozen=True, eq=False)
class Sampled:
    """The valid samples of a run, or of a block of a run, and how it ended.

    Attributes
    ----------
    states : the valid samples, one a row; no rows if the first sample was invalid
    outcome : how the run, or block, ended
    reason : why there are no more samples, in words; empty if the outcome is ok
    cause : the reason in one word; empty if the outcome is ok
    """

    states: State
    outcome: Outcome = "ok"
    reason: str = ""
    cause: Cause = ""

    @property
    def count(self) -> int:
        """The number of valid samples."""
        return len(self.states.omega_body)


def sample(session: Session, sample_steps: NDArray[np.int64], bounds: Bounds) -> Sampled:
    """Take the steps of a run until the last sample or a fault; return the valid samples.

    Parameters
    ----------
    session : a session that has taken no step yet
    sample_steps : numbers of steps from the start to each of n samples, increasing from 0, (n,)
    bounds : bounds that every state must keep; the run diverges at the first state outside them

    Raises
    ------
    EngineError
        If `session.states` returns arrays of wrong shapes.
    OSError, MemoryError
        If a step raises it: the machine may be at fault. Any other error that a step raises ends
        the run as failed.
    """
    parts: list[State] = []
    end, start = Sampled(NOTHING), session.read_state()
    for first, beyond in _blocks(sample_steps):
        taken = int(sample_steps[first - 1]) if first else 0
        strides = np.diff(sample_steps[first:beyond], prepend=taken)
        snapshots, end = _read(session, strides.tolist())
        if snapshots:
            # After a blow-up this may overflow; the state is then detected as infinite.
            with np.errstate(all="ignore"):
                states = session.states(snapshots)
                by = f"{type(session).__name__}.states"
                check_shapes(states, start, by, len(snapshots))
                end = _checked(session, snapshots, states, end, bounds)
            parts.append(end.states)
        if end.outcome != "ok":
            break
    return replace(end, states=stacked(parts or [NOTHING]))


def _blocks(steps: NDArray[np.int64]) -> Iterator[tuple[int, int]]:
    """Yield for each block the index of its first sample, and of the first sample after it.

    A block is a number of successive samples that are checked together. `steps` are the numbers of
    steps from the start to each of n samples, increasing, (n,).
    """
    first = 0
    while first < len(steps):
        worth_a_look = int(np.searchsorted(steps, steps[first] + BLOCK_STEPS))
        beyond = max(2 * first, FIRST_BLOCK, worth_a_look)
        beyond = min(beyond, first + BLOCK, len(steps))
        yield first, beyond
        first = beyond


def _read(session: Session, strides: Sequence[int]) -> tuple[list[Any], Sampled]:
    """Take the steps of a block; return its snapshots, and a `Sampled` without states yet.

    `strides` has the number of steps to take before each snapshot. The `Sampled` says how the block
    ended. If the engine stopped, there are fewer snapshots than strides. `OSError` and
    `MemoryError` are not caught.
    """
    snapshots: list[Any] = []
    try:
        session.record(strides, snapshots.append)
    except EngineError as error:
        # Genesis has the last finite state then, so that the state would not show the blow-up.
        blown_up = error.cause if error.cause == "not-finite" else _blown_up(session)
        if blown_up and error.cause not in WRONG_AT_ANY_TIMESTEP:
            return snapshots, Sampled(NOTHING, "diverged", str(error), error.cause or blown_up)
        return snapshots, Sampled(NOTHING, "failed", str(error), error.cause or "refused")
    except (OSError, MemoryError):
        # The machine may be at fault: the caller decides.
        raise
    except Exception as error:  # A bug in an adapter: the samples before it are kept.
        return snapshots, Sampled(
            NOTHING, "failed", f"{type(error).__name__}: {error}".removesuffix(": "), "bug"
        )
    return snapshots, Sampled(NOTHING)


def _blown_up(session: Session) -> Cause:
    """Return, in one word, why the state at which an engine stopped is invalid; empty if valid."""
    try:
        session.check()
        state = session.read_state()
    except EngineError as error:
        return error.cause or "warning"
    return "" if all(np.isfinite(values).all() for values in vars(state).values()) else "not-finite"


def _checked(
    session: Session, snapshots: list[Any], states: State, end: Sampled, bounds: Bounds
) -> Sampled:
    """Return a block's states before the first invalid one, and how the block ended.

    Parameters
    ----------
    session : the session that took the snapshots
    snapshots : the block's n snapshots
    states : the n states that the snapshots were converted to
    end : how the block ended by what the engine reported, before its states are checked
    bounds : bounds that every state must keep
    """
    block_faults = list(faults(states, bounds))
    if fault := session.first_fault(snapshots, states):
        block_faults.insert(0, fault)
    elif end.outcome == "ok":
        try:
            session.check()
        except EngineError as error:
            # The trouble began in some step of the block; which one is not known.
            block_faults.insert(0, Fault(0, error.cause or "warning", str(error)))
    if not block_faults:
        return replace(end, states=states)
    worst = min(block_faults, key=lambda fault: fault.index)
    outcome: Outcome = "failed" if worst.cause in WRONG_AT_ANY_TIMESTEP else "diverged"
    return Sampled(states.rows(slice(worst.index)), outcome, worst.reason, worst.cause)
