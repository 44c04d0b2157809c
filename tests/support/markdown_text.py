"""Reads the report's Markdown: its tables, and its text without code and escapes."""

import re
from pathlib import Path


def outside_code(path: Path) -> str:
    markdown = path.read_text(encoding="utf-8")
    return re.sub(r"^(```+).*?^\1$", "", markdown, flags=re.MULTILINE | re.DOTALL)


def markdown_tables(path: Path) -> list[list[list[str]]]:
    """The cells of every table, row by row, the headings and the dashes among them."""
    tables = re.findall(r"(?:^\|.*\|\n)+", outside_code(path), re.MULTILINE)
    return [_cells(table) for table in tables]


def _cells(table: str) -> list[list[str]]:
    return [re.split(r"(?<!\\)\|", line)[1:-1] for line in table.strip().splitlines()]


def plain(markdown: str) -> str:
    """Without what escaping adds."""
    text = (
        markdown.replace("\\", "").replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&")
    )
    return re.sub(r"\s*\|\s*", "|", text).strip()
