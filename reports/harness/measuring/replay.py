"""Replays runs, to decide whether a step depends on the state alone.

Every interval of a run is run again from its own start, in a session that remembers nothing. A
method whose steps are consistent, and whose replays end in the same states as its runs, converges
on any window, even where the motion is chaotic (Hairer, Nørsett & Wanner I, theorem II.3.4). A
difference between run and replay is no fault only if it vanishes with the timestep, as every gain
must (`memory.py`). A fault could act in step with the samples. So intervals are of random length
and are run again in random order, and each replay is restarted once more after a random number of
steps.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from ....engines import Engine, EngineError
from ....engines.checks.equations import Equations
from ....reference import IntegrationError
from ....scenarios import FloatArray, Scenario
from ....scenarios.rotation import norms
from ...results.evidence import LEVEL, QUANTITIES, ReplayEvidence, StepEvidence
from ...results.records import LARGEST
from ..executors import CallFailed
from .examine import examine_or_refuse, refusal_of
from .intervals import Intervals, MadeRun, Replay, beginning_of
from .memory import explained_by_memory
from .noise import NOISE, ULPS, rounding_of_body
from .places import Places, changed_at_random, states_of
from .steps import FEW, Sessions, sessions_of, state_differences

#: A change of a state that has grown to this, in rad or relative, is as large as the motion itself.
LOST = 0.1
#: Largest number of random changes of a state whose growth is measured.
CHANGES = 3


def examine_runs(
    engine: Engine,
    scenario: Scenario,
    method_name: str,
    at: Places,
    found: StepEvidence,
    ladder: Sequence[MadeRun],
    others: Sequence[MadeRun],
) -> tuple[tuple[ReplayEvidence, ...], StepEvidence | None, CallFailed | None]:
    """Replay runs of a method, and examine steps from states of a run.

    The finest run of the ladder and all other runs are replayed. If there are no runs, the
    beginning of the motion is run, and this run is replayed.

    Parameters
    ----------
    at : the exact states and timesteps at which single steps were examined before
    found : the evidence from these single steps
    ladder : the runs of the ladder, the longest timestep first
    others : runs at other timesteps, all of which are replayed

    Returns
    -------
    The evidence from each replay; the evidence from steps from states of the first replayed run,
    None if no such steps were taken; and why runs could not be replayed, or steps not be taken from
    their states, None if they could
    """
    method, settled, shown = engine.method(method_name), found.settled, []

    try:
        runs = [*ladder[-1:], *others]
        timestep = runs[0].rung.timestep if runs else float(at.timesteps[0])
        with sessions_of(engine, method, scenario, timestep) as sessions:
            runs = runs or [beginning_of(sessions, at)]
            replays = [_replay(sessions, run, at.condition) for run in runs]
            shown = [explained_by_memory(one, settled) for one in replays]
            exact, is_single = replace(at, gives_way=bool(settled)), engine.single_precision
            own = replays[0].passage.places(scenario, exact, is_single=is_single)
    except (EngineError, IntegrationError) as error:
        return tuple(shown), None, None if shown else refusal_of(error)
    own_steps, refusal = (
        examine_or_refuse(engine, scenario, method_name, own) if own else (None, None)
    )
    return tuple(shown), own_steps, refusal


def _replay(sessions: Sessions, run: MadeRun, condition: float) -> Replay:
    """Replay all intervals of a run, and compare the differences from the run with their noise.

    Parameters
    ----------
    condition : factor by which a relative error of moments of inertia grows: `Places.condition`
    """
    intervals, reach = Intervals.of(sessions, run), Equations(sessions.scenario).reach
    passage = intervals.all_again()
    off = state_differences(passage.ends, intervals.ends, reach)
    sizes = np.linalg.norm(off, axis=(1, 2))
    worst = np.argsort(sizes)[-FEW:]
    starts, ends = intervals.starts.rows(worst), passage.ends.rows(worst)
    # The intervals that differ most are run once more, without reading states on the way.
    twice = state_differences(intervals.some_again(worst, starts), ends, reach, intervals.ends)
    spread = np.linalg.norm(twice, axis=(1, 2))
    sizes[worst] = np.maximum(sizes[worst], spread)
    # The change must be far above the engine's own noise, which would enlarge `growth`.
    change = float(np.sqrt(max(NOISE, sessions.engine.ulp)))
    chance, grown = np.random.default_rng(FEW), np.zeros(len(worst))
    for _ in range(CHANGES):
        changed = changed_at_random(sessions.scenario, starts, change, chance)
        apart = state_differences(intervals.some_again(worst, changed), ends, reach)
        grown = np.maximum(grown, np.abs(apart).max(axis=(1, 2)))
        # An interval in which a small change grows as large as the motion shows nothing.
        is_lost = (grown > LOST) & (spread <= LOST * change)
        growth = float(max(1.0, (np.minimum(grown, LOST) / change).max()))
        noise = growth * _noise(intervals, condition)
        squares = np.linalg.norm(off / noise[..., None], axis=(1, 2)) ** 2
        again = np.linalg.norm(twice / noise[worst][..., None], axis=(1, 2)) ** 2
        squares[worst] = np.where(is_lost, 0.0, np.maximum(squares[worst], again))
        is_chance = spread > noise[worst].max(axis=1)
        evidence = _evidence(intervals, squares, sizes, worst, np.where(is_chance, spread, 0.0))
        # A random change may happen to grow little: before a difference counts as a fault, further
        # changes are tried.
        if evidence.tail >= LEVEL:
            break
    of_worst = state_differences(ends, intervals.ends.rows(worst), reach)
    return Replay(intervals, evidence, worst, of_worst, passage)


def _evidence(
    intervals: Intervals,
    squares: FloatArray,
    sizes: FloatArray,
    worst: NDArray[np.intp],
    spread: FloatArray,
) -> ReplayEvidence:
    """Return the evidence from the replays of n intervals, given their differences from the run.

    Parameters
    ----------
    squares : for each interval, χ² of the differences, in units of their noise, (n,)
    sizes : for each interval, the norm of all differences, rad or relative, (n,)
    worst : the indices of the K intervals that were replayed twice
    spread : the difference of these two replays from each other; 0 if it is within noise, (K,)
    """
    run = intervals.run
    times = run.motion.t[intervals.edges]
    turns = np.diff(times) * np.maximum(norms(intervals.starts.omega_body), 1 / times[-1])
    tails = chdtrc(3 * len(QUANTITIES), squares) * (len(squares) + len(worst))
    tail = float(min(1.0, tails.min()))
    largest = min(LARGEST, float((sizes / turns)[squares.argmax()]))
    evidence = ReplayEvidence(run.rung.timestep, len(tails), tail, largest)
    if tail >= LEVEL:
        return evidence
    since, differs = float(times[int(np.argmax(tails < LEVEL))]), (spread / turns[worst]).max()
    return replace(evidence, since=since, spread=min(LARGEST, float(differs)))


def _noise(intervals: Intervals, condition: float) -> FloatArray:
    """Return the noise of the differences between replays and run at the ends of n intervals.

    It is the standard deviation of each of five quantities, (n, 5): attitude, rad, and ω, the com's
    velocity, its position and spins, relative to their sizes. `noise.py` lists its sources. Most
    rounding errors add up as a random walk; those of a torque or force that hardly changes add up
    linearly.

    Parameters
    ----------
    condition : factor by which a relative error of moments of inertia grows: `Places.condition`
    """
    engine, scenario = intervals.sessions.engine, intervals.sessions.scenario
    run, steps = intervals.run, intervals.steps
    states = states_of(run.motion)
    # In double precision an engine may add up the body's moments of inertia anew at each restart.
    composed = 0.0 if engine.single_precision else rounding_of_body(condition)
    walk = max(NOISE, ULPS * engine.ulp, composed) * np.sqrt(steps)
    noise = np.repeat(walk[:, None], len(QUANTITIES), axis=1)
    speed = float(norms(states.omega_body).max())
    # The gyroscopic torque is rounded, too. In the worst case its size is that of the largest
    # moment, and it acts about the axis of the smallest moment: their ratio is the condition.
    turned = speed * run.rung.timestep * np.sqrt(steps)
    noise += rounding_of_body(condition, engine.ulp) * turned[:, None]
    if scenario.constraint.is_pivot:
        # The pivot's position is rounded, and the constraint corrects that error within a step, by
        # turning the body.
        turned_back = ULPS * engine.ulp / (speed * run.rung.timestep) if speed else 0.0
        noise[:, 1:3] += turned_back * np.sqrt(steps)[:, None]
        # An error of ω turns the body throughout the interval.
        noise[:, [0, 3]] += ULPS * engine.ulp * steps[:, None]
        return noise
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
