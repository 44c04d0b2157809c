"""Writes the files of a report into a folder, and removes those of an earlier report."""

from pathlib import Path

from .templating import write

#: The file that lists what was written, one relative path a line.
LIST = "assets/files.txt"


class ReportFolder:
    """A folder that a report is written to.

    Raises
    ------
    OSError
        If it cannot be written.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._written: list[str] = []

    def write(self, name: str, text: str) -> Path:
        """Write a file, given as a relative path with `/`; returns its path."""
        path = self._folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        write(path, text)
        self._written.append(name)
        return path

    def finish(self) -> None:
        """Remove files that an earlier report wrote and this one did not; nothing else."""
        for name in self._earlier() - set(self._written):
            path = self._folder / name
            if _is_inside(path, self._folder):
                path.unlink(missing_ok=True)
        self.write(LIST, "\n".join(sorted({*self._written, LIST})) + "\n")

    def _earlier(self) -> set[str]:
        try:
            return set((self._folder / LIST).read_text(encoding="utf-8").split("\n")) - {""}
        except (FileNotFoundError, UnicodeDecodeError):
            return set()


def _is_inside(path: Path, folder: Path) -> bool:
    """Whether a listed path is below the folder: the list is not trusted."""
    return path.is_file() and path.parent.resolve().is_relative_to(folder.resolve())
