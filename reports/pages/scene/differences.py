"""Arrays as a page carries them: whole multiples of a step, of which the differences are small.

Of a smooth line that is sampled densely the differences of some order are small numbers, of which
deflate needs about a byte.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....scenarios import FloatArray

#: Differences of a higher order grow with the rounding to a step, by a factor of two each.
HIGHEST_ORDER = 6
#: Multiples of the step: nothing larger is drawn, and sums of differences stay exact in a double.
LARGEST = 1 << 40


@dataclass(frozen=True, eq=False)
class Differences:
    """An array, to half a step.

    Attributes
    ----------
    step : in the unit of the values
    order : how many times differences were taken; the first number is each time left as it is
    values : whole numbers, (n,)
    gaps : indices of what was NaN
    """

    step: float
    order: int
    values: NDArray[np.int64]
    gaps: tuple[int, ...]

    def planes(self) -> bytes:
        """Zigzag-coded (2v, or −2v − 1 where v < 0), the lowest byte of each, then the next, …."""
        zigzag = np.where(self.values < 0, -2 * self.values - 1, 2 * self.values)
        by_value = zigzag.astype("<u8").view(np.uint8).reshape(-1, 8)
        used = np.flatnonzero(by_value.max(axis=0, initial=0))
        width = int(used[-1]) + 1 if len(used) else 0
        return by_value[:, :width].T.tobytes()


def differenced(values: FloatArray, step: float) -> Differences:
    """Round values, (n,), to multiples of a step > 0; what is NaN becomes a gap."""
    gaps = tuple(np.flatnonzero(np.isnan(values)).tolist())
    drawable = np.clip(np.where(np.isnan(values), 0.0, values), -LARGEST * step, LARGEST * step)
    multiples = np.rint(drawable / step)
    differences = [multiples]
    for _ in range(HIGHEST_ORDER):
        differences.append(np.diff(differences[-1], prepend=0.0))
    order = min(range(len(differences)), key=lambda k: float(np.abs(differences[k]).sum()))
    return Differences(step, order, differences[order].astype(np.int64), gaps)
