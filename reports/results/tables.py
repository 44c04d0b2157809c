"""The SQL tables of a result file: one for each kind of record, made from its dataclass.

Each field that identifies a record has a column, its motion is a blob, and all other fields are
one JSON object. A field that is added to a record needs no change here; records stored before have
its default. If the columns of a table change, `result_file.FORMAT` must be increased.

Motions are archives of arrays. An archive from elsewhere may unpack to any size. So before anything
is unpacked, the sizes that it declares are checked against the largest that a motion can have, and
no more bytes than declared are unpacked.
"""

import io
import json
import sqlite3
import zipfile
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from functools import cached_property, wraps
from typing import Any, Generic, ParamSpec, TypeVar

import numpy as np
from pydantic import TypeAdapter, ValidationError
from pydantic_core import to_jsonable_python

from ...scenarios import FloatArray, Trajectory, printable
from ...scenarios.document import MAX_ROTORS, MAX_SAMPLES
from .cost_records import MethodCost
from .database import shown
from .ensemble_records import DefinedEnsemble
from .evidence import Evidence
from .provenance_records import DeclaredEngine, EnvironmentEntry, Fingerprint
from .records import MOTIONS, Key, Record, Row, SolvedScene
from .result_file import ResultFileError
from .verdicts import Verdict

#: Largest size of an array's header, bytes: magic, shape and type (numpy.lib.format).
HEADER = 1 << 10
_NAMES = tuple(field.name for field in fields(Trajectory))
#: Names of the arrays that only motions of some scenes have.
_OPTIONAL = ("spins",)
#: Largest number of components of a sample in the other arrays: the four of a quaternion.
_WIDEST = 4


def pack(motion: Trajectory) -> bytes:
    """Return a motion as an archive in numpy's format .npz, not compressed.

    Compression would take several times as long, and make motions only a fifth smaller.
    """
    buffer = io.BytesIO()
    arrays: dict[str, Any] = {
        name: np.ascontiguousarray(values)
        for name in _NAMES
        if (values := getattr(motion, name)).size or name not in _OPTIONAL
    }
    np.savez(buffer, **arrays)
    return buffer.getvalue()


def unpack(blob: bytes) -> Trajectory:
    """Return the motion in an archive.

    Raises
    ------
    ValueError
        If the bytes are not an archive of a motion, or larger than a motion can be.
    zipfile.BadZipFile
        If the archive is damaged, according to its checksums (CRC-32).
    """
    with zipfile.ZipFile(io.BytesIO(blob)) as archive:
        members = archive.infolist()
        names = [member.filename.removesuffix(".npy") for member in members]
        if sorted({*names, *_OPTIONAL}) != sorted(_NAMES) or len(set(names)) < len(members):
            raise ValueError("the archive does not hold the arrays of a motion")
        arrays = {
            member.filename.removesuffix(".npy"): _array(archive, member) for member in members
        }
    return Trajectory(**arrays)


def _array(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> FloatArray:
    """Return one array of an archive; raise `ValueError` if it is not one of a motion."""
    widest = MAX_ROTORS if member.filename.removesuffix(".npy") in _OPTIONAL else _WIDEST
    if member.file_size > HEADER + widest * 8 * MAX_SAMPLES:
        raise ValueError(f"an array of {member.file_size} bytes, more than {MAX_SAMPLES} samples")
    if member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise ValueError("the archive is compressed otherwise than a motion is")
    with archive.open(member) as packed:
        # It is an error if there is one byte more than declared.
        content = packed.read(member.file_size + 1)
    stream = io.BytesIO(content)
    if np.lib.format.read_magic(stream) != (1, 0):
        raise ValueError("an array of another format")
    shape, in_columns, kind = np.lib.format.read_array_header_1_0(stream)
    values = content[stream.tell() :]
    if in_columns or kind != np.float64 or len(values) != 8 * int(np.prod(shape, dtype=object)):
        raise ValueError(f"an array of type {kind} and shape {shape} in {len(values)} bytes")
    return np.frombuffer(values).reshape(shape)


T = TypeVar("T")
R = TypeVar("R", bound=Record)
P = ParamSpec("P")

#: Largest length of a record as JSON, characters: a hundred times the length of evidence.
LONGEST_JSON = 1 << 20
#: Largest length of a complaint about a record, characters.
SHOWN = 200
#: Name of the column with the digest of what a record rests on.
DIGEST = "digest"
#: Names of the columns of a key that are not text: one is a number, others are JSON.
_NUMBER, _AS_JSON = "timestep", ("timesteps", "ensemble")
_NAMES_OF_KEY = tuple(field.name for field in fields(Key))


def as_result_file_error(read: Callable[P, T]) -> Callable[P, T]:
    """Return a function that does as `read`, but turns its exceptions into `ResultFileError`.

    It is for functions that read records, which raise various exceptions if a record is damaged.
    """

    @wraps(read)
    def reading(*arguments: P.args, **named: P.kwargs) -> T:
        try:
            return read(*arguments, **named)
        except ValidationError as error:
            first = error.errors(include_url=False)[0]
            words = f"{'.'.join(map(str, first['loc']))}: {first['msg']}, got {first['input']!r}"
            raise ResultFileError(f"a record cannot be read: {printable(words, SHOWN)}") from error
        # Parsers of damaged JSON, archives, arrays and scenes raise different errors.
        except Exception as error:
            words = printable(str(error), SHOWN)
            raise ResultFileError(f"a record cannot be read: {words}") from error

    return reading


@dataclass(frozen=True)
class Table(Generic[R]):
    """The SQL table of one dataclass's records.

    Attributes
    ----------
    name : name of the table
    record : the dataclass
    key : the columns that identify a record: fields of the record, or of its `Key`
    rests_on : kinds of the fingerprints that a record rests on; empty if it rests on none. The
        digest of these fingerprints is part of the primary key, so that records of several versions
        of program, scene and engine can be kept
    """

    name: str
    record: type[R]
    key: tuple[str, ...]
    rests_on: tuple[str, ...] = ()

    @property
    def sql(self) -> str:
        """The SQL statement that creates the table."""
        columns = [f"{name} {'REAL' if name == _NUMBER else 'TEXT'}" for name in self.key]
        columns += ["record TEXT NOT NULL", *(f"{name} BLOB" for name in self.motions)]
        digest = [DIGEST] * bool(self.rests_on)
        columns += [f"{name} TEXT" for name in digest]
        columns += ["checksum TEXT NOT NULL", f"PRIMARY KEY ({', '.join([*self.key, *digest])})"]
        return f"CREATE TABLE {self.name} ({', '.join(columns)});\n"

    @cached_property
    def motions(self) -> tuple[str, ...]:
        """The names of the columns that hold motions."""
        return tuple(field.name for field in fields(self.record) if field.name in MOTIONS)

    def columns(self, record: R) -> dict[str, Any]:
        """Return the values that are stored of a record, by column.

        Fields that are None are left out if None is their default. The checksum and the digest of
        what the record rests on are not included.
        """
        values = {field.name: getattr(record, field.name) for field in fields(self.record)}
        motions = {name: values.pop(name) for name in self.motions}
        plain = to_jsonable_python(values, inf_nan_mode="constants", fallback=np.ndarray.tolist)
        content = plain if _is_shown(json.dumps(plain, ensure_ascii=False)) else _shown(plain)
        content |= content.pop("key", {})
        identity = {name: content.pop(name) for name in self.key}
        identity |= {n: json.dumps(value) for n, value in identity.items() if n in _AS_JSON}
        absent = {f.name for f in fields(self.record) if f.default is None}
        content = {n: v for n, v in content.items() if v is not None or n not in absent}
        return {
            **identity,
            "record": json.dumps(content, ensure_ascii=False),
            **{name: pack(motion) if motion else None for name, motion in motions.items()},
        }

    @as_result_file_error
    def read(self, columns: sqlite3.Row) -> R:
        """Return the record that is stored in a row of the table.

        Raises
        ------
        ResultFileError
            If a value is not of its field's declared type, or a field is missing or unknown.
        """
        content = from_json(columns["record"])
        content |= {
            name: json.loads(columns[name]) if name in _AS_JSON else columns[name]
            for name in self.key
        }
        if self._has_key:
            content["key"] = {name: content.pop(name, None) for name in _NAMES_OF_KEY}
        record = self._adapter.validate_json(json.dumps(content), strict=True)
        return replace(
            record, **{name: unpack(columns[name]) for name in self.motions if columns[name]}
        )

    @cached_property
    def _has_key(self) -> bool:
        """Whether the record has a `Key`, whose fields are columns."""
        return any(field.name == "key" for field in fields(self.record))

    @cached_property
    def _adapter(self) -> TypeAdapter[R]:
        """The validator of the record."""
        return TypeAdapter(self.record)


def from_json(text: Any) -> dict[str, Any]:
    """Return the object that a JSON text holds, with control characters in its strings escaped.

    Raises
    ------
    ValueError
        If the text is not a JSON object, or too long.
    """
    if not isinstance(text, str) or len(text) > LONGEST_JSON:
        raise ValueError(f"JSON must be a text of at most {LONGEST_JSON} characters")
    content = json.loads(text)
    if not isinstance(content, dict):
        raise ValueError(f"must be a JSON object, got {content!r}")
    shown_content: dict[str, Any] = content if _is_shown(text) else _shown(content)
    return shown_content


def _is_shown(text: str) -> bool:
    """Whether a JSON text holds no control characters: it is printable and has no escapes."""
    return text.isprintable() and "\\" not in text


def _shown(value: Any) -> Any:
    """Return a value from JSON with control characters in all its strings and names escaped."""
    if isinstance(value, str):
        return shown(value)
    if isinstance(value, dict):
        return {shown(name): _shown(entry) for name, entry in value.items()}
    return [_shown(entry) for entry in value] if isinstance(value, list) else value


_ONE_METHOD = ("scenario", "engine", "method")
ENVIRONMENT = Table("environment", EnvironmentEntry, ("name",))
ENGINES = Table("engines", DeclaredEngine, ("name",))
FINGERPRINTS = Table("fingerprints", Fingerprint, ("scenario", "engine", "kind"))
SCENES = Table("scenes", SolvedScene, ("scenario",), ("motion",))
_RUN, _COST = ("motion", "run", "engine"), ("motion", "timing", "engine")
ROWS = Table("rows", Row, (*_ONE_METHOD, "variation", "timestep"), _RUN)
EVIDENCE = Table("evidence", Evidence, _ONE_METHOD, _RUN)
VERDICTS = Table("verdicts", Verdict, (*_ONE_METHOD, "timesteps"), (*_RUN, "verdict"))
COSTS = Table("costs", MethodCost, (*_ONE_METHOD, "variation"), _COST)
#: Tables with results of a method on a scene.
OF_STUDIES = (
    ROWS,
    EVIDENCE,
    VERDICTS,
    COSTS,
)
ENSEMBLES = Table("ensembles", DefinedEnsemble, ("scenario", "ensemble"), ("motion",))
TABLES: tuple[Table[Any], ...] = (
    *(ENVIRONMENT, ENGINES, FINGERPRINTS, SCENES, ENSEMBLES),
    *OF_STUDIES,
)
