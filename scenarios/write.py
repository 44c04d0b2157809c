"""Writes the tables of a scenario as TOML, because the standard library only reads TOML."""

import json
from collections.abc import Iterator, Mapping
from typing import Any

#: The control character that TOML wants escaped and JSON leaves as it is.
DELETE, ESCAPED_DELETE = "\x7f", "\\u007f"


def to_toml(tables: Mapping[str, Any]) -> str:
    """Return a TOML text that reads back as the given tables, numbers to the last bit.

    Parameters
    ----------
    tables : as `tomllib` gives them; keys are bare, arrays hold numbers, strings or arrays
    """
    return "\n".join(_lines(tables, "")) + "\n"


def _lines(table: Mapping[str, Any], name: str) -> Iterator[str]:
    """Yield the lines of a TOML table with a dotted `name`, empty for the file's top.

    Plain keys come first, since in TOML all that follows a heading belongs to that heading.
    """
    inner = {key: value for key, value in table.items() if _is_table(value)}
    for key, value in table.items():
        if key not in inner:
            yield f"{key} = {_value(value)}"
    for key, value in inner.items():
        path = f"{name}.{key}" if name else key
        for one in [value] if isinstance(value, Mapping) else value:
            # A table that contains only other tables needs no heading of its own.
            if not (one and all(_is_table(entry) for entry in one.values())):
                yield f"\n[{path}]" if one is value else f"\n[[{path}]]"
            yield from _lines(one, path)


def _is_table(value: Any) -> bool:
    """Whether a value is a table or an array of tables."""
    listed = isinstance(value, list) and bool(value)
    return isinstance(value, Mapping) or (listed and isinstance(value[0], Mapping))


def _value(value: Any) -> str:
    """Return a number, text, boolean or array as TOML."""
    if isinstance(value, list | tuple):
        return f"[{', '.join(_value(entry) for entry in value)}]"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace(DELETE, ESCAPED_DELETE)
    # Python's text of an integer or a double is TOML, and reads back as the same number.
    return json.dumps(value) if isinstance(value, bool) else repr(value)
