"""Numbers as every engine reads them alike; anything else is refused.

PyBullet reads `0,5` as 0, some take `1_0` for 10, both engines load a mass of `nan`.
"""

import math
import re
from collections.abc import Sequence

from .xml_tree import Element, shown

#: A decimal number. No hexadecimal, no `inf`, no `nan`, no digit grouping.
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)


def number(element: Element, key: str) -> float:
    """One finite number, which must be there."""
    return vector(element, key, 1)[0]


def vector(
    element: Element, key: str, length: int, default: Sequence[float] | None = None
) -> tuple[float, ...]:
    """A vector of so many finite numbers.

    Parameters
    ----------
    default : what is meant where the attribute is not there; None where it must be

    Raises
    ------
    ModelFileError
        If the attribute is not there, or is anything but so many decimal numbers.
    """
    text = element.attributes.get(key)
    if text is None:
        if default is None:
            element.refuse(f"<{element.tag}> lacks '{key}'")
        return tuple(default)
    return numbers(element, key, text, length)


def numbers(element: Element, key: str, text: str, length: int) -> tuple[float, ...]:
    """The numbers of an attribute's text."""
    parts = text.split()
    for part in parts:
        if not _NUMBER.fullmatch(part) or not math.isfinite(float(part)):
            element.refuse(
                f"'{key}' of <{element.tag}> must be decimal numbers, got {shown(part)}{_why(part)}"
            )
    if len(parts) != length:
        count = "one number" if length == 1 else f"{length} numbers"
        element.refuse(f"'{key}' of <{element.tag}> must be {count}, got {shown(text)}")
    return tuple(map(float, parts))


def _why(part: str) -> str:
    if "$" in part:
        return ": it is xacro, expand the file first"
    if "," in part:
        return ": engines stop reading at the comma"
    return ": engines do not read it alike"
