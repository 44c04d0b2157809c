"""Arrays of doubles, and copies that frozen records keep."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def read_only(values: object) -> FloatArray:
    """A copy of the numbers, marked read-only."""
    array = np.array(values, dtype=float)
    array.setflags(write=False)
    return array
