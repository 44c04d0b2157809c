"""States of a method's own runs, from which single steps are taken, too.

A fault may act in few states only, or only on the motion that the method itself makes. So steps are
taken from random states of a run, and from those in which the gain of a step beyond the exact flow
differs the most from that of its neighbours. The shortest timesteps suffice, as many as tell a
limit.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ....engines.checks.equations import Equations
from ....scenarios import Scenario
from ....scenarios.fastest_rate import fastest_rate
from ..comparison.defects import FARTHEST_TURN
from .examine import OPENED
from .intervals import INTERVALS, WORST, Passage
from .places import Places
from .regression import LEAST
from .steps import Steps, flowed, step_gains


def own_places(
    scenario: Scenario, at: Places, passage: Passage, *, is_single: bool
) -> Places | None:
    """States of a run to take steps from; None if the body cannot be held in any of them.

    Parameters
    ----------
    at : exact states that steps were taken from
    passage : of the run
    is_single : whether the engine computes in single precision; then, and where a constraint has to
        settle, few states are used with all timesteps, as few timesteps would tell no limit
    """
    is_few = is_single or at.gives_way
    count = len(passage.times)
    chance = np.random.default_rng(count)
    some = chance.permutation(count)[: OPENED // 2 if is_few else INTERVALS]
    kept = np.union1d(some, _abrupt(scenario, passage, 1 if is_few else WORST))
    kept = kept[Equations(scenario).bears(passage.before.rows(kept))]
    if not len(kept):
        return None
    states, times = passage.before.rows(kept), passage.times[kept]
    places = replace(at, states=states, times=times, are_apart=False)
    return places if is_few else replace(places, timesteps=at.timesteps[-LEAST:])


def _abrupt(scenario: Scenario, passage: Passage, most: int) -> NDArray[np.intp]:
    """Indices of the steps in which a quantity's gain differs most from its neighbours' mean."""
    turn = fastest_rate(scenario, passage.before.omega_body) * float(passage.times[-1])
    if turn > FARTHEST_TURN or len(passage.times) < 3:
        return np.zeros(0, dtype=np.intp)
    before, spans = passage.before, passage.spans
    steps = Steps(spans[:1], spans, before, passage.after, flowed(scenario, before, spans))
    gains = step_gains(Equations(scenario), steps)[0, 0]
    off = np.linalg.norm(gains[1:-1] - (gains[:-2] + gains[2:]) / 2, axis=2)
    return np.unique(1 + np.argsort(off, axis=0)[-most:])
