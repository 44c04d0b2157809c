"""Reads recorded motions from text: CSV and JSON lines."""

import csv
import json
from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import IO, Any

import numpy as np

from .....scenarios import FloatArray, printable
from .....scenarios.document import MAX_SAMPLES
from .recording import (
    QUANTITIES,
    ColumnError,
    Quantity,
    Recording,
    RecordingError,
    columns_of,
    names_time,
)

#: Largest number of characters in a line.
LONGEST_LINE = 1 << 14
#: The settings that a file may state, with their permitted values; None means a positive number.
SETTINGS: dict[str, tuple[str, ...] | None] = {
    "quaternion": ("wxyz", "xyzw"),
    "omega": ("body", "world"),
    "precision": ("double", "single"),
    "timestep": None,
    "noise_attitude": None,
    "noise_omega": None,
}
_SHORTEST, _LONGEST = 1e-150, 1e150


class Table:
    """A table of numbers that is filled row by row, with no more rows than a motion may have.

    Parameters
    ----------
    heads : headings of the columns

    Attributes
    ----------
    ignored : headings that name no known quantity

    Raises
    ------
    ColumnError
        If the headings do not name the columns of a motion (see `columns_of`).
    """

    def __init__(self, heads: Sequence[str]) -> None:
        self._columns = columns_of(heads)
        unknown = (h for h, c in zip(heads, self._columns, strict=True) if c is None)
        self.ignored = tuple(filter(None, unknown))
        self._rows: list[list[float]] = []

    def add(self, cells: Sequence[Any], where: str) -> None:
        """Add a row to the table; cells of ignored columns may be anything.

        Parameters
        ----------
        cells : the cells, one for each heading
        where : place of the row in the file, for messages

        Raises
        ------
        RecordingError
            If the numbers of cells and headings differ, a cell is not a finite number, or there are
            too many rows.
        """
        if len(cells) != len(self._columns):
            wanted = f"must have {len(self._columns)} columns"
            raise RecordingError(f"{where} {wanted}, got {len(cells)}")
        used = [(c, x) for c, x in zip(self._columns, cells, strict=True) if c is not None]
        self._rows.append([column.factor * _number(cell, where) for column, cell in used])
        check_count(len(self._rows))

    def arrays(self) -> dict[str, FloatArray]:
        """Return the quantities of n rows, SI units, by name: t, (n,), others (n, components)."""
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
    """Return a dictionary with one setting and its value; empty if no setting has the name.

    Parameters
    ----------
    name, value : the setting's name and its value, as text
    line : number of the line that states the setting, for messages; None if the file has no lines

    Raises
    ------
    RecordingError
        If the value is not permitted.
    """
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
    """Return a cell as a number.

    Parameters
    ----------
    where : place of the cell in the file, for messages

    Raises
    ------
    RecordingError
        If the cell is no number, or one that is not finite or exceeds `_LONGEST` in size.
    """
    with suppress(ValueError, TypeError, OverflowError):
        value = float(cell)
        if abs(value) < _LONGEST and not isinstance(cell, bool):
            return value
    raise RecordingError(f"{where}: '{printable(str(cell)[:40])}' must be a finite number")


def check_count(samples: int) -> None:
    """Raise `RecordingError` if there are more samples than a motion may have."""
    if samples > MAX_SAMPLES:
        raise RecordingError(
            f"must have at most {MAX_SAMPLES} samples; write every second or tenth of them"
        )


def _lines(file: IO[str]) -> Iterator[tuple[int, str]]:
    """Yield the lines that are not empty, with their numbers, from 1 on.

    Raises
    ------
    RecordingError
        If a line is too long; the rest of such a line is not read.
    """
    number = 0
    while line := file.readline(LONGEST_LINE):
        number += 1
        if len(line) == LONGEST_LINE:
            raise RecordingError(f"line {number} must be shorter than {LONGEST_LINE} characters")
        if line.strip():
            yield number, line.strip()


def read_csv(path: Path) -> Recording:
    """Read a motion from a table in text, whose first line names the columns.

    Lines before the table that begin with # may state settings, ``# timestep = 0.001``. The line
    that names the columns may begin with #, too, as NumPy's savetxt writes it. Cells are separated
    by commas, semicolons, tabs or spaces.

    Raises
    ------
    RecordingError
        If the file does not hold such a table, a line is too long, there are too many lines, or the
        value of a setting is not permitted.
    ColumnError
        If the headings do not name the columns of a motion (see `columns_of`).
    UnicodeDecodeError
        If the file is not text in UTF-8.
    """
    settings: dict[str, str] = {}
    with path.open(encoding="utf-8-sig") as file:
        lines = _lines(file)
        for number, line in lines:
            said = line.lstrip("# ")
            delimiter = next((mark for mark in ",;\t" if mark in said), " ")
            if not line.startswith("#") or _names_columns(_cells(said, delimiter)):
                break
            name, _, value = said.partition("=")
            settings |= setting(name.strip(), value.strip(), number)
        else:
            raise RecordingError("is empty; its first line must name the columns: t,qw,qx,qy,qz")
        table = Table(_cells(said, delimiter))
        for number, line in lines:
            table.add(_cells(line, delimiter), f"line {number}")
    return Recording(path, table.arrays(), settings, table.ignored)


def _names_columns(cells: Sequence[str]) -> bool:
    """Return whether the cells of a line are headings of all columns that a motion needs."""
    try:
        columns_of(cells)
    except ColumnError:
        return False
    return True


def _cells(line: str, delimiter: str) -> list[str]:
    """Return the cells of a line; a space as delimiter stands for any white space."""
    if delimiter == " ":
        return line.split()
    return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter))]


def read_json_lines(path: Path) -> Recording:
    """Read a motion from JSON lines, each with one object: first settings, if any, then samples.

    The first object with a key that names the time, such as `t`, is the first sample.

    Raises
    ------
    RecordingError
        If the file does not hold such lines, a line is too long, there are too many lines, or the
        value of a setting is not permitted.
    ColumnError
        If the keys do not name the columns of a motion (see `columns_of`).
    UnicodeDecodeError
        If the file is not text in UTF-8.
    """
    settings: dict[str, str] = {}
    table: Table | None = None
    names: tuple[str, ...] = ()
    with path.open(encoding="utf-8-sig") as file:
        for number, line in _lines(file):
            record = _object(line, number)
            if table is None and not any(map(names_time, record)):
                for name, value in record.items():
                    settings |= setting(name, str(value), number)
                continue
            flat = list(_flat(record, number))
            keys = tuple(key for key, _ in flat)
            if table is None:
                names = keys
                table = Table(names)
            if keys != names:
                wanted = f"must have the keys of the first: {', '.join(names)}"
                raise RecordingError(f"line {number} {wanted}")
            table.add([value for _, value in flat], f"line {number}")
    if table is None:
        raise RecordingError('is empty; a line is {"t": 0.0, "q": [1, 0, 0, 0], …}')
    return Recording(path, table.arrays(), settings, table.ignored)


def _object(line: str, number: int) -> dict[str, Any]:
    """Return the JSON object in a line.

    Parameters
    ----------
    number : number of the line, for messages

    Raises
    ------
    RecordingError
        If the line holds no JSON object.
    """
    with suppress(ValueError, RecursionError):
        record = json.loads(line)
        if isinstance(record, dict):
            return record
    raise RecordingError(f"line {number} must be a JSON object")


def _flat(record: dict[str, Any], number: int) -> Iterator[tuple[str, Any]]:
    """Yield the name and the value of each column that a JSON object holds.

    A list of a quantity's components becomes one column for each component. Lists of anything else
    are left out.

    Parameters
    ----------
    record : the object, with its keys and values
    number : number of its line, for messages

    Raises
    ------
    RecordingError
        If a list has another number of components than its quantity.
    """
    quantities: dict[str, Quantity] = {quantity.name: quantity for quantity in QUANTITIES}
    for key, value in record.items():
        if not isinstance(value, list):
            yield key, value
            continue
        quantity = quantities.get(key)
        if quantity is None:
            continue
        columns = quantity.columns or [f"spin{k}" for k in range(1, len(value) + 1)]
        if len(value) != len(columns):
            wanted = f"'{key}' must have {len(columns)} numbers, got {len(value)}"
            raise RecordingError(f"line {number}: {wanted}")
        yield from zip(columns, value, strict=True)
