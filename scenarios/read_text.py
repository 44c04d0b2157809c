"""Reads the text of a scenario file: only of a regular file, up to one size, in UTF-8."""

import re
from pathlib import Path

from .errors import ScenarioError, printable
from .regular_files import read_regular

#: Largest size of a file, bytes. No scenario is this long; a larger file is given by mistake.
MAX_BYTES = 1 << 16
#: Number of bytes in which the first key is looked for: only comments come before it.
HEAD = 1 << 14
#: Largest number of parts of a key such as a.b.c…: the time that the parser takes grows as the
#: square of their number.
MAX_NESTING = 64
#: Pattern of one part of a key, and of too many parts in a row.
_PART = r"""(?:[\w-]++|"(?:[^"\\\n]|\\.)*+"|'[^'\n]*+')"""
_TOO_DEEP = re.compile(rf"(?<![\w\\-])(?:{_PART}[ \t]*+\.[ \t]*+){{{MAX_NESTING}}}")


def read_text(path: Path) -> str:
    """Return the text of a scenario file, without a byte-order mark.

    Raises
    ------
    ScenarioError
        If the file cannot be read, is not a regular file, is too large, or is not UTF-8.
    """
    where = printable(str(path))
    try:
        content = read_regular(path, MAX_BYTES)
    except OSError as error:
        raise ScenarioError(f"{where}: cannot be read: {error.strerror}") from None
    if len(content) > MAX_BYTES:
        raise ScenarioError(f"{where}: too large for a scenario, the limit is {MAX_BYTES} bytes")
    try:
        return content.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError:
        raise ScenarioError(f"{where}: not a text file in UTF-8") from None


def first_key(path: Path) -> str:
    """Return the first key of a TOML file, read from its first lines; empty without one.

    It is also empty if the file cannot be read.
    """
    try:
        head = read_regular(path, HEAD)
    except OSError:
        return ""
    for line in head.decode("utf-8-sig", errors="replace").split("\n"):
        stripped = line.strip()
        if stripped and not stripped.startswith("#"):
            return stripped.split("=")[0].strip()
    return ""


def is_nested_too_deeply(text: str) -> bool:
    """Whether a TOML text has a key with more than `MAX_NESTING` parts, a.b.c…."""
    return _TOO_DEEP.search(text) is not None
