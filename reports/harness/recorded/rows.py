"""What all formats of a recorded motion have: rows of numbers, and what a file states of itself."""

from collections.abc import Sequence
from contextlib import suppress
from typing import Any

import numpy as np

from ....scenarios import FloatArray, printable
from ....scenarios.document import MAX_SAMPLES
from .columns import Column
from .recording import RecordingError

#: Characters of a line, at most.
LONGEST_LINE = 1 << 14
#: What a file may state of itself, with the words it may use; None stands for a positive number.
SETTINGS: dict[str, tuple[str, ...] | None] = {
    "quaternion": ("wxyz", "xyzw"),
    "omega": ("body", "world"),
    "precision": ("double", "single"),
    "timestep": None,
}
_SHORTEST, _LONGEST = 1e-150, 1e150


class Table:
    """Rows of numbers as they come, by quantity; never more than a motion may have."""

    def __init__(self, columns: Sequence[Column | None]) -> None:
        self._columns = columns
        self._rows: list[list[float]] = []

    def add(self, cells: Sequence[Any], where: str) -> None:
        """Add a row.

        Raises
        ------
        RecordingError
            If it has another number of cells than columns, or a cell is not a finite number.
        """
        if len(cells) != len(self._columns):
            wanted = f"must have {len(self._columns)} columns"
            raise RecordingError(f"{where} {wanted}, got {len(cells)}")
        used = [(c, x) for c, x in zip(self._columns, cells, strict=True) if c is not None]
        self._rows.append([column.factor * _number(cell, where) for column, cell in used])
        check_count(len(self._rows))

    def arrays(self) -> dict[str, FloatArray]:
        """The quantities, each (n, components), the time (n,)."""
        used = [column for column in self._columns if column is not None]
        numbers = np.array(self._rows, dtype=float).reshape(-1, len(used))
        arrays = {}
        for quantity in {column.quantity.name: column.quantity for column in used}.values():
            places = sorted(
                (column.component, k)
                for k, column in enumerate(used)
                if column.quantity is quantity
            )
            arrays[quantity.name] = numbers[:, [k for _, k in places]]
        arrays["t"] = arrays["t"][:, 0]
        return arrays


def setting(name: str, value: str, line: int | None) -> dict[str, str]:
    """What a file states of itself; nothing if the name is no setting."""
    if name not in SETTINGS:
        return {}
    words = SETTINGS[name]
    where = "" if line is None else f"line {line}: "
    if words is None:
        with suppress(ValueError):
            if _SHORTEST < float(value) < _LONGEST:
                return {name: value}
        raise RecordingError(f"{where}'{name}' must be a positive number, got '{printable(value)}'")
    if value not in words:
        raise RecordingError(
            f"{where}'{name}' must be {' or '.join(words)}, got '{printable(value)}'"
        )
    return {name: value}


def _number(cell: Any, where: str) -> float:
    with suppress(ValueError, TypeError, OverflowError):
        value = float(cell)
        if abs(value) < _LONGEST and not isinstance(cell, bool):
            return value
    raise RecordingError(f"{where}: '{printable(str(cell)[:40])}' must be a finite number")


def check_count(samples: int) -> None:
    """Refuse more samples than a motion may have."""
    if samples > MAX_SAMPLES:
        raise RecordingError(
            f"must have at most {MAX_SAMPLES} samples; write every second or tenth of them"
        )
