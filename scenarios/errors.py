"""Errors about a scenario file that cannot be used, and how foreign text is quoted in messages."""

import unicodedata
from collections.abc import Iterable
from difflib import get_close_matches


class ScenarioError(ValueError):
    """A scenario file is wrong; the message names file, line, table, key, value and rule."""


class Misfit(ValueError):
    """A value in a scene file that does not go with others, or that no scene can have.

    Parameters
    ----------
    message : the rule that the value breaks
    keys : the path of keys to the wrong value, from the table whose check raises the error
    """

    def __init__(self, message: str, *keys: int | str) -> None:
        super().__init__(message)
        self.keys = keys


def did_you_mean(name: str, names: Iterable[str]) -> str:
    """Return the hint "; did you mean '…'?" with the nearest of `names`; empty if none is near."""
    near = get_close_matches(name, list(names), n=1)
    return f"; did you mean '{near[0]}'?" if near else ""


def is_control(character: str) -> bool:
    """Whether a character ends a line, controls the terminal, reverses text or is invisible."""
    return unicodedata.category(character) in ("Cc", "Cf", "Cs", "Zl", "Zp")


def printable(text: str, limit: int | None = None) -> str:
    """Return text from outside the program on one line, safe for a terminal.

    Control characters become escapes. What exceeds `limit` characters is cut off, unless `limit` is
    None.
    """
    if limit is not None and len(text) > limit:
        text = f"{text[:limit]}…"
    if text.isprintable():
        return text
    return "".join(c.encode("unicode_escape").decode("ascii") if is_control(c) else c for c in text)
