"""Tables for pages in HTML and Markdown, and the addresses of pages that their links point to."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from urllib.parse import quote

from ..results.verdict_words import VERDICT, VerdictWord


def scene_page(name: str) -> str:
    """Return the URL of a scene's page, relative to the report's folder, percent-encoded."""
    return f"scenes/{quote(name)}.html"


def method_anchor(engine: str, method: str) -> str:
    """Return the anchor of a method's verdict on a scene's page, for links to it."""
    return ":".join(("method", _plain(engine), _plain(method)))


def _plain(text: str) -> str:
    """Return a text for an anchor: all but ASCII letters, digits, - and _ become code points."""
    return "".join(
        c if c.isascii() and (c.isalnum() or c in "-_") else f".{ord(c):x}." for c in text
    )


@dataclass(frozen=True)
class Cell:
    """One entry of a table.

    Attributes
    ----------
    text : the text that is shown
    kind : CSS class by which the style sheet colours or aligns the cell, such as "number", "name"
        or the word of a verdict
    detail : a second, smaller line; in Markdown it follows in brackets
    link : target of the cell's link, relative to the page; empty for no link
    note : text that the HTML page shows on demand, and that Markdown lacks
    """

    text: str
    kind: str = ""
    detail: str = ""
    link: str = ""
    note: str = ""


@dataclass(frozen=True)
class Table:
    """A table: headings, and rows with a cell for each heading.

    Attributes
    ----------
    headings : headings of the columns
    rows : the cells of each row
    anchors : targets of links, one for each row; empty if rows have none
    """

    headings: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    anchors: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Captioned:
    """A table with its title and a sentence on what it shows.

    Attributes
    ----------
    label : the title
    sentence : what the table shows
    table : the table
    folded : whether the page shows the table only on demand
    """

    label: str
    sentence: str
    table: Table
    folded: bool = False


def table(headings: Iterable[str], rows: Iterable[Iterable[Cell | str]]) -> Table:
    """Return a table of headings and rows; strings in rows become cells without kind or link."""
    return Table(
        tuple(headings),
        tuple(
            tuple(cell if isinstance(cell, Cell) else Cell(cell) for cell in row) for row in rows
        ),
    )


def records(rows: Iterable[Mapping[str, Cell | str]]) -> Table:
    """Return a table of records, whose keys become the headings; it is empty without records."""
    rows = list(rows)
    return table(rows[0] if rows else (), (row.values() for row in rows))


def figure(text: str) -> Cell:
    """Return a cell that shows a number, given as text."""
    return Cell(text, "number")


def named(pair: tuple[str, str]) -> dict[str, Cell]:
    """Return cells with the names of an engine and a method, by the headings of their columns."""
    return {"engine": Cell(pair[0], "name"), "method": Cell(pair[1], "name")}


def verdict_cell(word: VerdictWord, detail: str = "", link: str = "") -> Cell:
    """Return a cell that shows a verdict's word with its sign, in the verdict's colour.

    `detail` is a smaller second line, and `link` the target of the cell's link, if not empty.
    """
    return Cell(f"{VERDICT[word].sign} {word}", word, detail, link)
