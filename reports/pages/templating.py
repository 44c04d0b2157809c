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

#: A folder a page, and `templates` for what pages share; no two templates have one name.
FOLDERS = sorted(path for path in Path(str(files(__package__))).iterdir() if path.is_dir())


@cache
def templates() -> Environment:
    """The template environment; values in HTML are escaped."""
    environment = Environment(
        loader=FileSystemLoader(FOLDERS),
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


def source(name: str) -> str:
    """The text of a style sheet or script, as it stands in its page's folder."""
    environment = templates()
    assert environment.loader is not None
    return environment.loader.get_source(environment, name)[0]


def write_styles(folder: Path, *names: str) -> None:
    """Write the style sheet of every page, and others."""
    folder.mkdir(exist_ok=True)
    for name in ("style.css", *names):
        write(folder / name, source(name))


def write(path: Path, text: str) -> None:
    """Write a page: the same bytes on every system, without control characters."""
    path.write_text(shown(text), encoding="utf-8", newline="\n")
