"""What is raised about a scenario file that cannot be used; how foreign text is quoted in it."""

import unicodedata
from collections.abc import Iterable
from difflib import get_close_matches


class ScenarioError(ValueError):
    """A scenario file is wrong; the message names file, line, table, key, value and rule."""


class Misfit(ValueError):
    """A value that does not go with others, or that no scene can have.

    Attributes
    ----------
    keys : lead from where this was found to the key that is to blame
    """

    def __init__(self, message: str, *keys: int | str) -> None:
        super().__init__(message)
        self.keys = keys


def did_you_mean(name: str, names: Iterable[str]) -> str:
    """The hint "; did you mean '…'?" with the nearest of `names`; empty if none is near."""
    near = get_close_matches(name, list(names), n=1)
    return f"; did you mean '{near[0]}'?" if near else ""


def is_control(character: str) -> bool:
    """Whether a character ends a line, commands the terminal, turns text about or is not seen."""
    return unicodedata.category(character) in ("Cc", "Cf", "Cs", "Zl", "Zp")


def printable(text: str, limit: int | None = None) -> str:
    """Text of foreign origin on one line: control characters as escapes, cut off at a limit."""
    if limit is not None and len(text) > limit:
        text = f"{text[:limit]}…"
    if text.isprintable():
        return text
    return "".join(c.encode("unicode_escape").decode("ascii") if is_control(c) else c for c in text)
