"""Reads a page of the report as a browser would, and complains where one would have to guess."""

import base64
import json
import re
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
from spincheck.scenarios import FloatArray

#: Elements without an end tag.
VOID = {"meta", "link", "br", "hr", "img", "input"}


@dataclass
class Element:
    """A tag with its attributes, the text inside it, and the elements it is in."""

    tag: str
    attributes: dict[str, str]
    within: tuple[str, ...]
    text: str = ""


@dataclass
class Page:
    """Every element of a page in order, and what is wrong with it."""

    path: Path
    elements: list[Element] = field(default_factory=list)
    faults: list[str] = field(default_factory=list)

    def all(self, tag: str) -> list[Element]:
        """The elements of that tag."""
        return [element for element in self.elements if element.tag == tag]

    def attribute(self, name: str) -> list[str]:
        """Every value of an attribute."""
        return [e.attributes[name] for e in self.elements if name in e.attributes]

    @cached_property
    def packed(self) -> list[Any]:
        """The items of the page's compressed element; none without one."""
        scripts = [e for e in self.all("script") if e.attributes.get("id") == "packed"]
        if not scripts:
            return []
        items: list[Any] = json.loads(self._data[: self._data.index(0)])
        return items

    @cached_property
    def _data(self) -> bytes:
        """JSON, a NUL, and arrays."""
        (packed,) = (e for e in self.all("script") if e.attributes.get("id") == "packed")
        return zlib.decompress(base64.b64decode(packed.text))

    def restored(self, place: dict[str, Any]) -> FloatArray:
        """An array, as the page's script restores it."""
        at = self._data.index(0) + 1 + place["at"]
        length, width = place["length"], place["width"]
        planes = np.frombuffer(self._data[at : at + length * width], dtype=np.uint8)
        zigzag = 256 ** np.arange(width) @ planes.reshape(width, length).astype(np.int64)
        values = np.where(zigzag % 2, -(zigzag + 1) // 2, zigzag // 2).astype(float)
        for _ in range(place["order"]):
            values = np.cumsum(values)
        values *= place["step"]
        values[place["gaps"]] = np.nan
        return np.asarray(values)

    @property
    def motions(self) -> dict[str, Any]:
        """What the page's player plays."""
        (script,) = (e for e in self.all("script") if "data-motions" in e.attributes)
        motions: dict[str, Any] = self.packed[int(script.attributes["data-motions"])]
        return motions

    def tables(self) -> list[list[list[str]]]:
        """The texts of every table's cells, row by row; those that the script makes included."""
        tables: list[list[list[str]]] = []
        for element in self.elements:
            if "data-table" in element.attributes:
                item = self.packed[int(element.attributes["data-table"])]
                rows = [["".join([c[0], *c[2:3], *c[4:5]]) for c in row] for row in item["rows"]]
                tables.append([item["headings"], *rows])
            if element.tag == "table":
                tables.append([])
            elif element.tag == "tr":
                tables[-1].append([])
            elif element.tag in ("td", "th"):
                tables[-1][-1].append(element.text)
        return tables


def read_page(path: Path) -> Page:
    """Parse a page."""
    parser = _Parser(Page(path))
    parser.feed(path.read_text(encoding="utf-8"))
    parser.close()
    parser.page.faults += [f"<{element.tag}> is never closed" for element in parser.open]
    return parser.page


def unsound(folder: Path) -> dict[str, list[str]]:
    """What is wrong with a report's pages, by page: markup, ids, links that lead nowhere or out."""
    pages = {path.resolve(): read_page(path) for path in folder.rglob("*.html")}
    found = {path.name: [*page.faults, *_wrong_links(page, pages)] for path, page in pages.items()}
    return {name: faults for name, faults in found.items() if faults}


def _wrong_links(page: Page, pages: dict[Path, Page]) -> Iterator[str]:
    ids = page.attribute("id")
    yield from (f"id {one} twice" for one in {one for one in ids if ids.count(one) > 1})
    for target in page.attribute("href") + page.attribute("src"):
        file, _, place = target.partition("#")
        path = (page.path.parent / unquote(file)).resolve() if file else page.path.resolve()
        if re.match(r"[a-z]+:|//", target) or not path.is_file():
            yield f"leads nowhere in the report: {target}"
        elif place and path in pages and place not in pages[path].attribute("id"):
            yield f"no such place: {target}"


class _Parser(HTMLParser):
    def __init__(self, page: Page) -> None:
        super().__init__(convert_charrefs=True)
        self.page = page
        self.open: list[Element] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        names = [name for name, _ in attrs]
        if len(set(names)) < len(names):
            self.page.faults.append(f"<{tag}> has an attribute twice")
        element = Element(
            tag, {name: value or "" for name, value in attrs}, tuple(e.tag for e in self.open)
        )
        self.page.elements.append(element)
        if tag not in VOID:
            self.open.append(element)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag: str) -> None:
        if not self.open or self.open[-1].tag != tag:
            self.page.faults.append(f"</{tag}> closes nothing")
            return
        self.open.pop()

    def handle_data(self, data: str) -> None:
        for element in self.open:
            element.text += data
