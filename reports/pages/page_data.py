"""What a page's script reads: figures, motions and folded tables, compressed into one element."""

import base64
import json
import zlib
from typing import Any

from .tables import Table


class PageData:
    """The items of one page, by number."""

    def __init__(self) -> None:
        self._items: list[Any] = []

    def add(self, item: Any) -> int:
        """Take an item that JSON can hold; returns its number."""
        self._items.append(item)
        return len(self._items) - 1

    def add_table(self, table: Table) -> int:
        """Take a table, its cells as text, kind, detail, link and note without what is empty."""
        rows = [
            [_trimmed([c.text, c.kind, c.detail, c.link, c.note]) for c in row]
            for row in table.rows
        ]
        return self.add({"headings": table.headings, "rows": rows})

    def encoded(self) -> str:
        """All of it as JSON, deflated (zlib, RFC 1950), in base64."""
        text = json.dumps(self._items, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
        return base64.b64encode(zlib.compress(text.encode("utf-8"), 9)).decode("ascii")


def _trimmed(texts: list[str]) -> list[str]:
    while len(texts) > 1 and not texts[-1]:
        texts.pop()
    return texts
