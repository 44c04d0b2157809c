"""A scenario file as text: read from regular files alone, in one size, in one encoding."""

import re
from pathlib import Path

from .errors import ScenarioError, printable
from .regular_files import read_regular

#: No scenario is this long; a larger file is something else, given by mistake.
MAX_BYTES = 1 << 16
#: Bytes, within which the first key stands, after comments at most.
HEAD = 1 << 14
#: A key such as a.b.c… of so many parts: the parser takes the square of their number in time.
MAX_NESTING = 64
#: One part of a key, and how many of them in a row are too many.
_PART = r"""(?:[\w-]++|"(?:[^"\\\n]|\\.)*+"|'[^'\n]*+')"""
_TOO_DEEP = re.compile(rf"(?<![\w\\-])(?:{_PART}[ \t]*+\.[ \t]*+){{{MAX_NESTING}}}")


def read_text(path: Path) -> str:
    """The text of a file, without the mark that some editors begin it with.

    Raises
    ------
    ScenarioError
        If it cannot be read, is no regular file, is too large, or is not UTF-8.
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
    """The first key of a TOML file, from its first lines alone; empty where there is none."""
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
    """Whether a key has more parts than any scenario's, so that parsing would take long."""
    return _TOO_DEEP.search(text) is not None
