"""A recorded motion read from a file: CSV, JSON lines, npz or Parquet.

Files may come from anyone and be of any size: they are read in pieces, no further than to the
largest number of samples, and nothing in them is executed.
"""

import csv
import json
import stat
import zipfile
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from ....scenarios import FloatArray, printable
from ....scenarios.document import MAX_SAMPLES
from .columns import QUANTITIES, Column, ColumnError, Quantity, columns_of

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
#: How far a quaternion's norm may be off: what is printed with four digits passes.
UNIT_SLACK = 1e-3


class RecordingError(ValueError):
    """A file that holds no motion that can be judged: one sentence with file, place and remedy."""


@dataclass(frozen=True, eq=False)
class Recording:
    """The numbers of a file in SI units, as it states them.

    Attributes
    ----------
    path : the file
    arrays : t (n,), q (n, 4) and, where the file has them, omega, com, velocity, (n, 3)
    settings : what the file states of itself, by the names of `SETTINGS`
    ignored : headings of columns that mean nothing here
    """

    path: Path
    arrays: dict[str, FloatArray]
    settings: dict[str, str] = field(default_factory=dict)
    ignored: tuple[str, ...] = ()

    @property
    def is_single(self) -> bool:
        """Whether it was computed in single precision: says so, or its attitudes have 24 bits."""
        q = self.arrays["q"]
        has_24_bits = np.array_equal(q, q.astype(np.float32)) and not np.array_equal(q, np.rint(q))
        return self.settings.get("precision", "single" if has_24_bits else "double") == "single"


def read_recording(path: Path) -> Recording:
    """Read a recorded motion, by the ending of the file's name.

    Raises
    ------
    RecordingError
        If the file cannot be read, or holds no such motion.
    """
    where = printable(str(path))
    reader = READERS.get(path.suffix.lower())
    try:
        if not stat.S_ISREG(path.stat().st_mode):
            raise RecordingError("is not a regular file")
        if reader is None:
            raise RecordingError(f"its name must end in one of {', '.join(READERS)}")
        recording = reader(path)
        check_motion(recording.arrays)
    except (RecordingError, ColumnError) as error:
        # A library's own message may end with one.
        raise RecordingError(f"{where}: {str(error).rstrip('.')}.") from None
    except OSError as error:
        raise RecordingError(f"{where}: cannot be read: {error.strerror}.") from None
    except UnicodeDecodeError:
        raise RecordingError(f"{where}: must be text in UTF-8.") from None
    return recording


def _lines(file: IO[str]) -> Iterator[tuple[int, str]]:
    """Lines with their numbers, from 1 on; of one without an end only the beginning is read."""
    number = 0
    while line := file.readline(LONGEST_LINE):
        number += 1
        if len(line) == LONGEST_LINE:
            raise RecordingError(f"line {number} must be shorter than {LONGEST_LINE} characters")
        if line.strip():
            yield number, line.strip()


def _csv(path: Path) -> Recording:
    settings: dict[str, str] = {}
    with path.open(encoding="utf-8-sig") as file:
        lines = _lines(file)
        for number, line in lines:
            if not line.startswith("#"):
                break
            name, _, value = line.lstrip("# ").partition("=")
            settings |= _setting(name.strip(), value.strip(), number)
        else:
            raise RecordingError("is empty; its first line must name the columns: t,qw,qx,qy,qz")
        delimiter = next((mark for mark in ",;\t" if mark in line), " ")
        heads = _cells(line, delimiter)
        columns = columns_of(heads)
        table = _Table(columns)
        for number, line in lines:
            table.add(_cells(line, delimiter), f"line {number}")
    ignored = tuple(h for h, column in zip(heads, columns, strict=True) if column is None)
    return Recording(path, table.arrays(), settings, ignored)


def _cells(line: str, delimiter: str) -> list[str]:
    if delimiter == " ":
        return line.split()
    return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter))]


class _Table:
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
        _check_count(len(self._rows))

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


def _json_lines(path: Path) -> Recording:
    settings: dict[str, str] = {}
    columns: list[Column | None] = []
    table = _Table([])
    names: list[str] = []
    with path.open(encoding="utf-8-sig") as file:
        for number, line in _lines(file):
            record = _object(line, number)
            if not names and "t" not in record:
                for name, value in record.items():
                    settings |= _setting(name, str(value), number)
                continue
            flat = dict(_flat(record, number))
            if not names:
                names, columns = list(flat), columns_of(list(flat))
                table = _Table(columns)
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


def _npz(path: Path) -> Recording:
    arrays: dict[str, FloatArray] = {}
    settings: dict[str, str] = {}
    ignored = []
    quantities = {q.name: q for q in QUANTITIES} | {q.written: q for q in QUANTITIES}
    try:
        with zipfile.ZipFile(path) as archive:
            for entry in archive.namelist():
                name = entry.removesuffix(".npy")
                # ω itself, or the axes that it is in.
                if name in SETTINGS and _header(archive, entry)[0] == ():
                    value = str(_array(archive, entry, ())[()])
                    settings |= _setting(name, value, None)
                elif name in quantities:
                    quantity = quantities[name]
                    width = len(quantity.columns)
                    shape = (None,) if quantity.name == "t" else (None, width)
                    arrays[quantity.name] = _array(archive, entry, shape).astype(float)
                else:
                    ignored.append(name)
    except (zipfile.BadZipFile, ValueError, EOFError, NotImplementedError) as error:
        if isinstance(error, RecordingError):
            raise
        raise RecordingError(
            f"is no npz archive that can be read: {printable(str(error))}"
        ) from None
    return Recording(path, arrays, settings, tuple(ignored))


def _header(archive: zipfile.ZipFile, entry: str) -> tuple[tuple[int, ...], np.dtype[Any]]:
    """Shape and type of an array, which is not unpacked."""
    with archive.open(entry) as file:
        version = npy.read_magic(file)
        read = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
        shape, _, dtype = read(file)
    return shape, dtype


def _array(archive: zipfile.ZipFile, entry: str, wanted: tuple[int | None, ...]) -> Any:
    """An array whose shape is checked before it is unpacked."""
    shape, dtype = _header(archive, entry)
    is_text = dtype.kind == "U" and dtype.itemsize <= 4 * LONGEST_LINE
    if dtype.kind not in "fiu" and not (wanted == () and is_text):
        raise RecordingError(f"'{printable(entry)}' must hold numbers, got {dtype}")
    fits = len(shape) == len(wanted) and all(
        w in (None, size) for w, size in zip(wanted, shape, strict=True)
    )
    if not fits:
        form = ", ".join("n" if size is None else str(size) for size in wanted)
        raise RecordingError(f"'{printable(entry)}' must have the shape ({form}), got {shape}")
    if shape:
        _check_count(shape[0])
    with archive.open(entry) as file:
        return npy.read_array(file, allow_pickle=False)


def _parquet(path: Path) -> Recording:
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        raise RecordingError("needs 'pip install pyarrow' to be read; CSV does without") from None
    try:
        with parquet.ParquetFile(path) as file:
            _check_count(file.metadata.num_rows)
            heads = [str(name) for name in file.schema_arrow.names]
            columns = columns_of(heads)
            settings: dict[str, str] = {}
            for name, value in (file.schema_arrow.metadata or {}).items():
                if name.decode(errors="replace") in SETTINGS:
                    settings |= _setting(name.decode(), value.decode(errors="replace"), None)
            table = _Table(columns)
            for batch in file.iter_batches():
                for k, row in enumerate(batch.to_pylist()):
                    table.add(list(row.values()), f"row {k + 1}")
    except pyarrow.ArrowException as error:
        raise RecordingError(
            f"is no Parquet file that can be read: {printable(str(error))}"
        ) from None
    ignored = tuple(h for h, column in zip(heads, columns, strict=True) if column is None)
    return Recording(path, table.arrays(), settings, ignored)


def _setting(name: str, value: str, line: int | None) -> dict[str, str]:
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


def _check_count(samples: int) -> None:
    if samples > MAX_SAMPLES:
        raise RecordingError(
            f"must have at most {MAX_SAMPLES} samples; write every second or tenth of them"
        )


def check_motion(arrays: dict[str, FloatArray]) -> None:
    """Check what holds between samples: times, and the norms of quaternions."""
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
    if (back := np.diff(times) <= 0).any():
        k = _first(back)
        raise RecordingError(
            f"times must increase, got {times[k - 1]:.17g} s and then {times[k]:.17g} s"
        )
    norms = np.linalg.norm(arrays["q"], axis=1)
    if (off := np.abs(norms - 1) > UNIT_SLACK).any():
        k = _first(off) - 1
        raise RecordingError(
            f"quaternions must be of unit norm, that of sample {k} is {norms[k]:.4g} long"
        )


def _first(wrong: NDArray[np.bool_]) -> int:
    """The number of the first row with something wrong, counted from one."""
    return int(np.argmax(wrong.reshape(len(wrong), -1).any(axis=1))) + 1


#: By the ending of a file's name, what reads it.
READERS = {
    ".csv": _csv,
    ".txt": _csv,
    ".jsonl": _json_lines,
    ".ndjson": _json_lines,
    ".npz": _npz,
    ".parquet": _parquet,
}
