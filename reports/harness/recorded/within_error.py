"""Changes that explain what is left of a motion though a method's error may be as large.

No method's error is that of other equations to two digits, but for what every method makes of some
motions, such as another rate at which ω decays. So the errors of known integrators must not be
explained by the same changes.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ....reference.following import KNOWN, follow
from ....scenarios import FloatArray
from ..explaining.fit import Fit, Trial
from ..explaining.hypothesis import Change, Hypothesis
from ..explaining.search import LEFT, Search
from .intervals import Intervals, apart
from .mistakes import FITS

#: Part of what is left that changes leave of it, at most.
CERTAIN = 3e-2
#: Number of intervals that known integrators are followed in, and of their steps, at most.
FEW, MOST_STEPS = 12, 300


def within_error(
    data: Intervals, changes: Sequence[Change], most: int, base: Hypothesis, timestep: float | None
) -> Fit | None:
    """Return the change, or two, that explain nearly all of what a hypothesis leaves; None if none.

    Parameters
    ----------
    most : how many numbers are fitted, at most
    base : the hypothesis, to which changes are added
    timestep : the timestep that the motion was made with, s; None if unknown
    """
    data = replace(data, base=base)
    off = usual = _size(data.off(base) * data.scale)
    found = None
    while not (off <= np.maximum(data.noise, FITS)).all():
        nearly = _nearly(data, CERTAIN * off)
        closer = Search(nearly, changes, most, part=0.0).one_or_two()
        if closer is None or closer.count > most:
            break
        # There may be others that explain nearly all of what these leave.
        found, off = closer, _size(closer.rest.reshape(-1, 6) * nearly.scale)
    # Noise may hide what else is left.
    if found is None or not (off < LEFT * usual).any():
        return None
    return None if _is_of_integrators(data, found, timestep) else found


def _is_of_integrators(data: Intervals, found: Fit, timestep: float | None) -> bool:
    """Whether the same changes explain a known integrator's errors, too, of all or of ω alone."""
    few, equations = data.spread(FEW), data.base.equations
    longest = float(few.spans.max())
    timestep = max(timestep or longest, longest * FEW / MOST_STEPS)
    exact = follow(equations, few.starts, few.spans)[:, 0]
    for one in KNOWN:
        ends = follow(equations, few.starts, few.spans, one, timestep)[:, 0]
        off = _size(apart(exact, ends))
        if not off.all():
            continue
        errors = replace(few, ends=ends, noise=np.zeros(2))
        for size in off, off * [1 / FITS, 1.0]:
            fit = Trial(_nearly(errors, size), found.changes).fit()
            if fit.left < LEFT**2 * np.mean((off / size) ** 2):
                return True
    return False


def _size(off: FloatArray) -> FloatArray:
    """Return root mean squares of attitude, rad, and ω, rad/s, (2,), of differences, (S, 6)."""
    return np.asarray(np.sqrt(np.mean(off.reshape(-1, 2, 3) ** 2, axis=(0, 2))))


def _nearly(data: Intervals, size: FloatArray) -> Intervals:
    """Return intervals with so large an error of their method, rad and rad/s, (2,)."""
    return replace(data, method=np.tile(size, (len(data.spans), 1)))
