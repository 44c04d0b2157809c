"""Recorded motions in text: CSV and JSON lines."""

import csv
import json
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import IO, Any

from .columns import QUANTITIES, Column, Quantity, columns_of
from .recording import Recording, RecordingError
from .rows import LONGEST_LINE, Table, setting


def _lines(file: IO[str]) -> Iterator[tuple[int, str]]:
    """Lines with their numbers, from 1 on; of one without an end only the beginning is read."""
    number = 0
    while line := file.readline(LONGEST_LINE):
        number += 1
        if len(line) == LONGEST_LINE:
            raise RecordingError(f"line {number} must be shorter than {LONGEST_LINE} characters")
        if line.strip():
            yield number, line.strip()


def read_csv(path: Path) -> Recording:
    """Read a table whose first line names its columns, below comments with settings.

    Raises
    ------
    RecordingError
        If the file holds no such motion.
    """
    settings: dict[str, str] = {}
    with path.open(encoding="utf-8-sig") as file:
        lines = _lines(file)
        for number, line in lines:
            if not line.startswith("#"):
                break
            name, _, value = line.lstrip("# ").partition("=")
            settings |= setting(name.strip(), value.strip(), number)
        else:
            raise RecordingError("is empty; its first line must name the columns: t,qw,qx,qy,qz")
        delimiter = next((mark for mark in ",;\t" if mark in line), " ")
        heads = _cells(line, delimiter)
        columns = columns_of(heads)
        table = Table(columns)
        for number, line in lines:
            table.add(_cells(line, delimiter), f"line {number}")
    ignored = tuple(h for h, column in zip(heads, columns, strict=True) if column is None)
    return Recording(path, table.arrays(), settings, ignored)


def _cells(line: str, delimiter: str) -> list[str]:
    if delimiter == " ":
        return line.split()
    return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter))]


def read_json_lines(path: Path) -> Recording:
    """Read one object a line, below one with settings.

    Raises
    ------
    RecordingError
        If the file holds no such motion.
    """
    settings: dict[str, str] = {}
    columns: list[Column | None] = []
    table = Table([])
    names: list[str] = []
    with path.open(encoding="utf-8-sig") as file:
        for number, line in _lines(file):
            record = _object(line, number)
            if not names and "t" not in record:
                for name, value in record.items():
                    settings |= setting(name, str(value), number)
                continue
            flat = dict(_flat(record, number))
            if not names:
                names, columns = list(flat), columns_of(list(flat))
                table = Table(columns)
            if list(flat) != names:
                wanted = f"must have the keys of the first: {', '.join(names)}"
                raise RecordingError(f"line {number} {wanted}")
            table.add(list(flat.values()), f"line {number}")
    if not names:
        raise RecordingError('is empty; a line is {"t": 0.0, "q": [1, 0, 0, 0], …}')
    ignored = tuple(n for n, column in zip(names, columns, strict=True) if column is None)
    return Recording(path, table.arrays(), settings, ignored)


def _object(line: str, number: int) -> dict[str, Any]:
    with suppress(ValueError, RecursionError):
        record = json.loads(line)
        if isinstance(record, dict):
            return record
    raise RecordingError(f"line {number} must be a JSON object")


def _flat(record: dict[str, Any], number: int) -> Iterator[tuple[str, Any]]:
    """Key by key; the components of a list under the names that they have in a table."""
    quantities: dict[str, Quantity] = {quantity.name: quantity for quantity in QUANTITIES}
    for key, value in record.items():
        if not isinstance(value, list):
            yield key, value
            continue
        quantity = quantities.get(key)
        if quantity is None:
            continue
        if len(value) != len(quantity.columns):
            wanted = f"'{key}' must have {len(quantity.columns)} numbers, got {len(value)}"
            raise RecordingError(f"line {number}: {wanted}")
        yield from zip(quantity.columns, value, strict=True)
