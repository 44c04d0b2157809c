"""Converts an HTML page of the report to Markdown: its text, tables and code.

Elements that only a browser can draw, such as figures, are left out.
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from html.parser import HTMLParser
from typing import Any

#: Attribute and tags of elements that only a browser can draw.
DRAWN = "data-drawn"
ALWAYS_DRAWN = ("head", "script", "figure", "template", "svg", "button", "select", "label")
#: Elements without an end tag.
VOID = ("meta", "link", "input", "br", "hr")
#: What a block begins with in Markdown, by its tag in HTML.
BLOCKS = {"nav": "", "p": "", "summary": ""}
BLOCKS |= {f"h{level}": f"{'#' * level} " for level in range(1, 5)}
AROUND = {"strong": "**", "em": "*"}
#: Pattern of white space, except spaces inside numbers.
_SPACES = re.compile(r"[^\S\xa0\u202f]+")
_SPECIAL = re.compile(r"([\\`*_{}\[\]|#~])")


def escaped(text: str) -> str:
    """Return plain text escaped for a line or a cell of Markdown."""
    one_line = _SPACES.sub(" ", text).strip()
    safe = one_line.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    return _SPECIAL.sub(r"\\\1", safe)


def code_block(text: str) -> str:
    """Return a text as a fenced code block, whose fence is longer than any backticks inside."""
    fence = "`" * max([3, *(len(run) + 1 for run in re.findall(r"`+", text))])
    end = "" if text.endswith("\n") else "\n"
    return f"{fence}\n{text}{end}{fence}"


def as_markdown(html: str, items: Sequence[Any]) -> str:
    """Return a page as Markdown.

    Parameters
    ----------
    html : the page
    items : the data that the page carries for its script (`PageData.items`), among them tables that
        the page shows on demand
    """
    parser = _Parser()
    parser.feed(html)
    parser.close()
    return "\n\n".join(block for block in _blocks(parser.open[0], items) if block.strip()) + "\n"


@dataclass
class _Element:
    """An element of a page: its tag and attributes, and the texts and elements inside it."""

    tag: str
    attributes: dict[str, str | None]
    inside: list["_Element | str"] = field(default_factory=list)

    @property
    def is_drawn(self) -> bool:
        """Whether only a browser can draw the element, so that it is left out of Markdown."""
        return self.tag in ALWAYS_DRAWN or DRAWN in self.attributes

    @property
    def elements(self) -> list["_Element"]:
        """The elements directly inside, except those that are left out of Markdown."""
        return [one for one in self.inside if isinstance(one, _Element) and not one.is_drawn]

    def all(self, *tags: str) -> Iterator["_Element"]:
        """Yield the elements inside that have one of the tags, in order.

        Elements inside such an element are left out.
        """
        for one in self.elements:
            if one.tag in tags:
                yield one
            else:
                yield from one.all(*tags)


class _Parser(HTMLParser):
    """Parses a page into elements.

    Attributes
    ----------
    open : the elements that have begun and not ended, the outermost first; the first is the page
    """

    def __init__(self) -> None:
        super().__init__(convert_charrefs=True)
        self.open = [_Element("", {})]

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Add a new element to the innermost open one; open it unless its tag is in `VOID`."""
        element = _Element(tag, dict(attrs))
        self.open[-1].inside.append(element)
        if tag not in VOID:
            self.open.append(element)

    def handle_endtag(self, tag: str) -> None:
        """Close the innermost open element if it has this tag."""
        if tag == self.open[-1].tag:
            self.open.pop()

    def handle_data(self, data: str) -> None:
        """Add a text to the innermost open element."""
        self.open[-1].inside.append(data)


def _blocks(element: _Element, items: Sequence[Any]) -> Iterator[str]:
    """Yield the blocks of Markdown for the elements inside an element, nested ones included.

    Parameters
    ----------
    items : the data that the page carries for its script, among them tables shown on demand
    """
    for one in element.elements:
        if one.tag in BLOCKS:
            if line := _line(one):
                yield BLOCKS[one.tag] + line
        elif one.tag == "ul":
            yield "\n".join(f"- {_line(entry)}" for entry in one.all("li"))
        elif one.tag == "dl":
            terms = zip(one.all("dt"), one.all("dd"), strict=True)
            yield "\n".join(f"- {_line(term)}: {_line(meaning)}" for term, meaning in terms)
        elif one.tag == "pre":
            yield code_block(_text(one))
        elif one.tag == "table":
            yield _table(one)
        elif number := one.attributes.get("data-table"):
            rows = [[_packed_cell(cell) for cell in row] for row in items[int(number)]["rows"]]
            yield _lines([[escaped(text) for text in items[int(number)]["headings"]], *rows])
        else:
            yield from _blocks(one, items)


def _line(element: _Element) -> str:
    """Return the contents of an element as one line of Markdown."""
    return _SPACES.sub(" ", _inline(element)).strip()


def _inline(element: _Element) -> str:
    """Return the contents of an element as Markdown, which may still have line breaks."""
    return "".join(_spaced(one) if isinstance(one, str) else _marked(one) for one in element.inside)


def _spaced(text: str) -> str:
    """Return a text escaped for Markdown, with white space at either end reduced to one space."""
    after = text[-1:].isspace() and not text.isspace()
    return f"{' ' * text[:1].isspace()}{escaped(text)}{' ' * after}"


def _marked(element: _Element) -> str:
    """Return an inline element as Markdown, with its link and emphasis."""
    inner, target = _inline(element), element.attributes.get("href") or ""
    if element.is_drawn or element.attributes.get("class") == "note":
        return ""
    if element.tag == "a" and not target.startswith("#"):
        return f"[{inner}]({_target(target)})"
    if element.attributes.get("class") == "detail":
        return f" ({inner})"
    if element.tag == "code":
        return f"`{text}`" if "`" not in (text := _text(element)) else inner
    return f"{AROUND.get(element.tag, '')}{inner}{AROUND.get(element.tag, '')}"


def _target(link: str) -> str:
    """Return the address of the Markdown page that corresponds to the HTML page of a link."""
    page = link.partition("#")[0].replace("index.html", "report.md")
    return page.removesuffix(".html") + ".md" if page.endswith(".html") else page


def _text(element: _Element) -> str:
    """Return all text inside an element, as it is."""
    return "".join(one if isinstance(one, str) else _text(one) for one in element.inside)


def _table(element: _Element) -> str:
    """Return a table in Markdown; its first row has the headings."""
    heads, bodies = element.all("thead"), element.all("tbody")
    return _lines([_cells(row) for part in (*heads, *bodies) for row in part.all("tr")])


def _cells(row: _Element) -> list[str]:
    """Return the cells of a row of a table, as Markdown."""
    return [_line(one) for one in row.all("td", "th")]


def _packed_cell(cell: list[str]) -> str:
    """Return, as Markdown, a cell of a table that a page carries for its script.

    Parameters
    ----------
    cell : text, kind, detail, link and note of the cell, without empty ones at the end
    """
    text, _, detail, link = [*cell, "", "", ""][:4]
    shown = f"[{escaped(text)}]({_target(link)})" if link else escaped(text)
    return f"{shown} ({escaped(detail)})" if detail else shown


def _lines(rows: list[list[str]]) -> str:
    """Return rows of cells as a table in Markdown; the first row has the headings."""
    headings, *others = (f"| {' | '.join(row)} |" for row in rows)
    return "\n".join([headings, f"|{' --- |' * len(rows[0])}", *others])
