"""Reads scenario files; every complaint names file, line, table, key, value and rule."""

import difflib
import tomllib
from collections.abc import Iterable
from pathlib import Path
from typing import Any, get_args

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from .document import Document
from .errors import ScenarioError
from .locate import line_of
from .scenario import Scenario, build

MARKER = "spincheck"
#: No scenario is this long; a larger file is something else, given by mistake.
MAX_BYTES = 1 << 20
_TABLES = ("body", "start", "effects", "window")
_TABLE_ARRAYS = ("published", "expect")
#: Where pydantic would speak of Python's types, by its name for the error.
_IN_TOML = {"model_type": "must be a table", "tuple_type": "must be an array"}


def load(path: str | Path) -> Scenario:
    """Read one scenario file.

    Raises
    ------
    ScenarioError
        If the file cannot be read, is not TOML, or breaks a rule of the format.
    """
    path = Path(path)
    try:
        if path.stat().st_size > MAX_BYTES:
            raise ScenarioError(f"{path}: too large for a scenario, the limit is {MAX_BYTES} bytes")
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise ScenarioError(f"{path}: cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise ScenarioError(f"{path}: not a text file in UTF-8") from None
    return loads(text, name=path.stem, path=path)


def loads(text: str, name: str, path: Path | None = None) -> Scenario:
    """Build a scenario from a file's text; `name` stands in for the file's stem.

    Raises
    ------
    ScenarioError
        As `load`.
    """
    where = str(path or name)
    if not all(c.isalnum() or c in "-_." for c in name) or not name[:1].isalnum():
        raise ScenarioError(
            f"{where}: a scenario's name is its file's stem; use letters, digits, '-', '_', '.'"
        )
    try:
        tables = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ScenarioError(f"{where}: not valid TOML: {error}") from None
    if MARKER not in tables:
        raise ScenarioError(f"{where}: not a scenario: the first key must be 'spincheck = 1'")
    try:
        document = Document.model_validate(tables)
        return build(document, name=name, text=text, path=path)
    except ValidationError as error:
        lines = dict.fromkeys(_explain(detail, text, where) for detail in error.errors())
        raise ScenarioError("\n".join(lines)) from None


def is_scenario(path: Path) -> bool:
    """Whether a TOML file's first key is `spincheck`, without judging the rest of it."""
    try:
        with path.open(encoding="utf-8") as file:
            for line in file:
                stripped = line.strip()
                if stripped and not stripped.startswith("#"):
                    return stripped.split("=")[0].strip() == MARKER
    except (OSError, UnicodeDecodeError):
        return False
    return False


def _explain(detail: ErrorDetails, text: str, where: str) -> str:
    """One pydantic error in the house's words."""
    # Names of union arms are pydantic's own, not the file's.
    keys = tuple(key for key in detail["loc"] if key not in ("moments", "matrix"))
    line = line_of(text, keys)
    place = f"{where}:{line}" if line else where
    return f"{place}: {_spell(keys)}{_rule(detail, keys)}"


def _spell(keys: tuple[int | str, ...]) -> str:
    """("body", "com", 1) as "[body] com[1]: "."""
    if not keys:
        return ""
    tables = [key for key in keys if isinstance(key, str)]
    if len(keys) == 1 and keys[0] in _TABLES:
        return f"[{keys[0]}]: "
    if len(keys) == 2 and keys[0] in _TABLE_ARRAYS and isinstance(keys[1], int):
        return f"[[{keys[0]}]] number {keys[1] + 1}: "
    parents, last = tables[:-1], tables[-1]
    if len(keys) > 1 and isinstance(keys[1], int) and parents:
        head = f"[[{parents[0]}]] number {keys[1] + 1} "
        entries = keys[3:]
    else:
        head = f"[{'.'.join(parents)}] " if parents else ""
        entries = keys[len(tables) :]
    return head + last + "".join(f"[{entry}]" for entry in entries) + ": "


def _rule(detail: ErrorDetails, keys: tuple[int | str, ...]) -> str:
    if detail["type"] == "extra_forbidden":
        return _unknown_key(str(keys[-1]), _known_keys(keys[:-1]))
    if detail["type"] == "missing":
        return "is missing"
    if detail["type"] == "value_error":
        return str(detail["ctx"]["error"])
    if detail["type"] == "too_short":
        least = detail["ctx"]["min_length"]
        return f"must have at least {least} entries, got {_shown(detail['input'])}"
    message = _IN_TOML.get(detail["type"]) or detail["msg"][0].lower() + detail["msg"][1:]
    return f"{message}, got {_shown(detail['input'])}"


def _unknown_key(key: str, known: Iterable[str]) -> str:
    known = sorted(known)
    close = difflib.get_close_matches(key, known, n=1)
    hint = f"did you mean '{close[0]}'? " if close else ""
    return f"unknown key; {hint}known keys: {', '.join(known)}"


def _known_keys(table: tuple[int | str, ...]) -> list[str]:
    """The keys the model at this place of the file knows."""
    model: type[BaseModel] = Document
    for key in table:
        if isinstance(key, str):
            model = _model_in(model.model_fields[key].annotation)
    return list(model.model_fields)


def _model_in(annotation: Any) -> type[BaseModel]:
    """The table model inside an annotation such as ``Table | None`` or ``tuple[Table, ...]``."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    return next(_model_in(arm) for arm in get_args(annotation) if arm not in (type(None), ...))


def _shown(value: Any, limit: int = 80) -> str:
    shown = repr(value)
    return shown if len(shown) <= limit else f"{shown[:limit]}…"
