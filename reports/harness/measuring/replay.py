"""Whether a step depends on the state alone.

Every interval of a run is run again from its own start in a session that remembers nothing. With
consistent steps that is convergence on any window, also where the motion is chaotic (Hairer,
Nørsett & Wanner I, theorem II.3.4). What a run does otherwise than its replays, a second, must
vanish with the timestep, as every gain must. Intervals are of random length and are run again in
random order, and each is restarted once more at a random step in its midst, so that nothing hides
in the rhythm of the samples.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from ....engines import Engine, EngineError, Session, State
from ....engines.checks.equations import Equations
from ....engines.checks.read_back import stacked
from ....reference import IntegrationError
from ....scenarios import FloatArray, Scenario, Trajectory
from ....scenarios.rotation import norms
from ...results.evidence import LEVEL, ReplayEvidence, StepEvidence
from ...results.records import LARGEST
from ..ladder import Rung
from .examine import OPENED, examine
from .gain_series import fitted
from .noise import NOISE, ULPS, rounding_of_body
from .own_places import MadeRun, Met, own_places
from .places import FINER, Places, states_of
from .steps import Sessions, apart, sessions_of

#: Intervals of a run at most.
INTERVALS = 64
#: Intervals that are run from changed states too, to see what rounding grows to.
CHANGED = 5
#: rad, or relative: changes that have grown to this are as large as the motion.
LOST = 0.1
#: Steps of a run that is made to be replayed where there is none.
BEGINNING = 4096
#: Steps before and after a restart that show a memory, and the factor by which a run may differ
#: more than from exact states.
REMEMBERED, EXPLAINED = 8, 3.0


def examine_runs(
    engine: Engine,
    scenario: Scenario,
    method_name: str,
    at: Places,
    found: StepEvidence,
    ladder: Sequence[MadeRun],
    others: Sequence[MadeRun],
) -> tuple[tuple[ReplayEvidence, ...], StepEvidence | None, str]:
    """Replay the finest run of a ladder and others, and take steps from states of theirs.

    Parameters
    ----------
    found : what steps from exact states showed
    ladder : its runs, the longest timestep first

    Returns
    -------
    What each replay shows; what steps from states of these runs do, None where none were taken; and
    why the engine refuses to be replayed, else empty.
    """
    method, shown = engine.method(method_name), []

    def open_at(scene: Scenario, timestep: float) -> Session:
        return engine.open(scene, method, timestep)

    try:
        runs = [*ladder[-1:], *others]
        timestep = runs[0].rung.timestep if runs else float(at.timesteps[0])
        with sessions_of(open_at, scenario, timestep) as sessions:
            runs = runs or [_beginning(sessions, at)]
            replays = [_replay(sessions, engine, run, at.condition) for run in runs]
            shown = [one.evidence for one in replays]
            if any(one.tail < LEVEL for one in shown):
                shown = _with_memory(sessions, engine, at, replays, method.order, found.settled)
            exact, is_single = replace(at, gives_way=bool(found.settled)), engine.single_precision
            own = own_places(sessions, exact, runs[0], replays[0].met, is_single=is_single)
    except (EngineError, IntegrationError) as error:
        return tuple(shown), None, "" if shown else str(error)
    own_steps = examine(engine, scenario, method_name, own) if own else None
    return tuple(shown), own_steps, ""


def _beginning(sessions: Sessions, at: Places) -> MadeRun:
    """The first steps of a motion of which no run was made, as it takes too many steps."""
    timestep, strides = float(at.timesteps[FINER]), [0, *[BEGINNING // INTERVALS] * INTERVALS]
    snapshots: list[object] = []
    with sessions.at(at.states.rows(0), timestep) as session:
        session.record(strides, snapshots.append)
    counts = np.cumsum(strides)
    states = sessions.first.states(snapshots)
    return MadeRun(Rung(timestep, counts), Trajectory(counts * timestep, *states.columns))


@dataclass(frozen=True, eq=False)
class _Intervals:
    """The n intervals of a run, each of which is run again from its own start.

    Attributes
    ----------
    edges : the samples that intervals begin and end at, (n + 1,)
    parts : steps after which an interval that is run again is restarted, (n,)
    """

    sessions: Sessions
    run: MadeRun
    edges: NDArray[np.intp]
    parts: NDArray[np.int64]

    @staticmethod
    def of(sessions: Sessions, run: MadeRun) -> "_Intervals":
        """All of a run, in irregular lengths."""
        edges = _edges(len(run.motion.t), sessions.first.can_restart)
        steps = np.diff(run.rung.sample_steps[edges])
        chance = np.random.default_rng(len(edges))
        return _Intervals(sessions, run, edges, chance.integers(1, np.maximum(steps, 2)))

    @cached_property
    def steps(self) -> NDArray[np.int64]:
        """Steps of each interval, (n,)."""
        return np.diff(self.run.rung.sample_steps[self.edges])

    @cached_property
    def starts(self) -> State:
        """The states that intervals begin with, n of them."""
        return states_of(self.run.motion).rows(self.edges[:-1])

    @cached_property
    def ends(self) -> State:
        """The states that the run ends them with, n of them."""
        return states_of(self.run.motion).rows(self.edges[1:])

    @property
    def times(self) -> FloatArray:
        """When each is restarted, s, (n,)."""
        return self.run.motion.t[self.edges[:-1]] + self.parts * self.run.rung.timestep

    def again(self, k: int, start: State) -> tuple[State, State]:
        """The states in the midst and at the end of an interval that is run from a start.

        In its midst it is restarted, so that nothing hides in the rhythm of samples or strides.
        """
        states = []
        for count in (int(self.parts[k]), int(self.steps[k] - self.parts[k])):
            with self.sessions.at(start, self.run.rung.timestep) as session:
                if count:
                    session.advance(count)
                start = session.read_state()
            states.append(start)
        return states[0], states[1]

    def all_again(self) -> tuple[State, State]:
        """The same of all, run in random order."""
        chance = np.random.default_rng(len(self.steps))
        order = map(int, chance.permutation(len(self.steps)))
        made = {k: self.again(k, self.starts.rows(k)) for k in order}
        midst, ends = zip(*(made[k] for k in sorted(made)), strict=True)
        return stacked(midst), stacked(ends)


@dataclass(frozen=True, eq=False)
class _Replay:
    """What n intervals do otherwise than a run.

    Attributes
    ----------
    off : the largest difference, as `apart` has it
    growth : the factor by which a small change of a state grows in an interval
    steps : of the longest interval
    met : states of the run, one in each interval
    """

    off: float
    growth: float
    steps: int
    evidence: ReplayEvidence
    met: Met


def _replay(sessions: Sessions, engine: Engine, run: MadeRun, condition: float) -> _Replay:
    """Run all intervals of a run again, and hold what they do otherwise against its noise."""
    intervals = _Intervals.of(sessions, run)
    states, reach = states_of(run.motion), Equations(sessions.scenario).reach
    midst, ends = intervals.all_again()
    off = np.nan_to_num(apart(ends, intervals.ends, reach), nan=np.inf)
    sizes = np.sqrt((off**2).sum(axis=(1, 2)))
    worst = np.argsort(sizes)[-CHANGED:]
    k = int(worst[-1])
    twice = stacked([intervals.again(k, intervals.starts.rows(k))[1]])
    spread = float(np.nan_to_num(np.abs(apart(twice, ends.rows(worst[-1:]), reach)).max()))
    noise = _noise(sessions.scenario, engine, run, states, condition, intervals.steps)
    # So large a change is no noise of the engine, of which nothing may be excused by itself.
    change = float(np.sqrt(max(NOISE, engine.ulp)))
    speed = change * float(norms(states.omega_body).max())
    starts = [_changed(intervals.starts.rows(int(k)), speed) for k in worst]
    changed = stacked([intervals.again(int(k), at)[1] for k, at in zip(worst, starts, strict=True)])
    grown = np.abs(apart(changed, ends.rows(worst), reach)).max(axis=(1, 2))
    # Where a change has grown to the motion's own size no more can be said of an interval.
    is_lost = (grown > LOST) & (spread <= LOST * change)
    growth = float(max(1.0, np.nan_to_num(np.minimum(grown, LOST) / change, nan=1.0).max()))
    squares = ((off / (growth * noise)[:, :, None]) ** 2).sum(axis=(1, 2))
    squares[worst[is_lost]] = 0.0
    tails = chdtrc(off[0].size, squares)
    times = run.motion.t[intervals.edges]
    turns = np.diff(times) * np.maximum(norms(intervals.starts.omega_body), 1 / times[-1])
    tail = float(min(1.0, tails.min() * len(tails)))
    largest = min(LARGEST, float((sizes / turns)[squares.argmax()]))
    evidence = ReplayEvidence(run.rung.timestep, len(tails), tail, largest)
    if tail < LEVEL:
        since = float(times[int(np.argmax(tails * len(tails) < LEVEL))])
        is_chance = spread > growth * float(noise[k].max())
        spread = min(LARGEST, spread / turns[k]) if is_chance else 0.0
        evidence = replace(evidence, since=since, spread=spread)
    met = Met(intervals.edges, midst, intervals.times)
    longest = int(intervals.steps.max())
    return _Replay(float(sizes[squares.argmax()]), growth, longest, evidence, met)


def _noise(
    scenario: Scenario,
    engine: Engine,
    run: MadeRun,
    states: State,
    condition: float,
    steps: NDArray[np.int64],
) -> FloatArray:
    """The noise of n intervals in each quantity of `apart`, of the sources of `noise.py`, (n, 5).

    Rounding of steps adds up as a random walk; that of where a body is, which hardly changes, adds
    up in one direction.
    """
    # In double precision a body may be composed anew where it is restarted.
    composed = 0.0 if engine.single_precision else rounding_of_body(condition)
    walk = max(NOISE, ULPS * engine.ulp, composed) * np.sqrt(steps)
    noise = np.repeat(walk[:, None], 5, axis=1)
    if scenario.constraint.is_pivot:
        return noise
    speed = float(norms(states.omega_body).max())
    body, rounding = scenario.body, ULPS * engine.ulp * run.rung.timestep * steps[:, None]
    equations, fast = Equations(scenario), float(norms(states.velocity_world).max())
    if speed:
        torque = body.mass * (fast + equations.arm * speed) ** 2
        noise += rounding * torque / (float(body.principal_moments[0]) * speed)
    if states.spins.size:
        force, _ = scenario.cancelling(np.abs(states.spins))
        scale = fast + equations.reach * speed
        noise[:, 2:4] += rounding * float(force.max()) / (body.mass * scale) if scale else 0.0
    return noise


def _edges(samples: int, can_restart: bool) -> NDArray[np.intp]:
    """The samples that intervals begin and end at: all of the run, in irregular lengths."""
    most = INTERVALS if can_restart else OPENED
    count = min(most, max(1, 2 * (samples - 1) // 3))
    chance = np.random.default_rng(samples)
    inner = chance.choice(np.arange(1, samples - 1), count - 1, replace=False)
    return np.sort(np.concatenate([[0, samples - 1], inner])).astype(np.intp)


def _changed(state: State, speed: float) -> State:
    """A state whose ω is changed by so much, rad/s, in a direction of its own."""
    direction = np.random.default_rng(CHANGED).standard_normal(3)
    change = speed / np.linalg.norm(direction) * direction
    return replace(state, omega_body=state.omega_body + change)


def _with_memory(
    sessions: Sessions,
    engine: Engine,
    at: Places,
    replays: list[_Replay],
    declared: int,
    settled: int,
) -> list[ReplayEvidence]:
    """What replays show, where a memory that vanishes with the timestep may explain it.

    From exact states a method takes some steps at once, and others after it was restarted between
    them. What that changes, over the length of the one step that lacks its memory, is a gain like
    any other. It explains a run that differs from its replays by no more. Of a method whose steps
    are those of a settled constraint, impulses of earlier steps are in what these gain: they need
    explain no more than the size of the difference.
    """
    equations, timesteps = Equations(sessions.scenario), at.timesteps
    remembered = max(REMEMBERED, settled)
    at_once, restarted = [], []
    if not sessions.first.can_restart:
        at = at.thinned(OPENED)
    for timestep in map(float, timesteps):
        for k in range(len(at.times)):
            with sessions.at(at.states.rows(k), timestep) as session:
                session.advance(remembered)
                middle = session.read_state()
                session.advance(remembered)
                at_once.append(session.read_state())
            with sessions.at(middle, timestep) as session:
                session.advance(remembered)
                restarted.append(session.read_state())
    off = apart(stacked(at_once), stacked(restarted), equations.reach)
    off = off.reshape(len(timesteps), -1, *off.shape[1:])
    sizes = np.abs(off).max(axis=(1, 2, 3))
    noise = max(NOISE, ULPS * engine.ulp) * np.sqrt(remembered)
    shown = [one.evidence for one in replays]
    tail, order = 1.0, 1
    if not settled:
        gains, table = off / timesteps[:, None, None, None], np.empty(off.shape[:2])
        table[:] = noise / timesteps[:, None]
        series = [fitted(timesteps, gains[:, :, q], table, LEVEL) for q in range(off.shape[2])]
        tail = min(1.0, *(len(series) * one.tail for one in series))
        is_seen = np.abs(off).max(axis=(0, 1, 3)) > EXPLAINED * noise
        orders = [one.order for one, seen in zip(series, is_seen, strict=True) if seen]
        if tail < LEVEL or not orders:
            return shown
        order = min(orders)

    def explains(one: _Replay) -> bool:
        size = float(np.interp(one.evidence.timestep, timesteps[::-1], sizes[::-1]))
        # What is left of an impulse goes on for as long as an interval lasts.
        lasting = max(1.0, one.steps / remembered) if settled else 1.0
        return one.off <= EXPLAINED * one.growth * lasting * size

    return [
        replace(one.evidence, tail=tail, order=order, declared=declared)
        if explains(one)
        else one.evidence
        for one in replays
    ]
