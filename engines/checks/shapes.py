"""Checks that what an adapter returns has the shapes of a body, or of states."""

import numpy as np

from ...scenarios import printable
from .read_back import BodyReading, EngineError, State

#: Largest number of characters of a value that is quoted.
QUOTED = 60


def check_shapes(
    returned: object, wanted: type[BodyReading | State], by: str, rotors: int, rows: int = 0
) -> None:
    """Raise `EngineError` if a body or state that an adapter returned is none, or of other shapes.

    Parameters
    ----------
    returned : what was returned; anything, as others write adapters
    wanted : the class that it must be of
    by : class and method that returned it
    rotors : number of the scene's rotors
    rows : number of states; 0 for one state that has no rows
    """
    if not isinstance(returned, wanted):
        got = printable(repr(returned), QUOTED)
        raise EngineError(f"{by} must return a {wanted.__name__}, got {got}", "bug")
    before = (rows,) if rows else ()
    shapes: dict[str, tuple[int, ...]] = {
        "com": (3,),
        "inertia_com": (3, 3),
        "axial": (rotors, 3),
        "q_world_body_wxyz": (*before, 4),
        "omega_body": (*before, 3),
        "com_world": (*before, 3),
        "velocity_world": (*before, 3),
        "spins": (*before, rotors),
    }
    for name, value in vars(returned).items():
        got = value.shape if isinstance(value, np.ndarray) else printable(repr(value), QUOTED)
        if name in shapes and got != shapes[name]:
            words = f"must be an array of shape {shapes[name]}, got {got}"
            raise EngineError(f"'{name}' of {by} {words}", "bug")
