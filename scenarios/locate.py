"""Finds the line of a TOML file on which a key stands; the standard parser does not say."""

import re
from functools import lru_cache

#: A path of keys and indices to a value in the tables that the parser returns.
Keys = tuple[int | str, ...]

_HEADER = re.compile(r"^\s*(\[\[?)\s*([\w.\-\s]+?)\s*\]\]?")
_KEY = re.compile(r"^\s*([\w.\-]+)\s*=")


def line_of(text: str, keys: Keys) -> int | None:
    """Return the line, counted from 1, of a key in a TOML file, or else of the table around it.

    It is the line of the longest prefix of `keys` that the text has, and None if the text has not
    even the first key.

    Parameters
    ----------
    text : a TOML file
    keys : a path such as ("body", "com", 1) or ("published", 0, "t")
    """
    lines = _key_lines(text)
    for length in range(len(keys), 0, -1):
        if keys[:length] in lines:
            return lines[keys[:length]]
    return None


@lru_cache(maxsize=1)  # every complaint about a file asks for its lines again
def _key_lines(text: str) -> dict[Keys, int]:
    """Return the line of every table and key of a TOML text, except keys inside inline tables."""
    lines: dict[Keys, int] = {}
    table: Keys = ()
    seen: dict[str, int] = {}
    quote: str | None = None
    for number, line in enumerate(text.split("\n"), start=1):
        if quote is None:
            if header := _HEADER.match(line):
                table = _table_path(header[1], header[2], seen)
                for length in range(1, len(table) + 1):
                    lines.setdefault(table[:length], number)
            elif key := _KEY.match(line):
                lines.setdefault((*table, *key[1].split(".")), number)
        quote = _open_quote(line, quote)
    return lines


def _table_path(brackets: str, name: str, seen: dict[str, int]) -> Keys:
    """Return the path of keys to the table of a heading such as `[effects.drag]`.

    Parameters
    ----------
    brackets : `[` for a table, or `[[` for an entry of an array of tables
    name : what stands in the brackets
    seen : index of the last table of each array, which is updated
    """
    if brackets == "[":
        return tuple(part.strip() for part in name.split("."))
    seen[name] = seen.get(name, -1) + 1
    return (name, seen[name])


def _open_quote(line: str, quote: str | None) -> str | None:
    """Return the delimiter of the multi-line string that is open at the end of a line, or None.

    `quote` is the delimiter of the string that is open at the line's start, or None.
    """
    for mark in re.findall(r'"""|\'\'\'', line):
        if quote is None:
            quote = mark
        elif quote == mark:
            quote = None
    return quote
