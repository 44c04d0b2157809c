"""Writes the files of a report into a folder, and removes those of an earlier report."""

import errno
import re
from pathlib import Path

from ...scenarios import is_scene_name
from ...scenarios.regular_files import read_regular, write_new
from ..results.database import shown

#: The file that lists what was written, one relative path a line.
LIST = "assets/files.txt"
#: Bytes of the list that are read; a report of 10⁵ scenes has fewer.
LONGEST_LIST = 1 << 24
#: What a report can have written: the files of its folders, named by scenes.
_OWN = re.compile(
    r"index\.html|report\.md|assets/(?P<asset>[a-z]+\.(js|css)|files\.txt)"
    r"|(scenes|maps|ensembles)/(?P<scene>[^/]+)\.(html|md|xml|urdf)"
)


class ReportFolder:
    """A folder that pages are written to: a new one, an empty one, or one that has been before.

    Raises
    ------
    OSError
        If it cannot be written, or holds what is not a report's.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._written: list[str] = []
        folder.mkdir(parents=True, exist_ok=True)
        # Hidden files are of whatever publishes the folder.
        others = [entry.name for entry in folder.iterdir() if not entry.name.startswith(".")]
        if others and not (folder / LIST).is_file():
            words = f"it holds '{min(others)}' and no report; give a new or an empty folder"
            raise OSError(errno.EEXIST, words, str(folder))
        self._earlier = self._listed()
        self.write(LIST, "\n".join(sorted(self._earlier)))

    def write(self, name: str, text: str) -> Path:
        """Write a file, given as a relative path with `/`, without control characters."""
        path = self._folder / name
        if path.parent != self._folder:
            if path.parent.is_symlink():
                raise OSError(errno.ELOOP, "it is a link", str(path.parent))
            path.parent.mkdir(exist_ok=True)
        write_new(path, shown(text))
        self._written.append(name)
        return path

    def finish(self) -> None:
        """Remove files that an earlier report wrote and this one did not; nothing else."""
        for name in self._earlier - set(self._written):
            path = self._folder / name
            if path.is_file() and not path.parent.is_symlink():
                path.unlink()
        self.write(LIST, "\n".join(sorted(set(self._written))) + "\n")

    def _listed(self) -> set[str]:
        """What an earlier report wrote: of the names in its list those that a report can have."""
        try:
            content = read_regular(self._folder / LIST, LONGEST_LIST)
        except FileNotFoundError:
            return set()
        names = content.decode(errors="replace").split("\n")
        own = [match for match in map(_OWN.fullmatch, names) if match]
        return {match[0] for match in own if is_scene_name(match["scene"] or "index")}
