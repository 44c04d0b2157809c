"""Sphinx's settings of the site that `make docs` builds.

No page fetches anything: search is Sphinx's own index, formulas are MathML, figures are files.
"""

import os
import re
import sys
from hashlib import sha256
from importlib.metadata import version as version_of
from pathlib import Path

from jupyter_cache import get_cache
from sphinx.application import Sphinx

DOCS = Path(__file__).parent
#: A parameter in a docstring: at the margin, names, a colon, and what they are.
ENTRY = re.compile(r"^(\*{0,2}\w[\w, *]*) : ", re.MULTILINE)
sys.path.insert(0, str(DOCS / "extensions"))
import warm_start  # noqa: E402


def digest_of_program() -> str:
    """Return what changes when a source changes: outputs of cells are kept by it."""
    tops = ("scenarios", "reference", "engines", "reports")
    files = sorted(file for top in tops for file in (DOCS.parent / top).rglob("*.*"))
    sources = [file for file in files if file.suffix != ".pyc"]
    return sha256(b"".join(file.read_bytes() for file in sources)).hexdigest()[:12]


project = "spincheck"
author = "The spincheck authors"
project_copyright = "The spincheck authors"
version = release = version_of("spincheck")

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "command_pages",
    "mathml",
    "shell_cells",
]
exclude_patterns = ["extensions", "changes", "**/*.sh"]

# Markdown: MyST. Headings are targets of links, as on GitHub.
myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 4
# What a page's code blocks are in, beside the names that Pygments knows.
highlight_language = "none"

# Notebooks run in an empty folder; a cell that fails, fails the build.
nb_execution_mode = "cache"
nb_execution_cache_path = str(DOCS.parent / "build" / "notebooks" / digest_of_program())
# Made here, as two processes that read pages would both make it.
get_cache(nb_execution_cache_path).list_cache_records()
nb_execution_in_temp = True
nb_execution_raise_on_error = True
nb_execution_timeout = 900
# Pages whose cells are not run, by names with blanks between; none but in the tests.
nb_execution_excludepatterns = os.environ.get("SPINCHECK_CELLS_NOT_RUN", "").split()
nb_merge_streams = True
# Commands in cells are those of this Python, and print lines as wide as a page.
os.environ["PATH"] = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
os.environ["COLUMNS"] = "88"
os.environ["PYTHONSTARTUP"] = str(DOCS / "extensions" / "notebook_start.py")
forked_from = warm_start.begin(DOCS.parent / "build" / "notebooks")

autodoc_member_order = "bysource"
napoleon_use_rtype = False
autodoc_typehints = "signature"
python_use_unqualified_type_names = True

html_math_renderer = "mathml"
html_theme = "furo"
html_title = f"spincheck {release}"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sourcelink = False
html_theme_options = {"navigation_with_keys": True}


def describe_without_types(_app: object, _what: str, _name: str, *others: object) -> None:
    """Move what stands behind a parameter's colon below it: here it is no type."""
    lines = others[-1]
    assert isinstance(lines, list)
    text = "\n".join(lines)
    lines[:] = ENTRY.sub(r"\1\n    ", text).splitlines()


def setup(app: Sphinx) -> None:
    """Have docstrings changed before napoleon reads them, and the warm process end."""
    app.connect("autodoc-process-docstring", describe_without_types, priority=400)
    app.connect("build-finished", lambda *_: forked_from.communicate())
