"""The intervals of a run, each of which is replayed: run again from its own start."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....engines import State
from ....engines.checks.equations import Equations
from ....engines.checks.read_back import stacked
from ....scenarios import FloatArray, Scenario, Trajectory
from ....scenarios.fastest_rate import fastest_rate
from ...results.evidence import ReplayEvidence
from ..comparison.defects import FARTHEST_TURN
from ..timesteps.ladder import DECIDED_STEPS, Rung
from .places import FINER, Places, states_of
from .regression import LEAST
from .steps import FEW, Sessions, Steps, flowed, step_gains

#: The most intervals of a run.
INTERVALS = 64


@dataclass(frozen=True, eq=False)
class MadeRun:
    """A run that came to its end.

    Attributes
    ----------
    rung : its timestep, and the numbers of steps before its samples
    motion : its motion at the samples
    """

    rung: Rung
    motion: Trajectory


@dataclass(frozen=True, eq=False)
class Intervals:
    """The n intervals of a run, each of which is replayed: run again from its own start.

    Attributes
    ----------
    edges : the indices of the samples at which intervals begin and end, (n + 1,)
    parts : number of steps after which the replay of each interval is restarted, (n,)
    """

    sessions: Sessions
    run: MadeRun
    edges: NDArray[np.intp]
    parts: NDArray[np.int64]

    @staticmethod
    def of(sessions: Sessions, run: MadeRun) -> "Intervals":
        """Divide a whole run into intervals of random lengths."""
        edges = _edges(len(run.motion.t), sessions.first.can_restart)
        steps = np.diff(run.rung.sample_steps[edges])
        chance = np.random.default_rng(len(edges))
        return Intervals(sessions, run, edges, chance.integers(1, np.maximum(steps, 2)))

    @cached_property
    def steps(self) -> NDArray[np.int64]:
        """Number of steps of each of the n intervals, (n,)."""
        return np.diff(self.run.rung.sample_steps[self.edges])

    @cached_property
    def starts(self) -> State:
        """The n states in which intervals begin."""
        return states_of(self.run.motion).rows(self.edges[:-1])

    @cached_property
    def ends(self) -> State:
        """The n states in which intervals end in the run."""
        return states_of(self.run.motion).rows(self.edges[1:])

    def some_again(self, kept: NDArray[np.intp], starts: State) -> State:
        """Run K of the intervals from given starts, and return the K states in which they end.

        The session is restarted once in each interval, after the number of steps in `parts`, so
        that a fault in step with the samples does not act alike in run and replay.

        Parameters
        ----------
        kept : indices of the intervals, (K,)
        starts : K states
        """
        timestep, ends = self.run.rung.timestep, []
        for k, parts in enumerate(self.parts_of(kept)):
            ends.append(restarted(self.sessions, starts.rows(k), timestep, parts))
        return stacked(ends)

    def parts_of(self, kept: Sequence[int] | NDArray[np.intp]) -> NDArray[np.int64]:
        """Return the numbers of steps before and after the restart in K of the intervals, (K, 2).

        Parameters
        ----------
        kept : indices of the intervals, (K,)
        """
        first = self.parts[kept]
        return np.stack([first, self.steps[kept] - first], axis=1)

    def all_again(self) -> "Passage":
        """Run all intervals from their own starts, in random order, and read states on the way.

        The state is read after every step. In a run of more than `DECIDED_STEPS` steps it is read
        after every m-th step, so that about `DECIDED_STEPS` states are read. The result is in order
        of time.
        """
        order = np.random.default_rng(len(self.steps)).permutation(len(self.steps))
        each = -(-int(self.steps.sum()) // DECIDED_STEPS)
        made = {k: self._record(k, each) for k in map(int, order)}
        parts = [made[k] for k in sorted(made)]
        strides = np.concatenate([strides for strides, _ in parts])
        states = self.sessions.first.states([one for _, kept in parts for one in kept])
        last = np.cumsum([len(kept) for _, kept in parts]) - 1
        taken, timestep = np.cumsum(strides), self.run.rung.timestep
        after = np.flatnonzero(strides)
        return Passage(
            states.rows(last),
            states.rows(after - 1),
            states.rows(after),
            (taken[after - 1] + self.run.rung.sample_steps[0]) * timestep,
            strides[after] * timestep,
        )

    def _record(self, k: int, each: int) -> tuple[list[int], list[Any]]:
        """Run interval k again with a restart; record the engine's state after every `each` steps.

        Returns
        -------
        For each snapshot of the state, the number of steps since the snapshot before it, 0 at the
        start and after the restart; and the snapshots
        """
        start, strides, kept = self.starts.rows(k), list[int](), list[Any]()
        for count in self.parts_of([k])[0].tolist():
            part = [0, *np.diff([*range(0, count, each), count]).tolist()]
            if kept:
                start = self.sessions.first.states(kept[-1:]).rows(0)
            with self.sessions.at(start, self.run.rung.timestep) as session:
                session.record(part, kept.append)
            strides += part
        return strides, kept


@dataclass(frozen=True, eq=False)
class Passage:
    """The states that the replays of a run's n intervals pass through, in order of time.

    Attributes
    ----------
    ends : the n states in which the intervals end
    before, after : the states before and after each of N stretches of one or more steps
    times, spans : the time at which each stretch begins, and its duration, s, (N,)
    """

    ends: State
    before: State
    after: State
    times: FloatArray
    spans: FloatArray

    def places(self, scenario: Scenario, at: Places, *, is_single: bool) -> Places | None:
        """Return states of the run from which single steps are examined, and the steps' timesteps.

        A fault may act in few states only, or only on the motion that the method itself computes.
        So random states are chosen, and the states in which the gain of a step differs most from
        the gains of the steps before and after it. Only the shortest timesteps are used, as many as
        a limit needs.

        Parameters
        ----------
        at : the exact states and timesteps from which steps were taken before
        is_single : whether the engine computes in single precision. If it does, or if a constraint
            has to settle, few states are used with all timesteps, as few timesteps would not
            determine the limit

        Returns
        -------
        None if in all chosen states the force of a one-sided constraint would have the wrong sign
        """
        is_few, count = is_single or at.gives_way, len(self.times)
        some = np.random.default_rng(count).permutation(count)
        some = some[: FEW // 2 if is_few else INTERVALS]
        kept = np.union1d(some, self._abrupt(scenario, 1 if is_few else FEW))
        kept = kept[Equations(scenario).bears(self.before.rows(kept))]
        if not len(kept):
            return None
        states, times = self.before.rows(kept), self.times[kept]
        chosen = replace(at, states=states, times=times, are_apart=False)
        return chosen if is_few else replace(chosen, timesteps=at.timesteps[-LEAST:])

    def _abrupt(self, scenario: Scenario, most: int) -> NDArray[np.intp]:
        """Return indices of the stretches whose gains differ most from those before and after.

        A gain is compared with the mean of the gains of the two neighbouring stretches. At most
        `most` stretches are chosen for each quantity. There are none if the motion turns too far to
        be followed, or has fewer than three stretches.
        """
        turn = fastest_rate(scenario, self.before.omega_body) * float(self.times[-1])
        if turn > FARTHEST_TURN or len(self.times) < 3:
            return np.zeros(0, dtype=np.intp)
        exact = flowed(scenario, self.before, self.spans)
        steps = Steps(self.spans[:1], self.spans, self.before, self.after, exact)
        gains = step_gains(Equations(scenario), steps)[0, 0]
        off = np.linalg.norm(gains[1:-1] - (gains[:-2] + gains[2:]) / 2, axis=2)
        return np.unique(1 + np.argsort(off, axis=0)[-most:])


@dataclass(frozen=True, eq=False)
class Replay:
    """The differences between a run and the replays of its n intervals.

    Attributes
    ----------
    evidence : the differences as they are stored
    worst : the indices of the K intervals that differ the most
    off : differences of the final states of these K replays from the run's, in the quantities
        and units of `state_differences`, (K, 5, 3)
    passage : the states that all replays pass through
    """

    intervals: Intervals
    evidence: ReplayEvidence
    worst: NDArray[np.intp]
    off: FloatArray
    passage: Passage


def restarted(sessions: Sessions, state: State, timestep: float, counts: Iterable[int]) -> State:
    """Return the state after stretches of steps; the session is restarted before each stretch.

    Parameters
    ----------
    state : the state before the first stretch
    timestep : s
    counts : number of steps of each stretch
    """
    for count in map(int, counts):
        with sessions.at(state, timestep) as session:
            if count:
                session.advance(count)
            state = session.read_state()
    return state


def beginning_of(sessions: Sessions, at: Places) -> MadeRun:
    """Run the first `DECIDED_STEPS` steps or so of a motion whose window takes too many steps.

    Parameters
    ----------
    at : its first state and one of its shorter timesteps are used
    """
    timestep, strides = float(at.timesteps[FINER]), [0, *[DECIDED_STEPS // INTERVALS] * INTERVALS]
    snapshots: list[object] = []
    with sessions.at(at.states.rows(0), timestep) as session:
        session.record(strides, snapshots.append)
    counts = np.cumsum(strides)
    states = sessions.first.states(snapshots)
    return MadeRun(Rung(timestep, counts), Trajectory(counts * timestep, *states.columns))


def _edges(samples: int, can_restart: bool) -> NDArray[np.intp]:
    """Return indices of the samples at which intervals begin and end: first, last, and random ones.

    There are at most `INTERVALS` intervals, or `FEW` if sessions cannot restart.

    Parameters
    ----------
    samples : number of samples of the run
    """
    most = INTERVALS if can_restart else FEW
    count = min(most, max(1, 2 * (samples - 1) // 3))
    chance = np.random.default_rng(samples)
    inner = chance.choice(np.arange(1, samples - 1), count - 1, replace=False)
    return np.sort(np.concatenate([[0, samples - 1], inner])).astype(np.intp)
