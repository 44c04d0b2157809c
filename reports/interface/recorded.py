"""Arrays of a user's as a recorded motion."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike
from spincheck.reports.harness.recorded.judged import JudgedMotion, judged_motion
from spincheck.reports.harness.recorded.recording import Recording, check_motion
from spincheck.scenarios import FloatArray, Scenario

#: By the name of an argument, the quantity that it gives and its number of components.
ARGUMENTS = {
    "t": ("t", None),
    "q_wxyz": ("q", 4),
    "q_xyzw": ("q", 4),
    "omega_body": ("omega", 3),
    "omega_world": ("omega", 3),
    "com": ("com", 3),
    "velocity": ("velocity", 3),
}


def judged(scenario: Scenario, arguments: Mapping[str, ArrayLike]) -> JudgedMotion:
    """Return what a motion given as arrays is worth; the arguments are those of `spincheck.judge`.

    Raises
    ------
    ValueError
        If an array has another shape, one is missing, or a quantity is given twice.
    """
    arrays: dict[str, FloatArray] = {}
    for name, values in arguments.items():
        quantity, width = ARGUMENTS[name]
        array = np.asarray(values, dtype=float)
        if array.ndim != (1 if width is None else 2) or (width and array.shape[1] != width):
            form = "(n,)" if width is None else f"(n, {width})"
            raise ValueError(f"'{name}' must have the shape {form}, got {array.shape}.")
        if quantity in arrays:
            raise ValueError(f"'{name}' must not be given besides the same in another form.")
        arrays[quantity] = array
    if "q" not in arrays:
        raise ValueError("'q_wxyz' or 'q_xyzw' must be given.")
    check_motion(arrays)
    return judged_motion(
        scenario,
        Recording(Path("arrays"), arrays),
        "xyzw" if "q_xyzw" in arguments else "wxyz",
        "world" if "omega_world" in arguments else "body",
    )
