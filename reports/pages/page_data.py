"""Data for a page's script: figures, motions and folded tables, compressed in one element.

An array is carried as whole multiples of a step, of which differences of some order are taken: for
a smooth line these are small numbers, each of which takes deflate about a byte.
"""

import base64
import json
import zlib
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...scenarios import FloatArray
from .tables import Table

#: Highest order of differences: the rounding to a step grows by a factor of two with each order.
HIGHEST_ORDER = 6
#: Largest multiple of the step: nothing larger is drawn, and sums of differences stay exact in a
#: double.
LARGEST = 1 << 40


@dataclass(frozen=True, eq=False)
class Differences:
    """An array, rounded to whole multiples of a step.

    Attributes
    ----------
    step : in the unit of the values
    order : how many times differences were taken; each time the first number is kept as it is
    values : whole numbers, (n,)
    gaps : indices of NaN
    """

    step: float
    order: int
    values: NDArray[np.int64]
    gaps: tuple[int, ...]

    def planes(self) -> bytes:
        """Return zigzag-coded bytes (2v, or −2v − 1 if v < 0): lowest bytes, then the next, …."""
        zigzag = np.where(self.values < 0, -2 * self.values - 1, 2 * self.values)
        by_value = zigzag.astype("<u8").view(np.uint8).reshape(-1, 8)
        used = np.flatnonzero(by_value.max(axis=0, initial=0))
        width = int(used[-1]) + 1 if len(used) else 0
        return by_value[:, :width].T.tobytes()


def differenced(values: FloatArray, step: float) -> Differences:
    """Return values, (n,), rounded to multiples of a step > 0; NaN becomes a gap."""
    gaps = tuple(np.flatnonzero(np.isnan(values)).tolist())
    drawable = np.clip(np.where(np.isnan(values), 0.0, values), -LARGEST * step, LARGEST * step)
    multiples = np.rint(drawable / step)
    differences = [multiples]
    for _ in range(HIGHEST_ORDER):
        differences.append(np.diff(differences[-1], prepend=0.0))
    order = min(range(len(differences)), key=lambda k: float(np.abs(differences[k]).sum()))
    return Differences(step, order, differences[order].astype(np.int64), gaps)


class PageData:
    """The data of one page for its script: items, by number."""

    def __init__(self) -> None:
        self.items: list[Any] = []

    def add(self, item: Any) -> int:
        """Add an item that JSON can hold, with arrays as `Differences`; return its number."""
        self.items.append(item)
        return len(self.items) - 1

    def add_table(self, table: Table) -> int:
        """Add a table, its cells without trailing empty parts; return its number."""
        rows = [
            [_trimmed([c.text, c.kind, c.detail, c.link, c.note]) for c in row]
            for row in table.rows
        ]
        return self.add({"headings": table.headings, "rows": rows})

    def encoded(self) -> str:
        """Return all items as JSON, a NUL and arrays, deflated (zlib, RFC 1950), base64."""
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
            self.items, ensure_ascii=False, allow_nan=False, separators=(",", ":"), default=placed
        )
        packed = zlib.compress(text.encode("utf-8") + b"\0" + arrays, 9)
        return base64.b64encode(packed).decode("ascii")


def _trimmed(texts: list[str]) -> list[str]:
    while len(texts) > 1 and not texts[-1]:
        texts.pop()
    return texts
