"""The type of an array of doubles, and read-only copies for frozen records."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def read_only(values: object) -> FloatArray:
    """Return numbers, such as nested lists, as a new array of doubles that is read-only."""
    array = np.array(values, dtype=float)
    array.setflags(write=False)
    return array
