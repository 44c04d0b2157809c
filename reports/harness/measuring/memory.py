"""Decides whether a memory of a few steps explains the difference of a run from its replays.

A method may use results of earlier steps, such as the impulses with which an iterative solver
begins. A session that has been restarted does not have these results. If the difference that this
makes vanishes with the timestep, it is no fault.
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
    """Return the evidence of a replay, without a fault if a memory that vanishes explains it.

    Evidence without a fault, or of replays that differ from each other, is returned as it is. Else
    the intervals in which the run differs the most are run again, from a state of the run some
    steps earlier: once without a restart, and once with the restarts of the replay. Two conditions
    are checked:

    - At the run's timestep, the difference of these two must agree with the difference of the run
      from its replay, up to half the size of the latter. If the latter is no larger than the
      residual of an iterative solver, only the sizes of the two differences are compared.
    - Over a few steps, at shorter and shorter timesteps, the difference must vanish, as any gain
      must. This is not checked if steps were judged after a constraint had settled, as the gains of
      these steps contain the effect of impulses of earlier steps.

    Parameters
    ----------
    replay : the differences between the run and the replays of its intervals
    settled : number of steps in which a constraint settled before the steps that were examined
    """
    shown, intervals = replay.evidence, replay.intervals
    declared = intervals.sessions.method.order
    if shown.tail >= LEVEL or shown.spread:
        return shown
    before, starts = _earlier(replay, max(FEW, settled))
    parts = intervals.parts_of(replay.worst)
    effect = _effect_of_restarts(intervals.sessions, starts, shown.timestep, before, parts)
    with np.errstate(invalid="ignore"):
        off, without = np.linalg.norm([replay.off, replay.off - effect], axis=(2, 3)).max(axis=1)
    # The residual of an iterative solver is reproducible in its size only.
    remainder = off - np.linalg.norm(effect, axis=(1, 2)).max() if off <= SOLVED else without
    if not remainder <= off / 2:
        return shown
    order, tail = (declared, 1.0) if settled else _order_and_tail(replay, declared)
    if tail < LEVEL:
        return shown
    return replace(shown, tail=tail, order=order, declared=declared)


def _earlier(replay: Replay, steps: int) -> tuple[NDArray[np.int64], State]:
    """Return the state of the run at an earlier sample for each of the K worst intervals.

    These are the intervals in which the run differs the most from its replay. The sample is the
    last one at least `steps` steps before the interval begins, or the first one of the run.

    Returns
    -------
    The number of steps from each sample to its interval, (K,), and the K states at the samples
    """
    run, edges = replay.intervals.run, replay.intervals.edges[replay.worst]
    taken = run.rung.sample_steps
    samples = np.maximum(np.searchsorted(taken, taken[edges] - steps, side="right") - 1, 0)
    return taken[edges] - taken[samples], states_of(run.motion).rows(samples)


def _order_and_tail(replay: Replay, declared: int) -> tuple[int, float]:
    """Return the order with which the effect of a restart vanishes, and the tail of its gains.

    The gains are the change of the final state by two restarts, divided by the timestep. Order and
    tail are 0 if no effect is seen above noise: then a memory explains nothing. The order is the
    declared order if only the longest timesteps show an effect, as these are too few to estimate an
    order.

    Parameters
    ----------
    replay : the replays of a run, from whose worst intervals the states are taken
    declared : the declared order
    """
    starts, sessions = replay.intervals.starts.rows(replay.worst), replay.intervals.sessions
    timesteps = np.array([replay.evidence.timestep / 2.0**j for j in range(HALVINGS)])
    before = np.full(len(replay.worst), FEW)
    parts = np.stack([before // 2, before // 2], axis=1)
    effect = np.stack(
        [_effect_of_restarts(sessions, starts, float(h), before, parts) for h in timesteps]
    )
    noise = max(NOISE, ULPS * sessions.engine.ulp) * np.sqrt(FEW)
    gains = effect / timesteps[:, None, None, None]
    table = np.outer(noise / timesteps, np.ones(len(before)))
    series = [fitted(timesteps, gains[:, :, q], table, LEVEL) for q in range(effect.shape[2])]
    seen = np.abs(effect).max(axis=(1, 3)) > SURE * noise
    if not seen.any():
        return 0, 0.0
    of_order = seen[PREDICTED_FROM:].any(axis=0)
    orders = [one.order for one, is_seen in zip(series, of_order, strict=True) if is_seen]
    tail = min(1.0, *(len(series) * one.tail for one in series))
    return min(orders, default=declared), tail


def _effect_of_restarts(
    sessions: Sessions,
    starts: State,
    timestep: float,
    before: NDArray[np.int64],
    parts: NDArray[np.int64],
) -> FloatArray:
    """Return how far two restarts change the states in which K short runs end, (K, 5, 3).

    The five quantities are attitude, rad; and ω, the com's velocity, its position and spins,
    relative to their sizes.

    Parameters
    ----------
    starts : the states in which the K runs begin
    timestep : s
    before : number of steps before the first restart, (K,)
    parts : numbers of steps between the two restarts, and after the second restart, (K, 2)
    """
    uninterrupted, with_restarts = [], []
    for k, each in enumerate(parts):
        with sessions.at(starts.rows(k), timestep) as session:
            if before[k]:
                session.advance(int(before[k]))
            state = session.read_state()
            session.advance(int(each.sum()))
            uninterrupted.append(session.read_state())
        with_restarts.append(restarted(sessions, state, timestep, each))
    reach = Equations(sessions.scenario).reach
    return state_differences(stacked(with_restarts), stacked(uninterrupted), reach)
