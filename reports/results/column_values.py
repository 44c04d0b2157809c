"""Checks what a column of a result file holds: SQLite takes any value in any column."""

import json
import math
import sqlite3
from collections.abc import Callable
from functools import cache, wraps
from typing import Any, TypeVar, get_type_hints

from pydantic import TypeAdapter, ValidationError

from ...scenarios import Trajectory, is_scene_name, printable
from .database import shown
from .records import LARGEST
from .result_file import ResultFileError
from .sweep_records import PointResult

T = TypeVar("T")

#: Characters; the two axes of a map have some 40 000.
LONGEST_JSON = 1 << 20
#: Characters of a complaint about a record.
SHOWN = 200


def as_result_file_error(read: Callable[..., T]) -> Callable[..., T]:
    """Turn what a damaged record raises into one kind of error."""

    @wraps(read)
    def reading(*arguments: Any) -> T:
        try:
            return read(*arguments)
        # Damaged JSON, archives, arrays and scenes raise different errors of their parsers.
        except Exception as error:
            words = printable(str(error), SHOWN)
            raise ResultFileError(f"a record cannot be read: {words}") from error

    return reading


def scene_name(record: sqlite3.Row) -> str:
    """The name in a record's column `scenario`.

    Raises
    ------
    ValueError
        If it is not a valid name of a scene: pages are named after scenes.
    """
    name = text_of(record["scenario"])
    if not is_scene_name(name):
        raise ValueError(f"{printable(name)!r} is no scene's name")
    return name


def from_json(text: Any, kind: type[T]) -> T:
    """The JSON in a column, with control characters of its texts escaped.

    Raises
    ------
    ValueError
        If it is not JSON, too long, or of another type.
    """
    if len(text_of(text)) > LONGEST_JSON:
        raise ValueError(f"JSON of more than {LONGEST_JSON} characters")
    value = _shown(json.loads(text))
    if not isinstance(value, kind):
        raise ValueError(f"JSON of another kind: {str(value)!r}")
    return value


def _shown(value: Any) -> Any:
    """The value with control characters of its texts escaped, which JSON's own escapes hid."""
    if isinstance(value, str):
        return shown(value)
    if isinstance(value, dict):
        return {_shown(name): _shown(entry) for name, entry in value.items()}
    return [_shown(entry) for entry in value] if isinstance(value, list) else value


def text_of(value: Any) -> str:
    """The value, which must be a text.

    Raises
    ------
    ValueError
        If it is not.
    """
    check("a text", value, str)
    return str(value)


def typed(record: T) -> T:
    """The record, after a check that its values are of the types that its class declares.

    Raises
    ------
    ValueError
        If one is not: SQLite takes any value in any column.
    """
    kind: type = type(record)
    for name, declared in _declared(kind).items():
        value = getattr(record, name)
        # A trajectory checks its own arrays when it is constructed.
        if not isinstance(value, Trajectory | None):
            check(name, value, declared)
        if isinstance(record, PointResult) and isinstance(value, float | int):
            _check_size(name, value)
    return record


@cache
def _declared(kind: type) -> dict[str, Any]:
    return get_type_hints(kind)


def _check_size(name: str, value: float) -> None:
    """Check that a number of a run is not negative, nor so large that its square overflows."""
    if not 0 <= value <= LARGEST and value != math.inf:
        raise ValueError(f"{name}: must be from 0 to {LARGEST:g}, got {value!r}")


def check(name: str, value: Any, declared: Any) -> None:
    """Check that a value is of a declared type.

    Raises
    ------
    ValueError
        If it is not.
    """
    try:
        _adapter(declared).validate_python(value, strict=True)
    except ValidationError as error:
        rule = error.errors()[0]["msg"]
        raise ValueError(f"{name}: {rule[0].lower()}{rule[1:]}, got {value!r}") from None


@cache
def _adapter(declared: Any) -> TypeAdapter[Any]:
    return TypeAdapter(declared)
