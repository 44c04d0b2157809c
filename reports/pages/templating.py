"""Templates of pages, and the style sheets and scripts beside them."""

from functools import cache
from importlib.resources import files
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined, select_autoescape
from markupsafe import Markup

from ...scenarios import SIGNALS
from ..results.verdict_words import VERDICTS
from .cost_section import LEGEND
from .links import scene_page
from .markdown import code_block, escaped, to_html
from .written import ReportFolder

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
    environment.globals |= {"cost_legend": LEGEND, "verdicts": VERDICTS, "signals": SIGNALS}
    environment.filters |= {
        "markdown": lambda text: Markup(to_html(text)),
        "md": escaped,
        "code_block": code_block,
        "page": scene_page,
    }
    return environment


def source(name: str) -> str:
    """The text of a style sheet, which is a template, or of a script, which is none."""
    environment = templates()
    if name.endswith(".css"):
        return environment.get_template(name).render()
    assert environment.loader is not None
    return environment.loader.get_source(environment, name)[0]


def write_assets(written: ReportFolder, *names: str) -> None:
    """Write style sheets and scripts."""
    for name in names:
        written.write(f"assets/{name}", source(name))
