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
    """A run that came to its end: its timestep and samples, and its motion at the samples."""

    rung: Rung
    motion: Trajectory


@dataclass(frozen=True, eq=False)
class Intervals:
    """The n intervals of a run, each of which is run again from its own start.

    Attributes
    ----------
    edges : the indices of the samples at which intervals begin and end, (n + 1,)
    parts : number of steps after which each interval, when it is run again, is restarted, (n,)
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
        """Number of steps of each interval, (n,)."""
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
        """Run K of the intervals from given starts; return the K states in which they end.

        Each is restarted on the way, so that a fault cannot hide in the rhythm of the samples.

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
        """Numbers of steps before and after the restart in intervals of given indices, (k, 2)."""
        first = self.parts[kept]
        return np.stack([first, self.steps[kept] - first], axis=1)

    def all_again(self) -> "Passage":
        """Run all intervals from their own starts, in random order, and read states on the way.

        The state is read after every step. In a run of more than `DECIDED_STEPS` steps it is read
        after every m-th step, so that about `DECIDED_STEPS` states are read.
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
        """Run interval k again, and record a snapshot after every `each` steps.

        Returns
        -------
        For each snapshot, the number of steps since the snapshot before it, 0 at the start and
        after the restart; and the snapshots
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
    """The states that n intervals pass through when they are run again, in order of time.

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
        """States of the run from which steps are taken, and the timesteps of these steps.

        A fault may act in few states only, or only on the motion that the method itself computes.
        So random states are chosen, and the states in which the gain of a step differs most from
        the gains of the steps before and after it. Of the timesteps, the shortest suffice, as many
        as a limit needs.

        Parameters
        ----------
        at : the exact states and timesteps from which steps were taken before
        is_single : whether the engine computes in single precision. If it does, or if a constraint
            has to settle, few states are used with all timesteps, as few timesteps would not
            determine the limit

        Returns
        -------
        None if the constraint's force is not in its allowed direction in any of the states
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
        """Indices of the stretches whose gain differs most from the mean gain of both neighbours.

        At most `most` of them are chosen for each quantity; none if the motion turns too far to be
        followed.
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
    """The differences between a run and its n intervals that were run again.

    Attributes
    ----------
    evidence : the differences as they are stored
    worst : the indices of the K intervals that differ the most
    off : differences between the final states of these K replays and the run's, as
        `state_differences`, (K, 5, 3)
    passage : the states that all intervals pass through
    """

    intervals: Intervals
    evidence: ReplayEvidence
    worst: NDArray[np.intp]
    off: FloatArray
    passage: Passage


def restarted(sessions: Sessions, state: State, timestep: float, counts: Iterable[int]) -> State:
    """The state after stretches of steps, before each of which the session is restarted.

    Parameters
    ----------
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
    """Make a run of about `DECIDED_STEPS` steps, for a scene whose window takes too many steps.

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
    """Indices of the samples at which intervals begin and end: first, last, and random ones.

    There are `INTERVALS` intervals at most, or `FEW` if sessions cannot restart.
    """
    most = INTERVALS if can_restart else FEW
    count = min(most, max(1, 2 * (samples - 1) // 3))
    chance = np.random.default_rng(samples)
    inner = chance.choice(np.arange(1, samples - 1), count - 1, replace=False)
    return np.sort(np.concatenate([[0, samples - 1], inner])).astype(np.intp)
