"""Data for a page's script: figures, motions and folded tables, compressed in one element."""

import base64
import json
import zlib
from typing import Any

from .scene.differences import Differences
from .tables import Table


class PageData:
    """The items of one page, by number."""

    def __init__(self) -> None:
        self._items: list[Any] = []

    def add(self, item: Any) -> int:
        """Take an item that JSON can hold, with arrays as `Differences`; returns its number."""
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
        """All of it as JSON, a NUL and bytes of arrays: deflated (zlib, RFC 1950), in base64."""
        arrays = bytearray()

        def placed(array: Differences) -> dict[str, Any]:
            place = {"at": len(arrays), "length": len(array.values)}
            arrays.extend(planes := array.planes())
            return place | {
                "width": len(planes) // max(len(array.values), 1),
                "step": array.step,
                "order": array.order,
                "gaps": array.gaps,
            }

        text = json.dumps(
            self._items, ensure_ascii=False, allow_nan=False, separators=(",", ":"), default=placed
        )
        packed = zlib.compress(text.encode("utf-8") + b"\0" + arrays, 9)
        return base64.b64encode(packed).decode("ascii")


def _trimmed(texts: list[str]) -> list[str]:
    while len(texts) > 1 and not texts[-1]:
        texts.pop()
    return texts
