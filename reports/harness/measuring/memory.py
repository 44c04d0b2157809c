"""Whether a run depends on more than its state: it is restarted from states of its own."""

from dataclasses import replace
from itertools import pairwise

import numpy as np

from ....engines import Engine, EngineError
from ....engines.checks.extrapolation import ABOVE
from ....engines.checks.read_back import State, stacked
from ....scenarios import Scenario, Trajectory
from ..ladder import Rung
from .places import apart, rounding_of_body, states_of

#: Intervals of a run that are gone through again, and the most steps of one.
INTERVALS, MOST_STEPS = 5, 1 << 12
#: Stretches that a run of few steps is gone through in, from end to end.
STRETCHES, FEW_STEPS = 64, 1 << 12
#: Relative change of a state that shows what rounding does to an interval, in ulp.
NUDGE = 64


def restarted(
    engine: Engine,
    scenario: Scenario,
    method_name: str,
    condition: float,
    rung: Rung,
    motion: Trajectory,
) -> float | None:
    """The tolerances by which a run goes on otherwise than if restarted from its own states.

    A run of few steps is gone through from end to end in stretches, of a longer one some intervals,
    in two strides each. What a nudge of the state does to the end is the tolerance, and what
    rounding does to a body of that condition. None where a session cannot be restarted.
    """
    method, intervals = engine.method(method_name), len(rung.sample_steps) - 1
    steps = np.diff(rung.sample_steps)
    if not intervals or steps.max() > MOST_STEPS:
        return None
    states = states_of(motion)
    if rung.steps <= FEW_STEPS:
        edges = np.unique(np.linspace(0, intervals, STRETCHES + 1).astype(int)).tolist()
        stretches: list[tuple[int, int]] = list(pairwise(edges))
    else:
        some = np.unique(np.linspace(0, intervals - 1, INTERVALS).astype(int)).tolist()
        stretches = [(k, k + 1) for k in some]
    try:
        with engine.open(scenario, method, rung.timestep) as session:
            if not session.can_restart:
                return None

            def gone_on(first: int, last: int, states: State = states) -> State:
                session.restart(states.rows(first))
                count = int(rung.sample_steps[last] - rung.sample_steps[first])
                session.advance(count // 2)
                session.advance(count - count // 2)
                return session.read_state()

            again = [gone_on(*stretch) for stretch in stretches]
            off = apart(stacked([states.rows(last) for _, last in stretches]), stacked(again))
            worst = np.argsort(off)[-INTERVALS:]
            factor = 1.0 + NUDGE * engine.ulp
            others = replace(states, omega_body=factor * states.omega_body)
            nudged = [gone_on(*stretches[int(k)], others) for k in worst]
    except EngineError:
        return None
    by_nudge = apart(stacked(nudged), stacked([again[k] for k in worst]))
    tolerance = ABOVE * (max(engine.slack, rounding_of_body(condition, engine.ulp)) + by_nudge)
    return float((off[worst] / tolerance).max())
