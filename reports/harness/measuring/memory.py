"""Whether a memory of a few steps explains why a run differs from its replays.

A method may use results of earlier steps, such as the impulses with which an iterative solver
begins. A session that is restarted has none. That is no fault if the difference vanishes with the
timestep.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ....engines import State
from ....engines.checks.equations import Equations
from ....engines.checks.read_back import stacked
from ....scenarios import FloatArray
from ...results.evidence import LEVEL, ReplayEvidence
from .gain_series import fitted
from .intervals import Replay, restarted
from .noise import NOISE, SOLVED, SURE, ULPS
from .places import HALVINGS, states_of
from .regression import PREDICTED_FROM
from .steps import FEW, Sessions, state_differences


def explained_by_memory(replay: Replay, settled: int) -> ReplayEvidence:
    """Return what a replay shows, without a fault if a memory that vanishes explains it.

    The intervals in which the run differs the most are run again, from a state of the run some
    steps earlier: once without a restart, and once with the restarts of the replay. Two conditions
    are checked:

    - With the run's timestep these two differ as the run and its replay do, to half of that. If the
      difference is no larger than an iterative solver may leave, its size alone is compared.
    - Over few steps, with shorter and shorter timesteps, their difference vanishes, as any gain
      must. This is not needed where steps were judged after a constraint had settled: their gains
      contain the impulses of earlier steps.

    Parameters
    ----------
    settled : steps in which a constraint settled before those that were examined
    """
    shown, intervals = replay.evidence, replay.intervals
    declared = intervals.sessions.method.order
    if shown.tail >= LEVEL or shown.spread:
        return shown
    before, starts = _earlier(replay, max(FEW, settled))
    parts = intervals.parts_of(replay.worst)
    lost = _lost(intervals.sessions, starts, shown.timestep, before, parts)
    with np.errstate(invalid="ignore"):
        off, without = np.linalg.norm([replay.off, replay.off - lost], axis=(2, 3)).max(axis=1)
    # What an iterative solver leaves is of a size alone.
    left = off - np.linalg.norm(lost, axis=(1, 2)).max() if off <= SOLVED else without
    if not left <= off / 2:
        return shown
    order, tail = (declared, 1.0) if settled else _vanishing(replay, declared)
    if tail < LEVEL:
        return shown
    return replace(shown, tail=tail, order=order, declared=declared)


def _earlier(replay: Replay, steps: int) -> tuple[NDArray[np.int64], State]:
    """The states of the run at least so many steps before each of the worst intervals.

    They are those of the run's samples.

    Returns
    -------
    How many steps each is before its interval, (K,), and the states
    """
    run, edges = replay.intervals.run, replay.intervals.edges[replay.worst]
    taken = run.rung.sample_steps
    samples = np.maximum(np.searchsorted(taken, taken[edges] - steps, side="right") - 1, 0)
    return taken[edges] - taken[samples], states_of(run.motion).rows(samples)


def _vanishing(replay: Replay, declared: int) -> tuple[int, float]:
    """The order with which the effect of a memory vanishes, and the tail of its gains.

    The tail is 0 if there is no effect. The order is the declared one if only the longest timesteps
    show an effect, as two of them tell no order.
    """
    starts, sessions = replay.intervals.starts.rows(replay.worst), replay.intervals.sessions
    timesteps = np.array([replay.evidence.timestep / 2.0**j for j in range(HALVINGS)])
    before = np.full(len(replay.worst), FEW)
    parts = np.stack([before // 2, before // 2], axis=1)
    lost = np.stack([_lost(sessions, starts, float(h), before, parts) for h in timesteps])
    noise = max(NOISE, ULPS * sessions.engine.ulp) * np.sqrt(FEW)
    gains = lost / timesteps[:, None, None, None]
    table = np.outer(noise / timesteps, np.ones(len(before)))
    series = [fitted(timesteps, gains[:, :, q], table, LEVEL) for q in range(lost.shape[2])]
    seen = np.abs(lost).max(axis=(1, 3)) > SURE * noise
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
    """How much a restart changes the states that K stretches of steps end in, (K, 5, 3).

    The quantities are those of `state_differences`.

    Parameters
    ----------
    before : steps before the first restart, (K,)
    parts : steps between the two restarts, and after the second one, (K, 2)
    """
    at_once, others = [], []
    for k, each in enumerate(parts):
        with sessions.at(starts.rows(k), timestep) as session:
            if before[k]:
                session.advance(int(before[k]))
            state = session.read_state()
            session.advance(int(each.sum()))
            at_once.append(session.read_state())
        others.append(restarted(sessions, state, timestep, each))
    reach = Equations(sessions.scenario).reach
    return state_differences(stacked(others), stacked(at_once), reach)
