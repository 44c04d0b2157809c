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

#: States are checked in blocks: a check takes as long as thousands of steps, and hardly longer for
#: many states than for few. A block has at least `FIRST_BLOCK` states, about `BLOCK_STEPS` steps,
#: and as many states as all blocks before it, but never more than `BLOCK` states. So the steps
#: taken after an undetected fault at most double the run, or cost no more than a check.
FIRST_BLOCK = 1 << 4
BLOCK_STEPS = 1 << 14
BLOCK = 1 << 11
#: A state of zero rows.
NOTHING = State(np.empty((0, 4)), *(np.empty((0, 3)) for _ in range(3)))


@dataclass(frozen=True, eq=False)
class Sampled:
    """The valid samples of a run, or of a block of a run, and how it ended.

    Attributes
    ----------
    states : the samples, one a row; no rows if the first sample was invalid
    outcome : how the run, or block, ended
    reason, cause : why there are no more samples, in words and in a word; empty if the outcome is
        ok
    """

    states: State
    outcome: Outcome = "ok"
    reason: str = ""
    cause: Cause = ""

    @property
    def count(self) -> int:
        """Number of valid samples."""
        return len(self.states.omega_body)


def sample(session: Session, sample_steps: NDArray[np.int64], bounds: Bounds) -> Sampled:
    """Step through all the samples, or until the engine diverges or fails; return the valid ones.

    Parameters
    ----------
    session : a session that has taken no step yet
    sample_steps : (n,) increasing whole numbers of steps, the first of them 0
    bounds : bounds that every state must keep; the run diverges where one does not

    Raises
    ------
    EngineError
        If the arrays of several states do not have the shapes of one state, and a row for each.
    OSError, MemoryError
        If a step raises it, as the machine may be at fault. Any other error that a step raises
        ends the run as failed.
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
    """Yield the index of the first sample of each block, and of the first sample after it.

    `steps` are the numbers of steps up to each sample, increasing, (n,).
    """
    first = 0
    while first < len(steps):
        worth_a_look = int(np.searchsorted(steps, steps[first] + BLOCK_STEPS))
        beyond = max(2 * first, FIRST_BLOCK, worth_a_look)
        beyond = min(beyond, first + BLOCK, len(steps))
        yield first, beyond
        first = beyond


def _read(session: Session, strides: Sequence[int]) -> tuple[list[Any], Sampled]:
    """Return the snapshots of a block, and how the block ended, without states.

    `strides` are the numbers of steps before each snapshot. If the engine stopped, there are fewer
    snapshots than strides. `OSError` and `MemoryError` are not caught.
    """
    snapshots: list[Any] = []
    try:
        session.record(strides, snapshots.append)
    except EngineError as error:
        # Genesis keeps the last state that was finite.
        blown_up = error.cause if error.cause == "not-finite" else _blown_up(session)
        if blown_up and error.cause not in WRONG_AT_ANY_TIMESTEP:
            return snapshots, Sampled(NOTHING, "diverged", str(error), error.cause or blown_up)
        return snapshots, Sampled(NOTHING, "failed", str(error), error.cause or "refused")
    except (OSError, MemoryError):
        # Possibly the machine is at fault, which the caller decides.
        raise
    except Exception as error:  # After a bug in an adapter the samples so far are kept.
        return snapshots, Sampled(
            NOTHING, "failed", f"{type(error).__name__}: {error}".removesuffix(": "), "bug"
        )
    return snapshots, Sampled(NOTHING)


def _blown_up(session: Session) -> Cause:
    """Return the cause if the state at which an engine stopped is invalid; empty if it is valid."""
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
    snapshots, states : the block's n snapshots, and the n states that they stand for
    end : how the block ended as far as known before its states are checked
    """
    block_faults = list(faults(states, bounds))
    if fault := session.first_fault(snapshots, states):
        block_faults.insert(0, fault)
    elif end.outcome == "ok":
        try:
            session.check()
        except EngineError as error:
            # The engine stopped at some step of the block; which one is not known.
            block_faults.insert(0, Fault(0, error.cause or "warning", str(error)))
    if not block_faults:
        return replace(end, states=states)
    worst = min(block_faults, key=lambda fault: fault.index)
    outcome: Outcome = "failed" if worst.cause in WRONG_AT_ANY_TIMESTEP else "diverged"
    return Sampled(states.rows(slice(worst.index)), outcome, worst.reason, worst.cause)
