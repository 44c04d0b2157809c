"""Tables for HTML and Markdown: headings with units, cells of text, and links."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from urllib.parse import quote

from ..results.verdict_words import VERDICT, VerdictWord


def scene_page(name: str) -> str:
    """Return the path of a scene's page, relative to the report's folder."""
    return f"scenes/{quote(name)}.html"


def method_anchor(engine: str, method: str) -> str:
    """Return the anchor of a method's verdict on a scene's page."""
    return ":".join(("method", _plain(engine), _plain(method)))


def _plain(text: str) -> str:
    """Return ASCII letters, digits, - and _ as they are, other characters as code points."""
    return "".join(
        c if c.isascii() and (c.isalnum() or c in "-_") else f".{ord(c):x}." for c in text
    )


@dataclass(frozen=True)
class Cell:
    """One entry of a table.

    Attributes
    ----------
    kind : "number", a verdict, …: the CSS class by which the style sheet colours or aligns it
    detail : a second, smaller line
    link : target of the cell's link, relative to the page; HTML only
    note : text that the HTML page shows on demand
    """

    text: str
    kind: str = ""
    detail: str = ""
    link: str = ""
    note: str = ""


@dataclass(frozen=True)
class Table:
    """Headings, and rows of as many cells. `anchors`, one for each row, are targets of links."""

    headings: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    anchors: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Captioned:
    """A table with its title, and what it shows in words; a folded one is shown on demand."""

    label: str
    sentence: str
    table: Table
    folded: bool = False


def table(headings: Iterable[str], rows: Iterable[Iterable[Cell | str]]) -> Table:
    """Return a table; plain strings become plain cells."""
    return Table(
        tuple(headings),
        tuple(
            tuple(cell if isinstance(cell, Cell) else Cell(cell) for cell in row) for row in rows
        ),
    )


def records(rows: Iterable[Mapping[str, Cell | str]]) -> Table:
    """Return a table of records with their keys as headings; empty without records."""
    rows = list(rows)
    return table(rows[0] if rows else (), (row.values() for row in rows))


def figure(text: str) -> Cell:
    """Return a cell with a number."""
    return Cell(text, "number")


def named(pair: tuple[str, str]) -> dict[str, Cell]:
    """Return cells of the names of an engine and a method."""
    return {"engine": Cell(pair[0], "name"), "method": Cell(pair[1], "name")}


def verdict_cell(word: VerdictWord, detail: str = "", link: str = "") -> Cell:
    """Return a cell of a verdict's word with its sign, in its colour."""
    return Cell(f"{VERDICT[word].sign} {word}", word, detail, link)
