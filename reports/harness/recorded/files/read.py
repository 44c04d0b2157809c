"""Reads a recorded motion from a file: CSV, JSON lines, npz or Parquet.

Files are not trusted: no more is read of them than the largest motion takes, and nothing in them is
executed.
"""

import io
import lzma
import stat
import tokenize
import zipfile
import zlib
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib import format as npy

from .....scenarios import FloatArray, printable
from .recording import QUANTITIES, ColumnError, Recording, RecordingError, check_motion
from .text_formats import (
    LONGEST_LINE,
    SETTINGS,
    Table,
    check_count,
    read_csv,
    read_json_lines,
    setting,
)

#: The most bytes of an array's header that are read; the header of an array of numbers has 128.
LONGEST_HEADER = 1 << 10
#: Errors that damaged or encrypted archives raise; and errors that malformed headers raise.
DAMAGED = (zipfile.BadZipFile, zlib.error, lzma.LZMAError, EOFError, RuntimeError)
MALFORMED = (ValueError, TypeError, tokenize.TokenError, SyntaxError)


def read_npz(path: Path) -> Recording:
    """Read a motion from an npz archive: arrays with the names of `QUANTITIES`, and settings.

    A setting is an array of shape () with one of the names in `SETTINGS`. Other arrays are ignored.
    Whether all required arrays are there is not checked.

    Raises
    ------
    RecordingError
        If the archive cannot be read, an array is there twice or has a wrong type, shape or length,
        or the value of a setting is not permitted.
    """
    arrays: dict[str, FloatArray] = {}
    settings: dict[str, str] = {}
    ignored = []
    quantities = {q.name: q for q in QUANTITIES} | {q.written: q for q in QUANTITIES}
    try:
        with zipfile.ZipFile(path) as archive:
            for entry in archive.namelist():
                name = entry.removesuffix(".npy")
                # An array 'omega' of shape () is not ω, but the setting that states its axes.
                if name in SETTINGS and _header(archive, entry)[0] == ():
                    value = str(_array(archive, entry, ())[()])
                    settings |= setting(name, value, None)
                elif name in quantities:
                    quantity = quantities[name]
                    if quantity.name in arrays:
                        raise RecordingError(f"holds '{quantity.name}' twice")
                    width = len(quantity.columns) or None
                    shape = (None,) if quantity.name == "t" else (None, width)
                    arrays[quantity.name] = _array(archive, entry, shape).astype(float)
                else:
                    ignored.append(name)
    except (*DAMAGED, *MALFORMED) as error:
        if isinstance(error, RecordingError):
            raise
        raise RecordingError(
            f"is no npz archive that can be read: {printable(str(error))}"
        ) from None
    return Recording(path, arrays, settings, tuple(ignored))


def _header(archive: zipfile.ZipFile, entry: str) -> tuple[tuple[int, ...], np.dtype[Any]]:
    """Return the shape and type of the array in an archive's entry, without unpacking the array."""
    with archive.open(entry) as packed:
        file = io.BytesIO(packed.read(LONGEST_HEADER))
    version = npy.read_magic(file)
    read = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
    shape, _, dtype = read(file)
    return shape, dtype


def _array(archive: zipfile.ZipFile, entry: str, wanted: tuple[int | None, ...]) -> Any:
    """Return the array in an archive's entry; its type and shape are checked before it is unpacked.

    Parameters
    ----------
    wanted : the shape that the array must have; None stands for an axis of any length. An array of
        shape () may hold a text

    Raises
    ------
    RecordingError
        If the array has another shape or type, or too many rows.
    """
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
        check_count(shape[0])
    with archive.open(entry) as file:
        return npy.read_array(file, allow_pickle=False)


def read_parquet(path: Path) -> Recording:
    """Read a motion from a Parquet table with named columns, and settings from its metadata.

    Raises
    ------
    RecordingError
        If the file does not hold such a table, it has too many rows, the value of a setting is not
        permitted, or pyarrow is not installed.
    ColumnError
        If the headings do not name the columns of a motion (see `columns_of`).
    """
    try:
        import pyarrow
        from pyarrow import parquet
        from pyarrow.types import is_floating, is_integer
    except ImportError:
        raise RecordingError("needs 'pip install pyarrow' to be read; CSV does without") from None
    try:
        with parquet.ParquetFile(path) as file:
            check_count(file.metadata.num_rows)
            schema = file.schema_arrow
            ignored = Table([str(name) for name in schema.names]).ignored
            used = [field for field in schema if field.name not in ignored]
            for field in used:
                if not (is_floating(field.type) or is_integer(field.type)):
                    wanted = f"must hold numbers, got {printable(str(field.type), 40)}"
                    raise RecordingError(f"'{field.name}' {wanted}")
            # Other columns are not unpacked: a compressed column of texts may be very large.
            names = [field.name for field in used]
            table, row = Table(names), count(1)
            settings: dict[str, str] = {}
            for name, value in (schema.metadata or {}).items():
                if name.decode(errors="replace") in SETTINGS:
                    settings |= setting(name.decode(), value.decode(errors="replace"), None)
            for batch in file.iter_batches(columns=names):
                for cells in batch.to_pylist():
                    table.add(list(cells.values()), f"row {next(row)}")
    except pyarrow.ArrowException as error:
        raise RecordingError(
            f"is no Parquet file that can be read: {printable(str(error))}"
        ) from None
    return Recording(path, table.arrays(), settings, ignored)


#: The function that reads a file, by the ending of its name.
READERS = {
    ".csv": read_csv,
    ".txt": read_csv,
    ".jsonl": read_json_lines,
    ".ndjson": read_json_lines,
    ".npz": read_npz,
    ".parquet": read_parquet,
}


def read_recording(path: Path) -> Recording:
    """Read a recorded motion from a file, whose format is told by the ending of its name.

    Raises
    ------
    RecordingError
        If the file cannot be read, or does not hold a valid motion (see `check_motion`).
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
        # A library's own message may end with a full stop.
        raise RecordingError(f"{where}: {str(error).rstrip('.')}.") from None
    except OSError as error:
        raise RecordingError(
            f"{where}: cannot be read: {error.strerror or printable(str(error))}."
        ) from None
    except UnicodeDecodeError:
        raise RecordingError(f"{where}: must be text in UTF-8.") from None
    return recording
