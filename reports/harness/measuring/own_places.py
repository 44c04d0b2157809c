"""States of a method's own runs, that steps are taken from too.

There is one in each interval that is run again, at random, and several in those intervals in which
the run gains the most beyond the exact flow. So what acts in few states, or only on the motion that
a method makes itself, is met as well. Few short timesteps tell whether a step gains what does not
vanish.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ....engines.checks.equations import Equations
from ....engines.checks.read_back import stacked
from ....scenarios import FloatArray, Scenario
from ....scenarios.fastest_rate import fastest_rate
from ..defects import FARTHEST_TURN
from .examine import OPENED
from .intervals import MadeRun, Replay
from .noise import largest_terms
from .places import Places, states_of
from .steps import Sessions, Steps, flowed, step_gains

#: Timesteps of these steps: the shortest of those from exact states.
TIMESTEPS = 4
#: Intervals that steps are taken from at several states, and how many in each.
GAINING, STATES = 4, 5


def own_places(
    sessions: Sessions, at: Places, run: MadeRun, replay: Replay, *, is_single: bool
) -> Places | None:
    """States of a run; None where nothing can hold the body in any.

    Parameters
    ----------
    at : exact states that steps were taken from
    is_single : whether the engine computes in single precision: there, and where a constraint has
        to settle first, few states with all timesteps tell a limit, and not few timesteps
    """
    edges = replay.intervals.edges
    states, times = [replay.states], [replay.intervals.times]
    for k in np.argsort(-_gains(sessions.scenario, run, edges))[:GAINING]:
        first, last = run.rung.sample_steps[edges[k : k + 2]]
        start = states_of(run.motion).rows(int(edges[k]))
        for count in np.unique(np.linspace(0, last - first - 1, STATES).astype(int)):
            with sessions.at(start, run.rung.timestep) as session:
                if count:
                    session.advance(int(count))
                states.append(stacked([session.read_state()]))
            times.append((first + count) * run.rung.timestep)
    own = stacked(states)
    bears = Equations(sessions.scenario).bears(own)
    if not bears.any():
        return None
    kept = np.hstack(times)[bears]
    places = replace(at, states=own.rows(bears), times=kept, are_apart=False)
    if is_single or at.gives_way:
        return places.thinned(OPENED)
    return replace(places, timesteps=at.timesteps[-TIMESTEPS:])


def _gains(scenario: Scenario, run: MadeRun, edges: NDArray[np.intp]) -> FloatArray:
    """The most that each interval gains, relative to the largest terms, (n,); or (0,)."""
    motion = run.motion
    if fastest_rate(scenario, motion.omega_body) * float(motion.t[-1]) > FARTHEST_TURN:
        return np.zeros(0)
    states, equations = states_of(motion), Equations(scenario)
    starts, ends, spans = states.rows(edges[:-1]), states.rows(edges[1:]), np.diff(motion.t[edges])
    timestep = np.array([run.rung.timestep])
    steps = Steps(timestep, spans, starts, ends, flowed(scenario, starts, spans))
    gains = np.linalg.norm(step_gains(equations, steps)[0, 0], axis=2)
    return np.asarray((gains / largest_terms(equations, steps)).max(axis=1))
