"""States of a method's own runs that no step was taken from, where the runs gain the most.

Each interval of a run is compared with the exact flow from its start. From states in those that
gain far more than any step did, steps are taken as from exact states.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ....engines.checks.equations import Equations
from ....engines.checks.read_back import stacked
from ....scenarios import FloatArray, Scenario, Trajectory
from ....scenarios.fastest_rate import fastest_rate
from ...results.evidence import QUANTITIES, StepEvidence
from ..ladder import Rung
from .noise import largest_terms
from .places import Places, states_of
from .steps import Sessions, Steps, flowed, step_gains

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


def own_places(
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
    kept = np.array(times)[bears]
    return replace(at, states=own.rows(bears), times=kept, are_apart=False)


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
    curves = {curve.quantity: curve for curve in found.curves}
    for q, quantity in enumerate(QUANTITIES):
        most = 0.0
        if curve := curves.get(quantity):
            most = float(np.interp(run.rung.timestep, curve.timesteps[::-1], curve.largest[::-1]))
        ratios.append(gains[:, q] / max(most, READABLE))
    return np.asarray(np.max(ratios, axis=0))
