"""Whether a memory that vanishes with the timestep explains a run that differs from its replays."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ....engines import Engine, State
from ....engines.checks.equations import Equations
from ....engines.checks.read_back import stacked
from ....scenarios import FloatArray
from ...results.evidence import LEVEL, ReplayEvidence
from .gain_series import fitted
from .intervals import Replay, restarted
from .noise import NOISE, SIGMAS, SOLVED, ULPS
from .places import HALVINGS, states_of
from .regression import PREDICTED_FROM
from .steps import Sessions, apart

#: Steps that a method may remember.
REMEMBERED = 8
#: A memory of so few steps explains a difference if it leaves no more than this part of it.
UNEXPLAINED = 0.5


def explained_by_memory(
    replay: Replay, engine: Engine, declared: int, settled: int
) -> ReplayEvidence:
    """What a replay shows, where a memory that vanishes with the timestep may explain it.

    The intervals in which the run differs the most are run again from its states some steps before
    each: at once, and with the restarts of the replay. With the run's timestep, these two must
    differ as the run and its replay do; in size alone, where that is no more than is left by an
    iterative solver that begins with the step before. Over few steps, with shorter and shorter
    timesteps, their difference is a gain like any other, which must vanish. Of a method whose steps
    are those of a settled constraint, impulses of earlier steps are in what these gain, so that the
    first suffices.

    Parameters
    ----------
    declared : the method's order
    settled : steps in which a constraint settled before those that were examined
    """
    shown, intervals = replay.evidence, replay.intervals
    if shown.tail >= LEVEL or shown.spread:
        return shown
    before, starts = _earlier(replay, max(REMEMBERED, settled))
    parts = intervals.parts_of(replay.worst)
    lost = _lost(intervals.sessions, starts, shown.timestep, before, parts)
    off, left = _largest(replay.off), _largest(replay.off - lost)
    if off <= SOLVED:
        # What an iterative solver leaves is of a size alone.
        left = off - _largest(lost)
    if not left <= UNEXPLAINED * off:
        return shown
    order, tail = (declared, 1.0) if settled else _vanishing(replay, engine, declared)
    if tail < LEVEL:
        return shown
    return replace(shown, tail=tail, order=order, declared=declared)


def _largest(off: FloatArray) -> float:
    return float(np.sqrt((off**2).sum(axis=(1, 2))).max())


def _earlier(replay: Replay, steps: int) -> tuple[NDArray[np.int64], State]:
    """The run's states at its last samples at least so many steps before the worst intervals.

    Returns
    -------
    How many steps each is before its interval, (K,), and the states there.
    """
    run, edges = replay.intervals.run, replay.intervals.edges[replay.worst]
    taken = run.rung.sample_steps
    samples = np.maximum(np.searchsorted(taken, taken[edges] - steps, side="right") - 1, 0)
    return taken[edges] - taken[samples], states_of(run.motion).rows(samples)


def _vanishing(replay: Replay, engine: Engine, declared: int) -> tuple[int, float]:
    """The order at which a memory of few steps vanishes, and the tail of its gains.

    The tail is 0 where there is none. Of the longest timesteps alone there is no order.
    """
    starts, sessions = replay.intervals.starts.rows(replay.worst), replay.intervals.sessions
    timesteps = np.array([replay.evidence.timestep / 2.0**j for j in range(HALVINGS)])
    before = np.full(len(replay.worst), REMEMBERED)
    parts = np.stack([before // 2, before // 2], axis=1)
    lost = np.stack([_lost(sessions, starts, float(h), before, parts) for h in timesteps])
    noise = max(NOISE, ULPS * engine.ulp) * np.sqrt(REMEMBERED)
    gains, table = lost / timesteps[:, None, None, None], np.empty(lost.shape[:2])
    table[:] = noise / timesteps[:, None]
    series = [fitted(timesteps, gains[:, :, q], table, LEVEL) for q in range(lost.shape[2])]
    seen = np.abs(lost).max(axis=(1, 3)) > SIGMAS * noise
    if not seen.any():
        return 0, 0.0
    of_order = seen[PREDICTED_FROM:].any(axis=0)
    orders = [one.order for one, is_seen in zip(series, of_order, strict=True) if is_seen]
    tail = min(1.0, *(len(series) * one.tail for one in series))
    return min(orders, default=declared), tail


def _lost(
    sessions: Sessions,
    starts: State,
    timestep: float,
    before: NDArray[np.int64],
    parts: NDArray[np.int64],
) -> FloatArray:
    """How much restarts change where steps from K states end, as `apart` has it, (K, 5, 3).

    Parameters
    ----------
    before : steps before the first restart, (K,)
    parts : steps before and after the second, (K, 2)
    """
    at_once, others = [], []
    for k, each in enumerate(parts):
        with sessions.at(starts.rows(k), timestep) as session:
            if before[k]:
                session.advance(int(before[k]))
            state = session.read_state()
            session.advance(int(each.sum()))
            at_once.append(session.read_state())
        others.append(restarted(sessions, state, timestep, each)[-1])
    reach = Equations(sessions.scenario).reach
    return apart(stacked(others), stacked(at_once), reach)
