"""Templates of pages, with style sheets, scripts and Markdown; the folder of a report."""

import errno
import re
from functools import cache
from importlib.resources import files
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined, select_autoescape
from markdown_it import MarkdownIt
from markupsafe import Markup

from ...scenarios import SIGNALS, is_scene_name
from ...scenarios.regular_files import read_regular, write_new
from ..results.database import shown
from ..results.verdict_words import VERDICTS
from .analysis.wording import count, number
from .markdown import escaped
from .tables import scene_page

#: The converter from Markdown to HTML. Raw HTML, images and links stay text, so that a report loads
#: nothing from elsewhere.
_READER = (
    MarkdownIt("commonmark", {"html": False})
    .enable("table")
    .disable(["image", "link", "autolink", "html_inline", "html_block", "reference"])
)


def to_html(text: str) -> str:
    """Return a text in Markdown as HTML; tags in the text are not interpreted."""
    return str(_READER.render(text))


#: Path of the file that lists the files of a report, one relative path a line.
LIST = "assets/files.txt"
#: Largest number of bytes that are read of that file; for a report of 10⁵ scenes it is smaller.
LONGEST_LIST = 1 << 24
#: Pattern of the relative paths that files of a report can have. Only such files are ever removed.
_OWN = re.compile(
    r"index\.html|report\.md|assets/(?P<asset>[a-z]+\.(js|css)|files\.txt)"
    r"|scenes/(?P<scene>[^/]+)\.(html|md|xml|urdf)"
)


class ReportFolder:
    """The folder that a report is written to: a new or empty one, or that of an earlier report.

    It is created if it does not exist. A list of the report's files is written into it.

    Raises
    ------
    OSError
        If the folder cannot be written, or if it has files but no list of a report's files.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._written: list[str] = []
        folder.mkdir(parents=True, exist_ok=True)
        # Hidden files, such as those of a service that publishes the folder, may be there.
        others = [entry.name for entry in folder.iterdir() if not entry.name.startswith(".")]
        if others and not (folder / LIST).is_file():
            words = f"it holds '{min(others)}' and no report; give a new or an empty folder"
            raise OSError(errno.EEXIST, words, str(folder))
        self._earlier = self._listed()
        self.write(LIST, "\n".join(sorted(self._earlier)))

    def write(self, name: str, text: str) -> Path:
        """Write a text into a file, with control characters escaped; return the file's path.

        Parameters
        ----------
        name : path relative to the report's folder, with `/` between its parts

        Raises
        ------
        OSError
            If the file cannot be written, or its folder is a link.
        """
        path = self._folder / name
        if path.parent != self._folder:
            if path.parent.is_symlink():
                raise OSError(errno.ELOOP, "it is a link", str(path.parent))
            path.parent.mkdir(exist_ok=True)
        write_new(path, shown(text))
        self._written.append(name)
        return path

    def finish(self) -> None:
        """Remove files of an earlier report that this one did not write; update the list of files.

        Other files in the folder are left alone.
        """
        for name in self._earlier - set(self._written):
            path = self._folder / name
            if path.is_file() and not path.parent.is_symlink():
                path.unlink()
        self.write(LIST, "\n".join(sorted(set(self._written))) + "\n")

    def _listed(self) -> set[str]:
        """Return the relative paths of the files that an earlier report wrote, from its list.

        The set is empty if there is no list. Paths that no file of a report can have are ignored.
        """
        try:
            content = read_regular(self._folder / LIST, LONGEST_LIST)
        except FileNotFoundError:
            return set()
        names = content.decode(errors="replace").split("\n")
        own = [match for match in map(_OWN.fullmatch, names) if match]
        return {match[0] for match in own if is_scene_name(match["scene"] or "index")}


_HERE = Path(str(files(__package__)))
#: Folders of templates: one for each page, and `templates` for what pages share. Names of templates
#: are unique over all folders.
FOLDERS = sorted(path for path in _HERE.iterdir() if path.is_dir())


@cache
def templates() -> Environment:
    """Return the Jinja environment of the pages' templates, which escapes values in HTML."""
    environment = Environment(
        loader=FileSystemLoader(FOLDERS),
        autoescape=select_autoescape(["html"]),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.globals |= {"verdicts": VERDICTS, "signals": SIGNALS}
    environment.filters |= {
        "markdown": lambda text: Markup(to_html(text)),
        "md": escaped,
        "page": scene_page,
        "number": number,
        "count": count,
        "g": "{:g}".format,
    }
    return environment


def source(name: str) -> str:
    """Return the text of a style sheet or script; a style sheet is a template and is rendered."""
    environment = templates()
    if name.endswith(".css"):
        return environment.get_template(name).render()
    assert environment.loader is not None
    return environment.loader.get_source(environment, name)[0]


def write_assets(written: ReportFolder, *names: str) -> None:
    """Write style sheets and scripts, given by the names of their files, into a report's folder."""
    for name in names:
        written.write(f"assets/{name}", source(name))
