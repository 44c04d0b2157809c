"""Checks that what an adapter returns has the shapes of a body, or of states."""

import numpy as np

from ...scenarios import printable
from .read_back import BodyReading, EngineError, State

#: Largest number of characters of a value that is quoted.
QUOTED = 60


def check_shapes(returned: object, like: BodyReading | State, by: str, rows: int = 0) -> None:
    """Raise `EngineError` if an adapter's body or state is none, or has arrays of other shapes.

    Parameters
    ----------
    returned : what the adapter returned; anything, as others write adapters
    like : a body, or one state, of the right shapes
    by : class and method that returned it
    rows : number of states that must have been returned; 0 for one state without rows
    """
    wanted = type(like)
    if not isinstance(returned, wanted):
        got = printable(repr(returned), QUOTED)
        raise EngineError(f"{by} must return a {wanted.__name__}, got {got}", "bug")
    before = (rows,) if rows else ()
    shapes = {
        name: (*before, *value.shape)
        for name, value in vars(like).items()
        if isinstance(value, np.ndarray)
    }
    for name, shape in shapes.items():
        value = getattr(returned, name)
        got = value.shape if isinstance(value, np.ndarray) else printable(repr(value), QUOTED)
        if got != shape:
            words = f"must be an array of shape {shape}, got {got}"
            raise EngineError(f"'{name}' of {by} {words}", "bug")
