"""Writes numbers and XML into model files; every double reads back bit for bit."""

import xml.etree.ElementTree as ET
from collections.abc import Iterable


def decimals(values: Iterable[float]) -> str:
    """Doubles, separated by spaces, each in the fewest digits that read back exactly (≤ 17)."""
    return " ".join(repr(float(value)) for value in values)


def xml_text(root: ET.Element) -> str:
    """Return an XML element as an indented document."""
    ET.indent(root)
    return ET.tostring(root, encoding="unicode") + "\n"


def python_text(name: str, text: str) -> str:
    """Return Python that gives a text a name, line by line, whatever characters it holds."""
    lines = "\n".join(f"    {line!r}" for line in text.splitlines(keepends=True))
    return f"{name} = (\n{lines}\n)"
