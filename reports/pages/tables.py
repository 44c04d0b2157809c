"""Tables that HTML and Markdown share: headings with units, cells of text, and links."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from urllib.parse import quote

from ..results.verdict_words import VERDICT, VerdictWord


def scene_page(name: str) -> str:
    """A scene's page, relative to the report's folder."""
    return f"scenes/{quote(name)}.html"


def method_anchor(engine: str, method: str) -> str:
    """The anchor of a method's verdict on a scene's page."""
    return ":".join(("method", _plain(engine), _plain(method)))


def _plain(text: str) -> str:
    """ASCII letters, digits, - and _ unchanged; other characters as their code points."""
    return "".join(
        c if c.isascii() and (c.isalnum() or c in "-_") else f".{ord(c):x}." for c in text
    )


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
    """A table, what it is of, and in words what it shows; a folded one is shown on demand."""

    label: str
    sentence: str
    table: Table
    folded: bool = False


def table(headings: Iterable[str], rows: Iterable[Iterable[Cell | str]]) -> Table:
    """A table; plain strings become plain cells."""
    return Table(
        tuple(headings),
        tuple(
            tuple(cell if isinstance(cell, Cell) else Cell(cell) for cell in row) for row in rows
        ),
    )


def records(rows: Iterable[Mapping[str, Cell | str]]) -> Table:
    """A table of records with their keys as headings; without any where there are none."""
    rows = list(rows)
    return table(rows[0] if rows else (), (row.values() for row in rows))


def figure(text: str) -> Cell:
    """A cell with a number."""
    return Cell(text, "number")


def named(pair: tuple[str, str]) -> dict[str, Cell]:
    """Cells of an engine and a method."""
    return {"engine": Cell(pair[0], "name"), "method": Cell(pair[1], "name")}


def verdict_cell(word: VerdictWord, detail: str = "", link: str = "") -> Cell:
    """A verdict's word with its sign, in its colour."""
    return Cell(f"{VERDICT[word].sign} {word}", word, detail, link)
