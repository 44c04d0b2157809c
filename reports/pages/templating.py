"""Templates of pages, and how pages and their style sheets are written."""

from functools import cache
from importlib.resources import files
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined, select_autoescape
from markupsafe import Markup

from ..results.database import shown
from .cost_section import LEGEND
from .links import scene_page
from .markdown import code_block, escaped, to_html

TEMPLATES = Path(str(files(__package__))) / "templates"


@cache
def templates() -> Environment:
    """The template environment; values in HTML are escaped."""
    environment = Environment(
        loader=FileSystemLoader(TEMPLATES),
        autoescape=select_autoescape(["html"]),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.globals["cost_legend"] = LEGEND
    environment.filters |= {
        "markdown": lambda text: Markup(to_html(text)),
        "md": escaped,
        "code_block": code_block,
        "page": scene_page,
    }
    return environment


def write_styles(folder: Path, *names: str) -> None:
    """Write the style sheet of every page, and others."""
    folder.mkdir(exist_ok=True)
    for name in ("style.css", *names):
        write(folder / name, (TEMPLATES / name).read_text(encoding="utf-8"))


def write(path: Path, text: str) -> None:
    """Write a page: the same bytes on every system, without control characters."""
    path.write_text(shown(text), encoding="utf-8", newline="\n")
