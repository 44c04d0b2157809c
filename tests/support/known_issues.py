"""The known issues of docs/measured/known-issues.toml, as records."""

import shlex
import tomllib
from dataclasses import dataclass
from pathlib import Path

DATA = Path(__file__).parents[2] / "docs/measured/known-issues.toml"


@dataclass(frozen=True)
class KnownIssue:
    """One public issue: what answers it, or why nothing here does.

    Attributes
    ----------
    engine : that the command runs; empty if the exact motion alone answers
    stand_in : whether that is another engine than the issue's
    versions : of it, besides the one that is installed
    expected : what the measurement must contain
    model : text of the file that is MODEL in the command
    why : why there is no command
    """

    url: str
    title: str
    engine: str = ""
    stand_in: bool = False
    versions: tuple[str, ...] = ()
    scene: str = ""
    command: str = ""
    expected: tuple[str, ...] = ()
    model: str = ""
    why: str = ""

    @property
    def name(self) -> str:
        """Such as google/brax#48."""
        *_, owner, repository, _, number = self.url.split("/")
        return f"{owner}/{repository}#{number}"

    def words(self, folder: Path) -> list[str]:
        """The command's words, with its model written into a folder."""
        suffix = "urdf" if self.model.startswith("<") else "toml"
        model = folder / f"model.{suffix}"
        if self.model:
            model.write_text(self.model, encoding="utf-8")
        places = {"MODEL": str(model), "OUT": str(folder / "out")}
        return [places.get(word, word) for word in shlex.split(self.command)]


def known_issues() -> tuple[KnownIssue, ...]:
    """All of them, in the file's order."""
    entries = tomllib.loads(DATA.read_text(encoding="utf-8"))["issue"]
    lists = ("versions", "expected")
    return tuple(
        KnownIssue(**(one | {name: tuple(one.get(name, ())) for name in lists})) for one in entries
    )
