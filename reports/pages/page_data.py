"""Data for a page's script: figures, motions and folded tables, compressed in one element.

An array is rounded to whole multiples of a step, and differences of neighbours are taken one or
several times. For a smooth line these are small numbers, and deflate stores each in about a byte.
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

#: Highest order of differences. With each order, the noise by rounding to a step doubles.
HIGHEST_ORDER = 6
#: Largest multiple of the step that is carried. Larger values, none of which is drawn, are replaced
#: by it. Sums of differences up to this size are exact in a double.
LARGEST = 1 << 40


@dataclass(frozen=True, eq=False)
class Differences:
    """An array that is rounded to whole multiples of a step and stored as differences.

    Attributes
    ----------
    step : size of the step, in the unit of the array
    order : how many times differences of neighbours were taken; each time the first number is kept
    values : the differences, in steps, whole numbers, (n,)
    gaps : indices at which the array is NaN
    """

    step: float
    order: int
    values: NDArray[np.int64]
    gaps: tuple[int, ...]

    def planes(self) -> bytes:
        """Return the values as bytes: the lowest byte of each, then the next of each, and so on.

        The values are zigzag-coded first: 2v, or −2v − 1 if v < 0.
        """
        zigzag = np.where(self.values < 0, -2 * self.values - 1, 2 * self.values)
        by_value = zigzag.astype("<u8").view(np.uint8).reshape(-1, 8)
        used = np.flatnonzero(by_value.max(axis=0, initial=0))
        width = int(used[-1]) + 1 if len(used) else 0
        return by_value[:, :width].T.tobytes()


def differenced(values: FloatArray, step: float) -> Differences:
    """Return values, (n,), rounded to multiples of a step, as differences of some order.

    The order is chosen for which the absolute values of the differences have the least sum.

    Parameters
    ----------
    step : size of the step, above 0, in the unit of the values
    """
    gaps = tuple(np.flatnonzero(np.isnan(values)).tolist())
    drawable = np.clip(np.where(np.isnan(values), 0.0, values), -LARGEST * step, LARGEST * step)
    multiples = np.rint(drawable / step)
    differences = [multiples]
    for _ in range(HIGHEST_ORDER):
        differences.append(np.diff(differences[-1], prepend=0.0))
    order = min(range(len(differences)), key=lambda k: float(np.abs(differences[k]).sum()))
    return Differences(step, order, differences[order].astype(np.int64), gaps)


class PageData:
    """The data that a page carries for its script: items, each identified by its number.

    Attributes
    ----------
    items : the items; the number of an item is its index
    """

    def __init__(self) -> None:
        self.items: list[Any] = []

    def add(self, item: Any) -> int:
        """Add an item and return its number.

        Parameters
        ----------
        item : a value that JSON can hold; arrays in it must be `Differences`
        """
        self.items.append(item)
        return len(self.items) - 1

    def add_table(self, table: Table) -> int:
        """Add a table and return its number; empty texts at the end of a cell are dropped."""
        rows = [
            [_trimmed([c.text, c.kind, c.detail, c.link, c.note]) for c in row]
            for row in table.rows
        ]
        return self.add({"headings": table.headings, "rows": rows})

    def encoded(self) -> str:
        """Return all items as a text for the page.

        It is the base64 form of a zlib stream (RFC 1950) of JSON, a NUL byte and the arrays.
        """
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
    """Remove empty texts at the end of a list, in place, and return it; its first text is kept."""
    while len(texts) > 1 and not texts[-1]:
        texts.pop()
    return texts
