"""The columns of a recorded motion: their names, units and meaning."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from math import pi

#: By unit, what a number is multiplied by to be in SI units.
TIMES = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0}
RATES = {"rad/s": 1.0, "deg/s": pi / 180, "rpm": pi / 30}
LENGTHS = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "km": 1e3}
SPEEDS = {"m/s": 1.0, "mm/s": 1e-3, "cm/s": 1e-2, "km/s": 1e3}


@dataclass(frozen=True)
class Quantity:
    """One quantity of a recorded motion.

    Attributes
    ----------
    name : of its array in npz and JSON lines, with all its components
    columns : the names of its components in a table
    written : as `spincheck export --truth` names it; components have the letters behind them
    units : the units it may be in, in SI first
    """

    name: str
    columns: tuple[str, ...]
    written: str
    units: dict[str, float]

    def component(self, column: str) -> int | None:
        """The index of the component that a column of this name holds; None if it is none."""
        letters = [name[-1] for name in self.columns]
        spelled = [f"{self.written}_{letter}" for letter in letters]
        for names in (self.columns, spelled):
            if column in names:
                return list(names).index(column)
        return 0 if column in (self.name, self.written) and len(self.columns) == 1 else None


QUANTITIES = (
    Quantity("t", ("t",), "t", TIMES),
    Quantity("q", ("qw", "qx", "qy", "qz"), "quaternion_wxyz", {"": 1.0}),
    Quantity("omega", ("wx", "wy", "wz"), "omega_body", RATES),
    Quantity("com", ("x", "y", "z"), "com_world", LENGTHS),
    Quantity("velocity", ("vx", "vy", "vz"), "velocity_world", SPEEDS),
)
REQUIRED = ("t", "q")
_HEAD = re.compile(r"^\s*(?P<name>[A-Za-z_0-9]+)\s*(?:[\[(]\s*(?P<unit>[^\])]*?)\s*[\])])?\s*$")


class ColumnError(ValueError):
    """A column that cannot be used, or one that is missing."""


@dataclass(frozen=True)
class Column:
    """A column of a table: the component of the quantity that it holds, and its unit's factor."""

    quantity: Quantity
    component: int
    factor: float


def columns_of(heads: Sequence[str]) -> list[Column | None]:
    """The meaning of a table's columns by their headings; None for those that mean nothing here.

    A unit may stand behind the name in brackets, ``wx [deg/s]``; without one it is SI.

    Raises
    ------
    ColumnError
        If a unit is unknown, a quantity is there twice or in part, or time or attitude is missing.
    """
    columns = [_column(head) for head in heads]
    for quantity in QUANTITIES:
        found = [c.component for c in columns if c is not None and c.quantity is quantity]
        if len(found) != len(set(found)):
            raise ColumnError(f"{_names(quantity)} must be one column each, got one twice")
        if len(found) != len(quantity.columns) and (found or quantity.name in REQUIRED):
            raise ColumnError(
                f"{_names(quantity)} must be columns of the file, got {', '.join(heads) or 'none'}"
            )
    return columns


def factor_of(quantity: Quantity, unit: str | None) -> float:
    """The factor that takes a number in this unit to SI units; None is SI already.

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


def _column(head: str) -> Column | None:
    match = _HEAD.match(head)
    if match is None:
        return None
    for quantity in QUANTITIES:
        component = quantity.component(match["name"])
        if component is not None:
            return Column(quantity, component, factor_of(quantity, match["unit"]))
    return None


def _names(quantity: Quantity) -> str:
    return ", ".join(f"'{name}'" for name in quantity.columns)
