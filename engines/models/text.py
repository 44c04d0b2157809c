"""Writes numbers and XML into model files; every double reads back bit for bit."""

import xml.etree.ElementTree as ET
from collections.abc import Iterable


def decimals(values: Iterable[float]) -> str:
    """Return numbers as text, separated by spaces; each has the fewest digits that are exact."""
    return " ".join(repr(float(value)) for value in values)


def xml_text(root: ET.Element) -> str:
    """Return an XML element as an indented document."""
    ET.indent(root)
    return ET.tostring(root, encoding="unicode") + "\n"


def python_text(name: str, text: str) -> str:
    """Return Python code that assigns a text to a name, with one literal for each line."""
    lines = "\n".join(f"    {line!r}" for line in text.splitlines(keepends=True))
    return f"{name} = (\n{lines}\n)"
