"""Error messages about a scenario file: file, line, table, key, value, rule."""

import difflib
from collections.abc import Iterable, Iterator
from typing import Any, get_args

from pydantic import BaseModel
from pydantic_core import ErrorDetails

from .document import Document
from .errors import Misfit, printable
from .locate import Keys, line_of

#: Largest number of complaints reported about one file.
MAX_COMPLAINTS = 20
#: Largest number of characters shown of a key, a value or a parser's message.
MAX_SHOWN = 100
_PUBLISHED = ("omega_body", "omega_world", "com_world", "L_world")
_UNION_ARMS = (
    ("inertia", "moments"),
    ("inertia", "matrix"),
    *((name, arm) for name in _PUBLISHED for arm in ("all", "some")),
)
#: The rule in TOML's terms, by pydantic's name for the error, where pydantic's own message has
#: Python's types.
_IN_TOML = {
    "model_type": "must be a table",
    "tuple_type": "must be an array",
    "float_type": "must be a number",
    "int_type": "must be a whole number",
    "int_from_float": "must be a whole number",
    "string_type": "must be text",
    "string_too_short": "must not be empty",
    "string_pattern_mismatch": "must be a SHA-256, 64 hexadecimal digits",
}


def validation_message(details: list[ErrorDetails], text: str, where: str) -> str:
    """Return the message about errors that pydantic found in a scenario file.

    It has one line for each key with errors, even if several entries of the key's array are wrong,
    for at most `MAX_COMPLAINTS` keys. If there are more errors than that, a last line says that
    further errors are not listed.

    Parameters
    ----------
    details : pydantic's errors
    text : text of the file
    where : name of the file
    """
    lines: dict[Keys, str] = {}
    for detail in details:
        keys = _keys(detail)
        if (key := _without_entries(keys)) not in lines and len(lines) < MAX_COMPLAINTS:
            lines[key] = at(where, line_of(text, keys), _explain(detail, keys))
    if len(details) > MAX_COMPLAINTS:
        return "\n".join([*lines.values(), f"{where}: further errors are not listed"])
    return "\n".join(lines.values())


def misfit(error: Misfit, text: str, where: str) -> str:
    """Return the message of a `Misfit`, with the file, line and key of the wrong value before it.

    Parameters
    ----------
    text : text of the file
    where : name of the file
    """
    return at(where, line_of(text, error.keys), f"{_spell(error.keys)}{error}")


def at(where: str, line: int | None, complaint: str) -> str:
    """Return a complaint with the file's name `where`, and the line if known, before it."""
    return f"{where}:{line}: {complaint}" if line else f"{where}: {complaint}"


def _keys(detail: ErrorDetails) -> Keys:
    """Return the path of keys, and of indices in arrays, to the place of an error in the file."""
    keys = detail["loc"]
    # Names of union arms are pydantic's own, not the file's.
    loc = tuple(k for n, k in enumerate(keys) if n == 0 or (keys[n - 1], k) not in _UNION_ARMS)
    error = detail.get("ctx", {}).get("error")
    return (*loc, *error.keys) if isinstance(error, Misfit) else loc


def _without_entries(keys: Keys) -> Keys:
    """Return a path of keys without trailing indices, except one into an array of tables.

    For example, ("body", "com", 1) becomes ("body", "com").
    """
    least = 2 if keys[:1] and keys[0] in _TABLE_ARRAYS else 1
    while len(keys) > least and isinstance(keys[-1], int):
        keys = keys[:-1]
    return keys


def _explain(detail: ErrorDetails, keys: Keys) -> str:
    """Return spincheck's message about an error that pydantic found: its keys and the broken rule.

    Parameters
    ----------
    keys : the path of keys to the wrong value in the file
    """
    return f"{_spell(keys)}{_rule(detail, keys)}"


def _spell(keys: Keys) -> str:
    """Return a path of keys as users read it: "[body] com[1]: " for ("body", "com", 1).

    It is empty for an empty path.
    """
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
        last = ".".join(tables[1:])
        entries: Keys = tuple(key for key in keys[2:] if isinstance(key, int))
    else:
        head = f"[{'.'.join(parents)}] " if parents else ""
        entries = keys[len(tables) :]
    return printable(head + last + "".join(f"[{entry}]" for entry in entries), MAX_SHOWN) + ": "


def _rule(detail: ErrorDetails, keys: Keys) -> str:
    """Return in words the rule that an error is about, and the value that breaks it.

    Parameters
    ----------
    keys : the path of keys to that value, or to a key that is missing or unknown
    """
    if detail["type"] == "extra_forbidden":
        key = str(keys[-1])
        if len(keys) == 1 and key in _known_keys(("effects",)):
            return f"unknown key; did you mean '[effects.{key}]'?"
        return _unknown_key(key, _known_keys(keys[:-1]))
    if detail["type"] == "missing":
        return "is missing"
    if detail["type"] == "value_error":
        return str(detail["ctx"]["error"])
    if detail["type"] == "too_short":
        least = detail["ctx"]["min_length"]
        return f"must have at least {least} entries, got {_shown(detail['input'])}"
    if detail["type"] == "too_long":
        most, got = detail["ctx"]["max_length"], detail["ctx"]["actual_length"]
        at_most = "at most " if keys[-1] in _TABLE_ARRAYS else ""
        return f"must have {at_most}{most} entries, got {got}: {_shown(detail['input'])}"
    message = _IN_TOML.get(detail["type"]) or detail["msg"].replace("Input should", "must")
    if detail["type"] == "float_type" and type(detail["input"]) is int:
        message = "is too large for a double"
    return f"{message}, got {_shown(detail['input'])}"


def _unknown_key(key: str, known_keys: Iterable[str]) -> str:
    """Return the message that a key is unknown: the known key nearest to it, and all known keys."""
    known_keys = sorted(known_keys)
    close = difflib.get_close_matches(key, known_keys, n=1)
    hint = f"did you mean '{close[0]}'? " if close else ""
    return f"unknown key; {hint}known keys: {', '.join(known_keys) or 'none'}"


def _known_keys(table: Keys) -> list[str]:
    """Return the keys that the format allows in a TOML table, given the path of keys to it."""
    model: type[BaseModel] = Document
    for key in table:
        if isinstance(key, str):
            model = next(_models_in(model.model_fields[key].annotation))
    return list(model.model_fields)


def _models_in(annotation: Any) -> Iterator[type[BaseModel]]:
    """Yield the pydantic models inside a type such as ``Table | None`` or ``tuple[Table, ...]``."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for arm in get_args(annotation):
        yield from _models_in(arm)


def _shown(value: Any) -> str:
    """Return a value as text for a message, of `MAX_SHOWN` characters at most."""
    try:
        return printable(repr(value), MAX_SHOWN)
    except ValueError:  # Python's own limit on the digits of an integer, here a hexadecimal one.
        return "an integer of thousands of digits"


_WITH_TABLES = {name: one.annotation for name, one in Document.model_fields.items()}
_TABLES = {name for name, kind in _WITH_TABLES.items() if kind in (*_models_in(kind),)}
_TABLE_ARRAYS = {name for name, kind in _WITH_TABLES.items() if any(_models_in(kind))} - _TABLES
