"""Checks that a body or states that an adapter returns are of the right class and shapes."""

import numpy as np

from ...scenarios import printable
from .read_back import BodyReading, EngineError, State

#: Largest number of characters that a message quotes of a value.
QUOTED = 60


def check_shapes(returned: object, like: BodyReading | State, by: str, rows: int = 0) -> None:
    """Raise `EngineError` if what an adapter returned is not of the class and shapes it must have.

    Parameters
    ----------
    returned : what the adapter returned, which may be anything
    like : a body, or one state, of the right class and shapes
    by : name of the class and method that returned it, for the message
    rows : number of rows that each array must have, one a state; 0 for one state without rows
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
