"""Writes files over earlier ones of spincheck, and over no others."""

from collections.abc import Mapping
from pathlib import Path

from ...scenarios import printable
from ...scenarios.regular_files import LARGEST_MODEL, read_regular, write_new
from .terminal import Complaint, written

#: Words by which a file that spincheck has written is known.
MARKS = (b"Written by spincheck", b"Exact motion by spincheck")


def write_own(texts: Mapping[Path, str]) -> None:
    """Write texts, each with one of `MARKS` in it, into files.

    A `Complaint` is raised, and nothing is written, if a file of one of these names exists that
    spincheck has not written.

    Parameters
    ----------
    texts : the texts, by the paths of their files
    """
    for path in filter(Path.exists, texts):
        with written(path):
            content = read_regular(path, LARGEST_MODEL)
        if not any(mark in content for mark in MARKS):
            raise Complaint(
                f"{printable(str(path))}: exists already, and spincheck has not written it; remove "
                "it, or choose another place"
            )
    for path, text in texts.items():
        with written(path):
            path.parent.mkdir(parents=True, exist_ok=True)
            write_new(path, text)
