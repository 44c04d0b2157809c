"""Says where a recorded motion jumps, though it is the exact one from nearly every sample on."""

import numpy as np
from scipy.stats import chi2, f

from ....reference.following import follow
from ....scenarios import FloatArray
from ....scenarios.rotation import norms
from ..explaining.search import LEFT, LEVEL
from .intervals import Intervals, apart

#: Largest number of rows that may have been lost at once.
MOST_LOST = 20


def jumps(data: Intervals) -> list[str]:
    """Return the first jump in words; none if there is none, or more than a tenth of all are some.

    Parameters
    ----------
    data : all intervals, with the noise of recorded numbers
    """
    off = data.apart(data.base.equations)
    level = LEVEL / len(off)
    at_once = 1 + 5 * data.of_method
    left = np.sum((off / data.scale) ** 2, axis=1) / at_once
    is_beyond = left > chi2.isf(level, 6 / at_once)
    if np.sum(is_beyond) > LEFT * len(off):
        return []
    squares = np.mean(off.reshape(-1, 2, 3) ** 2, axis=2)
    # Noise that a method's error nearly hides is larger at some of many samples.
    usual = np.mean(squares[~is_beyond], axis=0)
    is_beyond &= np.any(squares > f.isf(level, 3, 3 * np.sum(~is_beyond)) * usual, axis=1)
    if not is_beyond.any():
        return []
    k = int(np.argmax(is_beyond))
    at = f"at t = {data.t[k]:.6g} s"
    spans = np.full((1, MOST_LOST), data.spans[k])
    if k + 1 < len(off) and np.array_equal(data.starts[k + 1], data.ends[k]):
        both = data.spans[k : k + 2].T
        after = follow(data.base.equations, data.starts[[k]], both)[0, 1]
        if _is_near(after, data.ends[k + 1], data.scale[k]):
            return [f"the sample {at} is off by {_size(off[k])}: leave it out"]
    for lost, state in enumerate(follow(data.base.equations, data.starts[[k]], spans)[0]):
        if _is_near(state, data.ends[k], data.scale[k]):
            samples = "1 sample is" if lost == 1 else f"{lost} samples are"
            return [f"{samples} lost before t = {data.t[k]:.6g} s, or its time is too early"]
    if not k:
        # What a filter makes of a start goes on in the samples after it.
        if left[1] > LEFT * left[0]:
            return []
        return [
            f"the first sample is off what follows by {_size(off[0])}, as where a state is written "
            "before an engine corrects it, or by a step that begins wrongly"
        ]
    return [f"{at} it jumps, by {_size(off[k])}, as where a state is set, or something strikes it"]


def _is_near(made: FloatArray, recorded: FloatArray, scale: FloatArray) -> bool:
    off = apart(made[None], recorded[None])[0] / scale
    return bool(np.sum(off**2) < chi2.isf(LEVEL, 6))


def _size(off: FloatArray) -> str:
    turned, faster = norms(off.reshape(2, 3))
    return f"{np.degrees(turned):.3g}° and {faster:.3g} rad/s"
