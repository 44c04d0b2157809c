"""Turns a user's arrays into a recorded motion."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike
from spincheck.reports.harness.recorded.files.recording import Recording, check_motion
from spincheck.reports.harness.recorded.files.text_formats import setting
from spincheck.reports.harness.recorded.judged import JudgedMotion, judged_motion
from spincheck.reports.harness.recorded.recorded_ladder import study_of_files, verdict_on_files
from spincheck.reports.results.verdicts import Verdict
from spincheck.scenarios import FloatArray, Scenario

#: The highest order of accuracy that may be stated of a method.
MOST_ORDER = 12
#: For each argument of `spincheck.judge`: the quantity that it gives, and the number of components
#: of that quantity; None for t, a scalar, and for spins, which may be any number.
ARGUMENTS = {
    "t": ("t", None),
    "q_wxyz": ("q", 4),
    "q_xyzw": ("q", 4),
    "omega_body": ("omega", 3),
    "omega_world": ("omega", 3),
    "com": ("com", 3),
    "velocity": ("velocity", 3),
    "spins": ("spins", None),
}


@dataclass(frozen=True)
class Made:
    """How a recorded motion was computed or measured.

    Attributes
    ----------
    timestep : timestep of the method, s; None if it is not known
    precision : "double" or "single"; None if it is to be found from the numbers
    order : order of accuracy of the method
    noise_attitude, noise_omega : standard deviations of measured numbers, rad and rad/s; None if
        they are to be estimated
    """

    timestep: float | None = None
    precision: str | None = None
    order: int = 1
    noise_attitude: float | None = None
    noise_omega: float | None = None

    def settings(self) -> dict[str, str]:
        """Return all attributes but `order` as the settings that a recording's file would state.

        Attributes that are None are left out.

        Raises
        ------
        ValueError
            If `order` cannot be used, a number is not positive, or the precision is unknown.
        """
        check_order(self.order)
        stated = {name: value for name, value in vars(self).items() if name != "order"}
        given = {name: str(value) for name, value in stated.items() if value is not None}
        return {
            key: value for name in given for key, value in setting(name, given[name], None).items()
        }


def check_order(order: int) -> None:
    """Raise `ValueError` unless an order of accuracy is a whole number from 1 to `MOST_ORDER`."""
    if not (isinstance(order, int | np.integer) and 1 <= order <= MOST_ORDER):
        raise ValueError(f"'order' must be a whole number from 1 to {MOST_ORDER}, got {order!r}.")


def judged(scenario: Scenario, arguments: Mapping[str, ArrayLike], made: Made) -> JudgedMotion:
    """Return the judgement of a recorded motion: its errors, and the mistakes that explain them.

    Parameters
    ----------
    arguments : the arrays, by the names of the arguments of `spincheck.judge`
    made : how the motion was computed or measured

    Raises
    ------
    ValueError
        If an array is missing or has the wrong shape, if a quantity is given twice, or if the
        motion cannot be compared with the exact one.
    """
    arrays: dict[str, FloatArray] = {}
    for name, values in arguments.items():
        quantity, width = ARGUMENTS[name]
        array = np.asarray(values, dtype=float)
        if array.ndim != (1 if name == "t" else 2) or (width and array.shape[1] != width):
            form = "(n,)" if name == "t" else f"(n, {width or 'rotors'})"
            raise ValueError(f"'{name}' must have the shape {form}, got {array.shape}.")
        if quantity in arrays:
            raise ValueError(f"'{name}' must not be given besides the same in another form.")
        arrays[quantity] = array
    if "q" not in arrays:
        raise ValueError("'q_wxyz' or 'q_xyzw' must be given.")
    check_motion(arrays)
    stated = made.settings()
    stated |= {"quaternion": "xyzw"} if "q_xyzw" in arguments else {}
    stated |= {"omega": "world"} if "omega_world" in arguments else {}
    return judged_motion(scenario, Recording(Path("arrays"), arrays, stated), made.order)


def verdict_on(scenario: Scenario, motions: Sequence[JudgedMotion], order: int) -> Verdict:
    """Return the verdict on a method, from its motions at timesteps halved again and again.

    Parameters
    ----------
    motions : the result of `spincheck.judge` for each motion
    order : order of accuracy that the method has or claims

    Raises
    ------
    ValueError
        If there are no motions, if their timesteps are unknown or not halves of one another, or if
        they share no sample times.
    """
    check_order(order)
    if not motions or not all(isinstance(one, JudgedMotion) for one in motions):
        raise ValueError("'motions' must be what 'spincheck.judge' returned, one a timestep.")
    return verdict_on_files(study_of_files(scenario, motions, order))
