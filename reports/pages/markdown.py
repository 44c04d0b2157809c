"""Converts users' Markdown safely to HTML, and escapes text in Markdown."""

import re

from markdown_it import MarkdownIt

#: Raw HTML is shown as text; images and links are shown as written, so that a report loads nothing.
_READER = (
    MarkdownIt("commonmark", {"html": False})
    .enable("table")
    .disable(["image", "link", "autolink", "html_inline", "html_block", "reference"])
)
_SPECIAL = re.compile(r"([\\`*_{}\[\]|#~])")


def to_html(text: str) -> str:
    """Markdown as HTML, without any HTML of the writer's."""
    return str(_READER.render(text))


def escaped(text: str) -> str:
    """Plain text escaped for a line or a cell of Markdown."""
    one_line = " ".join(text.split())
    safe = one_line.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    return _SPECIAL.sub(r"\\\1", safe)


def code_block(text: str, language: str) -> str:
    """A fenced block; the fence is longer than any run of backticks inside."""
    longest = max((len(run) for run in re.findall(r"`+", text)), default=0)
    fence = "`" * max(3, longest + 1)
    end = "" if text.endswith("\n") else "\n"
    return f"{fence}{language}\n{text}{end}{fence}"
