"""Recorded motions: the columns of their files, the units of these, and checks of the samples."""

import re
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from math import pi
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .....scenarios import FloatArray

#: Factor from each unit to SI units.
TIMES = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0}
RATES = {"rad/s": 1.0, "deg/s": pi / 180, "rpm": pi / 30}
LENGTHS = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "km": 1e3}
SPEEDS = {"m/s": 1.0, "mm/s": 1e-3, "cm/s": 1e-2, "km/s": 1e3}


@dataclass(frozen=True)
class Quantity:
    """One quantity of a recorded motion.

    Attributes
    ----------
    name : name, in npz archives and JSON lines, of the array with all components
    columns : names of the columns of a table that hold the components; empty for spins, whose
        columns are `spin1`, `spin2`, …, one for each rotor
    written : another name that is accepted; except for times it is the name that `spincheck export
        --truth` writes. Columns of components add `_` and the component's letter to it
    units : the units that the quantity may be in, SI first, each with its factor to SI
    """

    name: str
    columns: tuple[str, ...]
    written: str
    units: dict[str, float]

    def component(self, column: str) -> int | None:
        """Return the index of the quantity's component that a column holds, from 0.

        Parameters
        ----------
        column : name of a column, without its unit

        Returns
        -------
        None if the column holds another quantity, or none
        """
        if not self.columns:
            numbered = _NUMBERED.fullmatch(column)
            return int(numbered["number"]) - 1 if numbered else None
        letters = [name[-1] for name in self.columns]
        spelled = [f"{self.written}_{letter}" for letter in letters]
        for names in (self.columns, spelled):
            if column in names:
                return list(names).index(column)
        return 0 if column in (self.name, self.written) and len(self.columns) == 1 else None


QUANTITIES = (
    Quantity("t", ("t",), "time", TIMES),
    Quantity("q", ("qw", "qx", "qy", "qz"), "quaternion_wxyz", {"": 1.0}),
    Quantity("omega", ("wx", "wy", "wz"), "omega_body", RATES),
    Quantity("com", ("x", "y", "z"), "com_world", LENGTHS),
    Quantity("velocity", ("vx", "vy", "vz"), "velocity_world", SPEEDS),
    Quantity("spins", (), "rotors_spin", RATES),
)
REQUIRED = ("t", "q")
#: Example of a heading line, shown where columns are missing.
HEADINGS = "t,qw,qx,qy,qz,wx,wy,wz"
_NUMBERED = re.compile(r"(spin|rotors_spin_)(?P<number>[1-9][0-9]{0,3})")
_HEAD = re.compile(r"^\s*(?P<name>[A-Za-z_0-9]+)\s*(?:[\[(]\s*(?P<unit>[^\])]*?)\s*[\])])?\s*$")


class ColumnError(ValueError):
    """A column that cannot be used, or that is missing."""


@dataclass(frozen=True)
class Column:
    """A column of a table: its quantity, the index of the component, and the factor to SI units."""

    quantity: Quantity
    component: int
    factor: float


def columns_of(heads: Sequence[str]) -> list[Column | None]:
    """Return the columns of a table, one for each heading; None for a heading of no known quantity.

    A unit may follow the name in brackets, ``wx [deg/s]``; without one the unit is SI.

    Raises
    ------
    ColumnError
        If a unit is unknown, two columns hold the same component, some components of a quantity are
        missing, or time or attitude is missing.
    """
    columns = [_column(head) for head in heads]
    for quantity in QUANTITIES:
        found = [c.component for c in columns if c is not None and c.quantity is quantity]
        if len(found) != len(set(found)):
            raise ColumnError(f"{_names(quantity)} must be one column each, got one twice")
        wanted = len(quantity.columns) or max(found, default=-1) + 1
        if len(found) != wanted and (found or quantity.name in REQUIRED):
            what = "a column" if len(quantity.columns) == 1 else "columns"
            got = "numbers" if all(map(_is_number, heads)) else ", ".join(heads) or "none"
            raise ColumnError(
                f"{_names(quantity)} must be {what} of the file, got {got}; name them as in "
                f"{HEADINGS}"
            )
    return columns


def factor_of(quantity: Quantity, unit: str | None) -> float:
    """Return the factor from a unit of a quantity to its SI unit.

    Parameters
    ----------
    unit : name of the unit; None means the SI unit

    Raises
    ------
    ColumnError
        If the quantity has no such unit.
    """
    if unit is None:
        return 1.0
    if unit not in quantity.units:
        known = ", ".join(quantity.units)
        raise ColumnError(f"the unit of {_names(quantity)} must be one of {known}, got '{unit}'")
    return quantity.units[unit]


def names_time(head: str) -> bool:
    """Return whether a heading, which may have a unit in brackets, names the column of times."""
    match = _HEAD.match(head)
    return match is not None and QUANTITIES[0].component(match["name"]) is not None


def _column(head: str) -> Column | None:
    """Return the column that a heading names; None if it names no known quantity.

    Raises
    ------
    ColumnError
        If the unit is unknown.
    """
    match = _HEAD.match(head)
    if match is None:
        return None
    for quantity in QUANTITIES:
        component = quantity.component(match["name"])
        if component is not None:
            return Column(quantity, component, factor_of(quantity, match["unit"]))
    return None


def _is_number(head: str) -> bool:
    with suppress(ValueError):
        float(head)
        return True
    return False


def _names(quantity: Quantity) -> str:
    """Return the names of a quantity's columns, in quotes."""
    return ", ".join(f"'{name}'" for name in quantity.columns) or "'spin1', 'spin2', …"


#: How far a quaternion's norm may be from 1, so that numbers printed with four digits pass.
UNIT_SLACK = 1e-3
#: Relative tolerance with which numbers are multiples of a unit, as they may have been converted
#: from other physical units; and that with which numbers are equal, relative to the largest.
MULTIPLE, EQUAL = 1e-6, 1e-9
#: Largest unit that components of quaternions may be rounded to: a coarser one does not tell
#: attitudes apart. Least number of different values by which rounding is recognised.
COARSEST, FEWEST_VALUES = 0.1, 8
#: Largest factor by which the norm may change from one sample to the next. It drifts if a method
#: does not normalise quaternions.
NORM_GROWS = 1.5


class RecordingError(ValueError):
    """The error of a file whose motion cannot be judged; its message is one sentence."""


@dataclass(frozen=True, eq=False)
class Recording:
    """The numbers of a file, in SI units.

    Attributes
    ----------
    path : the file
    arrays : the quantities by `Quantity.name`: t, (n,), and q, (n, 4); if the file has them, also
        omega, com and velocity, (n, 3) each, and spins, (n, rotors)
    settings : what the file states about itself: values by the names in `SETTINGS`
    ignored : headings of columns that name no known quantity
    """

    path: Path
    arrays: dict[str, FloatArray]
    settings: dict[str, str] = field(default_factory=dict)
    ignored: tuple[str, ...] = ()

    @property
    def is_single(self) -> bool:
        """Whether the motion was computed in single precision.

        If the file does not state the precision, this is assumed of a motion whose quaternions are
        exact in single precision, unless all their components are whole numbers.
        """
        q = self.arrays["q"]
        has_24_bits = np.array_equal(q, q.astype(np.float32)) and not np.array_equal(q, np.rint(q))
        return self.settings.get("precision", "single" if has_24_bits else "double") == "single"

    @property
    def drift_off_the_sphere(self) -> str:
        """A sentence on how quaternions drift off the unit sphere, norm 1; empty if they do not."""
        t, norms = self.arrays["t"], np.linalg.norm(self.arrays["q"], axis=1)
        if (np.abs(norms - 1) <= slack_of(self.arrays["q"])).all():
            return ""
        rate = np.log(norms[-1] / norms[0]) / (t[-1] - t[0])
        return (
            f"the quaternions drift off the unit sphere, by {rate:.3g} /s, to a norm of "
            f"{norms[-1]:.4g} at {t[-1]:.4g} s; they were normalised"
        )

    @property
    def resolution(self) -> float:
        """The relative resolution with which attitude and ω are printed.

        It is 10^(1 − d), where d is the number of digits of the number with the most, but at least
        the machine epsilon, which it is if all numbers are whole.
        """
        eps = float(np.finfo(np.float32 if self.is_single else float).eps)
        columns = [self.arrays[name].ravel() for name in ("q", "omega") if name in self.arrays]
        numbers = np.concatenate(columns)
        if np.array_equal(numbers, np.rint(numbers)):
            # Whole numbers are taken to be exact.
            return eps
        digits = max(map(digits_of, numbers))
        return max(eps, 10.0 ** (1 - digits))


def digits_of(value: float) -> int:
    """Return how many significant decimal digits are needed to represent a double uniquely."""
    mantissa = repr(float(abs(value))).partition("e")[0]
    return len(mantissa.replace(".", "").strip("0"))


def unit_of(numbers: FloatArray) -> float:
    """Return the unit of which all numbers are multiples, to six digits; 0 if none is found.

    The unit that is tried is the smallest difference between two absolute values, or between one
    and 0.

    Parameters
    ----------
    numbers : of any shape
    """
    sizes = np.unique(np.abs(numbers))
    distances = np.diff(sizes, prepend=0.0)
    distances = distances[distances > EQUAL * sizes[-1]]
    if not len(distances):
        return 0.0
    unit = float(distances.min())
    multiples = sizes / unit
    is_multiple = np.abs(multiples - np.rint(multiples)) < MULTIPLE * multiples[-1]
    return float(f"{unit:.6g}") if is_multiple.all() else 0.0


def slack_of(q: FloatArray) -> float:
    """Return how far norms of n quaternions, (n, 4), may be from 1 if components are rounded."""
    unit, is_rounded = unit_of(q), len(np.unique(q)) >= FEWEST_VALUES
    return max(UNIT_SLACK, unit) if is_rounded and unit <= COARSEST else UNIT_SLACK


def check_motion(arrays: dict[str, FloatArray]) -> None:
    """Check that arrays hold a motion: finite numbers, increasing times, and quaternions.

    All arrays must have the same length, two samples or more. No time may be negative. The norm of
    the quaternions must be 1 at first, but may then drift slowly.

    Parameters
    ----------
    arrays : the quantities by name, as in `Recording.arrays`

    Raises
    ------
    RecordingError
        If a check fails, or times or quaternions are missing.
    """
    for quantity in QUANTITIES[:2]:
        if quantity.name not in arrays:
            raise RecordingError(f"must have an array '{quantity.name}'")
    times = arrays["t"]
    for name, values in arrays.items():
        if len(values) != len(times):
            raise RecordingError(f"'{name}' must have a row for each time, got {len(values)}")
        if not np.isfinite(values).all():
            raise RecordingError(
                f"'{name}' must be finite, sample {_first(~np.isfinite(values))} is not"
            )
    if len(times) < 2:
        raise RecordingError(f"must have at least two samples, got {len(times)}")
    if times[0] < 0:
        raise RecordingError(f"times must be counted from the scene's start, got {times[0]:g} s")
    if (is_back := np.diff(times) <= 0).any():
        k = _first(is_back)
        raise RecordingError(
            f"times must increase, got {times[k - 1]:.17g} s and then {times[k]:.17g} s in samples "
            f"{k} and {k + 1}; sort the samples, and leave out doubled ones"
        )
    norms = np.linalg.norm(arrays["q"], axis=1)
    before = np.concatenate([[1.0], norms[:-1]])
    slack = np.where(np.arange(len(norms)) > 0, NORM_GROWS, 1 + slack_of(arrays["q"]))
    if (is_wrong := (norms * slack < before) | (norms > before * slack)).any():
        k = _first(is_wrong)
        previous = f" and the one before {before[k - 1]:.4g}" if k > 1 else ""
        raise RecordingError(
            f"quaternions must be of unit norm, or drift off it slowly from 1 on, that of sample "
            f"{k} is {norms[k - 1]:.4g} long{previous}"
        )


def _first(wrong: NDArray[np.bool_]) -> int:
    """Return the number of the first row, counted from 1, that has an entry that is true."""
    return int(np.argmax(wrong.reshape(len(wrong), -1).any(axis=1))) + 1
