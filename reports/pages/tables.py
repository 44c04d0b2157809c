"""Tables that HTML and Markdown share: headings with units, and cells of text."""

from collections.abc import Iterable
from dataclasses import dataclass

from ..results.verdict_words import VERDICT, VerdictWord


@dataclass(frozen=True)
class Cell:
    """One entry of a table.

    Attributes
    ----------
    kind : "number", a verdict, …: the class by which the style sheet colours or aligns it
    detail : a second, smaller line
    link : its target, relative to the page; HTML only
    note : text that the HTML page shows on demand
    """

    text: str
    kind: str = ""
    detail: str = ""
    link: str = ""
    note: str = ""


@dataclass(frozen=True)
class Table:
    """Headings, and rows of as many cells. `anchors`, one a row, are what links lead to."""

    headings: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    anchors: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Captioned:
    """A table, what it is of, and in a sentence what it shows."""

    label: str
    sentence: str
    table: Table


def table(headings: Iterable[str], rows: Iterable[Iterable[Cell | str]]) -> Table:
    """A table; plain strings become plain cells."""
    return Table(
        tuple(headings),
        tuple(
            tuple(cell if isinstance(cell, Cell) else Cell(cell) for cell in row) for row in rows
        ),
    )


def figure(text: str) -> Cell:
    """A cell with a number."""
    return Cell(text, "number")


def verdict_cell(word: VerdictWord, detail: str = "", link: str = "") -> Cell:
    """A verdict's word with its sign, in its colour."""
    return Cell(f"{VERDICT[word].sign} {word}", word, detail, link)
