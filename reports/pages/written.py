"""The files of a report: written into one folder, where those of an earlier one do not stay."""

from pathlib import Path

from .templating import write

#: Names what was written, one path a line, relative to the folder.
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
        """Write a file, `/` between folders and name; returns where it is."""
        path = self._folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        write(path, text)
        self._written.append(name)
        return path

    def finish(self) -> None:
        """Remove what an earlier report wrote here and this one did not; nothing else."""
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
    """Whether it is a file below the folder: the list may be anybody's."""
    return path.is_file() and path.parent.resolve().is_relative_to(folder.resolve())
