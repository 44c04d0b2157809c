"""Writes the page of all commands, from what `--help` of each says."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import typer
from sphinx.application import Sphinx
from spincheck.reports.cli.app import app as commands
from spincheck.reports.cli.grouped import GROUPS

PAGE = Path("reference/commands.md")
HEAD = """# Commands

Every command takes `--help`, which prints what stands here. Exit codes: 0, all is well;
1, something disagrees, failed or got worse; 2, bad input; 3, nothing could be run.
"""


class Recorder:
    """Takes the place of the formatter that `--help` writes to, and keeps lists by section."""

    def __init__(self) -> None:
        self.sections: dict[str, list[tuple[str, str]]] = {}
        self.usage = ""
        self._heading = ""

    @contextmanager
    def section(self, heading: str) -> Iterator[None]:
        """Begin a section."""
        self._heading = heading
        yield

    def write_dl(self, rows: list[tuple[str, str]], *_: Any, **__: Any) -> None:
        """Keep a list of names and what they mean."""
        self.sections[self._heading] = rows

    def write_usage(self, program: str, arguments: str = "", *_: Any) -> None:
        """Keep how the command is called."""
        self.usage = f"{program} {arguments}"


def page() -> str:
    """Return the page, as MyST Markdown."""
    group = typer.main.get_command(commands)
    parent = group.make_context("spincheck", [], resilient_parsing=True)
    sections = [HEAD]
    others = sorted(
        set(group.list_commands(parent)) - {n for names in GROUPS.values() for n in names}
    )
    for heading, names in (GROUPS | ({"Others": others} if others else {})).items():
        sections.append(f"## {heading}\n")
        sections += [section(name, group.get_command(parent, name), parent) for name in names]
    return "\n".join(sections)


def section(name: str, command: Any, parent: Any) -> str:
    """Return the part of one command."""
    context = command.make_context(name, [], parent=parent, resilient_parsing=True)
    recorder = Recorder()
    command.format_usage(context, recorder)
    command.format_options(context, recorder)
    described = re.sub(r"^Example:.*$", "", command.help or "", flags=re.MULTILINE)
    paragraphs = [described, f"```text\n{recorder.usage}\n```"]
    for heading, rows in recorder.sections.items():
        rows = [row for row in rows if row[0] != "--help"]
        if rows:
            lines = [f"| `{cell(name)}` | {cell(words)} |" for name, words in rows]
            paragraphs.append("\n".join([f"| {heading.lower()} | |", "|---|---|", *lines]))
    if command.epilog:
        example = command.epilog.removeprefix("Example:").strip()
        paragraphs.append(f"```sh\n{example}\n```")
    return f"### spincheck {name}\n\n" + "\n\n".join(paragraphs) + "\n"


def cell(text: str) -> str:
    """Return a text as a table's cell holds it."""
    return text.replace("|", "\\|").replace("\n", " ")


def write(app: Sphinx) -> None:
    """Write the page where it has changed."""
    path, text = Path(app.srcdir) / PAGE, page()
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")


def setup(app: Sphinx) -> dict[str, bool]:
    """Have the page written before pages are read."""
    app.connect("builder-inited", write)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
