"""Templates of pages, and the style sheets and scripts beside them."""

from functools import cache
from importlib.resources import files
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined, select_autoescape
from markupsafe import Markup

from .cost_section import LEGEND
from .links import scene_page
from .markdown import code_block, escaped, to_html
from .written import ReportFolder

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


def write_assets(written: ReportFolder, *names: str) -> None:
    """Write style sheets and scripts."""
    for name in names:
        written.write(f"assets/{name}", (TEMPLATES / name).read_text(encoding="utf-8"))
