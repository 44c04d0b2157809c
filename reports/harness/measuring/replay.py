"""Whether a step depends on the state alone, and what runs do where no step was taken from.

Every interval of a run is run again from its own start in a session that remembers nothing. With
consistent steps that is convergence on any window, also where the motion is chaotic (Hairer,
Nørsett & Wanner I, theorem II.3.4). What a run does otherwise than its replays, a second, must
vanish with the timestep, as every gain must. Intervals are of irregular length and are gone through
in irregular strides, so that nothing hides in the rhythm of the samples.

Beside that each interval is compared with the exact flow from its start. From states in those that
gain far more than any step did, steps are taken as from exact states.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from ....engines import Engine, EngineError, Session, State
from ....engines.checks.equations import Equations
from ....engines.checks.read_back import stacked
from ....reference import IntegrationError
from ....scenarios import FloatArray, Scenario, Trajectory
from ....scenarios.fastest_rate import fastest_rate
from ....scenarios.rotation import norms
from ...results.evidence import LEVEL, QUANTITIES, ReplayEvidence, StepEvidence
from ...results.records import LARGEST
from ..ladder import Rung
from .examine import examined
from .gain_series import fitted
from .noise import NOISE, ULPS, largest_terms
from .places import Places, states_of
from .steps import Sessions, Steps, apart, flowed, step_gains

#: Intervals of a run at most; where a scene is opened anew for each, which takes long.
INTERVALS, OPENED = 64, 8
#: Intervals that are run from changed states too, to see what rounding grows to.
CHANGED = 5
#: Steps of a run that is made to be replayed where there is none.
BEGINNING = 4096
#: Steps before and after a restart that show a memory, and the factor by which a run may differ
#: more than from exact states.
REMEMBERED, EXPLAINED = 8, 3.0
#: Intervals that steps are taken from if they gain so many times what any step did, and states in
#: each.
GAINING, TIMES, STATES = 4, 2.0, 5
#: Relative gain below which no interval is looked at: what is read is no better.
READABLE = 1e-9
#: rad; a motion that turns by more is not followed: it would take longer than a second.
FARTHEST_TURN = 1e5


@dataclass(frozen=True, eq=False)
class MadeRun:
    """A run that came to its end: its timestep and samples, and its motion at these."""

    rung: Rung
    motion: Trajectory


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
        with Sessions(open_at, scenario, float(at.timesteps[0])) as sessions:
            runs = [*ladder[-1:], *others] or [_beginning(sessions, at)]
            replays = [_replay(sessions, engine, run) for run in runs]
            shown = [one.evidence for one in replays]
            if any(one.tail < LEVEL for one in shown):
                shown = _with_memory(sessions, engine, at, replays, method.order)
            own = _own_places(sessions, at, runs, found)
        if own is None:
            return tuple(shown), None, ""
        return tuple(shown), examined(open_at, engine, scenario, own, method), ""
    except (EngineError, IntegrationError) as error:
        return tuple(shown), None, str(error)


def _beginning(sessions: Sessions, at: Places) -> MadeRun:
    """The first steps of a motion of which no run was made, as it takes too many steps."""
    timestep, strides = float(at.timesteps[0]), [0, *[BEGINNING // INTERVALS] * INTERVALS]
    snapshots: list[object] = []
    with sessions.at(at.states.rows(0), timestep) as session:
        session.record(strides, snapshots.append)
    counts = np.cumsum(strides)
    states = sessions.first.states(snapshots)
    return MadeRun(Rung(timestep, counts), Trajectory(counts * timestep, *states.columns))


@dataclass(frozen=True, eq=False)
class _Replay:
    """What n intervals do otherwise than a run.

    Attributes
    ----------
    off : the largest difference, as `apart` has it
    growth : the factor by which a small change of a state grows in an interval
    """

    off: float
    growth: float
    evidence: ReplayEvidence


def _replay(sessions: Sessions, engine: Engine, run: MadeRun) -> _Replay:
    edges = _edges(len(run.motion.t), sessions.first.can_restart)
    first, last = edges[:-1], edges[1:]
    states, reach = states_of(run.motion), Equations(sessions.scenario).reach
    steps = np.diff(run.rung.sample_steps[edges])

    chance = np.random.default_rng(len(edges))
    parts = chance.integers(1, np.maximum(steps, 2))

    def again(k: int, start: State) -> State:
        # From another session in its midst: nothing hides in the rhythm of samples or strides.
        for count in (int(parts[k]), int(steps[k] - parts[k])):
            with sessions.at(start, run.rung.timestep) as session:
                if count:
                    session.advance(count)
                start = session.read_state()
        return start

    starts = [states.rows(int(k)) for k in first]
    made = {int(k): again(int(k), starts[k]) for k in chance.permutation(len(starts))}
    ends = stacked([made[k] for k in range(len(starts))])
    off = apart(ends, states.rows(last), reach)
    squares = np.nan_to_num((off**2).sum(axis=(1, 2)), nan=np.inf)
    worst = np.argsort(squares)[-CHANGED:]
    # So large a change is no noise of the engine, of which nothing may be excused by itself.
    change = float(np.sqrt(max(NOISE, engine.ulp)))
    speed = change * float(norms(states.omega_body).max())
    changed = [again(int(k), _changed(starts[k], speed)) for k in worst]
    grown = np.abs(apart(stacked(changed), ends.rows(worst), reach)).max() / change
    growth = max(1.0, float(np.nan_to_num(grown, nan=1.0)))
    noise = max(NOISE, ULPS * engine.ulp) * growth * np.sqrt(steps)
    tails = chdtrc(off[0].size, squares / noise**2)
    turns = np.diff(run.motion.t[edges])
    turns *= np.maximum(norms(states.omega_body)[first], 1 / run.motion.t[-1])
    tail = float(min(1.0, tails.min() * len(tails)))
    largest = min(LARGEST, float((np.sqrt(squares) / turns).max()))
    evidence = ReplayEvidence(run.rung.timestep, len(tails), tail, largest)
    if tail < LEVEL:
        differing = int(np.argmax(tails * len(tails) < LEVEL))
        k = int(tails.argmin())
        one, other = (stacked([again(k, starts[k])]) for _ in range(2))
        spread = np.nan_to_num(np.abs(apart(one, other, reach)).max() / turns[k])
        since = float(run.motion.t[first[differing]])
        evidence = replace(evidence, since=since, spread=min(LARGEST, float(spread)))
    return _Replay(float(np.sqrt(squares.max())), growth, evidence)


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
    sessions: Sessions, engine: Engine, at: Places, replays: list[_Replay], declared: int
) -> list[ReplayEvidence]:
    """What replays show, where a memory that vanishes with the timestep may explain it.

    From exact states a method takes some steps at once, and others after it was restarted between
    them. What that changes, over the length of the one step that lacks its memory, is a gain like
    any other. It explains a run that differs from its replays by no more.
    """
    equations, timesteps = Equations(sessions.scenario), at.timesteps
    at_once, restarted = [], []
    for timestep in map(float, timesteps):
        for k in range(len(at.times)):
            with sessions.at(at.states.rows(k), timestep) as session:
                session.advance(REMEMBERED)
                middle = session.read_state()
                session.advance(REMEMBERED)
                at_once.append(session.read_state())
            with sessions.at(middle, timestep) as session:
                session.advance(REMEMBERED)
                restarted.append(session.read_state())
    off = apart(stacked(at_once), stacked(restarted), equations.reach)
    gains = off.reshape(len(timesteps), -1, *off.shape[1:]) / timesteps[:, None, None, None]
    noise = max(NOISE, ULPS * engine.ulp) * np.sqrt(REMEMBERED) / timesteps
    table = np.broadcast_to(noise[:, None], gains.shape[:2])
    series = [fitted(timesteps, gains[:, :, q], table, LEVEL) for q in range(gains.shape[2])]
    tail = min(1.0, *(len(series) * one.tail for one in series))
    sizes = np.abs(gains).max(axis=(1, 2, 3))
    shown = [one.evidence for one in replays]
    if tail < LEVEL or not (sizes > EXPLAINED * noise).any():
        return shown
    order = min(
        one.order
        for q, one in enumerate(series)
        if (np.abs(gains[:, :, q]).max(axis=(1, 2)) > EXPLAINED * noise).any()
    )
    return [
        replace(evidence, tail=tail, order=order, declared=declared)
        if one.off / evidence.timestep
        <= EXPLAINED * one.growth * np.interp(evidence.timestep, timesteps[::-1], sizes[::-1])
        else evidence
        for one, evidence in zip(replays, shown, strict=True)
    ]


def _own_places(
    sessions: Sessions, at: Places, runs: Sequence[MadeRun], found: StepEvidence
) -> Places | None:
    """States in the intervals of runs that gain more than any step from an exact state did."""
    scenario = sessions.scenario
    ratios = [_ratios(scenario, run, found) for run in runs]
    ranked = sorted(
        (
            (float(ratio), r, int(k))
            for r, part in enumerate(ratios)
            for k, ratio in enumerate(part)
        ),
        reverse=True,
    )
    states, times = [], []
    for ratio, r, k in ranked[:GAINING]:
        if not ratio > TIMES:
            break
        run = runs[r]
        start = states_of(run.motion).rows(k)
        steps = int(run.rung.sample_steps[k + 1] - run.rung.sample_steps[k])
        for count in np.unique(np.linspace(0, steps - 1, STATES).astype(int)):
            with sessions.at(start, run.rung.timestep) as session:
                session.advance(int(count))
                states.append(session.read_state())
            times.append(float(run.motion.t[k] + count * run.rung.timestep))
    if not states:
        return None
    own = stacked(states)
    bears = Equations(scenario).bears(own)
    if not bears.any():
        return None
    return replace(at, states=own.rows(bears), times=np.array(times)[bears])


def _ratios(scenario: Scenario, run: MadeRun, found: StepEvidence) -> FloatArray:
    """What each interval gains, over the most that a step with that timestep gained, (n − 1,)."""
    motion, spans = run.motion, np.diff(run.motion.t)
    if fastest_rate(scenario, motion.omega_body) * float(motion.t[-1]) > FARTHEST_TURN:
        return np.zeros(0)
    states, equations = states_of(motion), Equations(scenario)
    starts, ends = states.rows(slice(None, -1)), states.rows(slice(1, None))
    timestep = np.array([run.rung.timestep])
    steps = Steps(timestep, spans, starts, ends, flowed(scenario, starts, spans))
    gains = np.linalg.norm(step_gains(equations, steps)[0, 0], axis=2) / largest_terms(
        equations, steps
    )
    ratios = [np.zeros(len(spans))]
    for curve in found.curves:
        most = np.interp(run.rung.timestep, curve.timesteps[::-1], curve.largest[::-1])
        ratios.append(gains[:, QUANTITIES.index(curve.quantity)] / max(float(most), READABLE))
    return np.asarray(np.max(ratios, axis=0))
