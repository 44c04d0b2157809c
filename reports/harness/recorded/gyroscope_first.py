"""A mistake of a gyroscope beside other equations: it shows where the attitude does not follow ω.

By whatever torques a body turns, from sample to sample it turns by the mean of its ω.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ....scenarios import FloatArray
from ....scenarios.rotation import rotation_vectors
from ..explaining.fit import Data, Fit, Trial
from ..explaining.hypothesis import Hypothesis
from ..explaining.search import LEFT, Search
from .intervals import Intervals
from .sensors import SENSORS, as_it_was


@dataclass(frozen=True, eq=False)
class Turns(Data):
    """How the attitude turns in intervals, and the ω that were read at both ends."""

    intervals: Intervals

    def off(self, hypotheses: Sequence[Hypothesis], samples: int | None = None) -> FloatArray:
        """As in `Data`: the mean ω less the rate of turning, rad/s, (H, S, 3)."""
        data = self.intervals
        times = data.t - data.spans[:, 0], data.t
        reads = zip((data.starts, data.ends), times, strict=True)
        states = (as_it_was(hypotheses, read, t)[..., 4:] for read, t in reads)
        turned = rotation_vectors(data.starts[:, :4], data.ends[:, :4])
        return np.asarray(sum(states) / 2 - turned / data.spans)[:, :samples]


def after_gyroscope(data: Intervals, search: Search) -> Fit | None:
    """Return a mistake of a gyroscope with what explains the motion without it; None if none does.

    Parameters
    ----------
    search : for what explains the motion with ω as it was read
    """
    turns = Turns(data.base, data)
    usual = Trial(turns, ()).fit().left
    fits = [Trial(turns, (one,)).fit() for one in SENSORS]
    first = min(fits, key=lambda fit: fit.left)
    if not first.left < LEFT**2 * usual:
        return None
    of_equations = [one for one in search.changes if one not in SENSORS]
    corrected = replace(data, base=first.hypothesis)
    others = Search(corrected, of_equations, most=search.most).one_or_two()
    if others is None:
        return None
    # What the first fit leaves may have been taken for another change.
    either = [(one,) for one in others.changes] if len(others.changes) > 1 else []
    for changes in (*either, others.changes):
        every = *changes, *first.changes
        numbers = [
            fit.numbers_of(one) for fit in (others, first) for one in fit.changes if one in every
        ]
        begun = replace(others, changes=every, numbers=np.concatenate(numbers))
        both = Trial(data, every).fit(begun)
        if both.is_possible and not search.is_beyond(both.rest):
            return both
    return None
