"""What SQLite keeps beside a result file: checked before SQLite acts on it."""

import os
import stat
from contextlib import suppress
from pathlib import Path

from ...scenarios import printable
from .result_file_error import ResultFileError

#: The last bytes of a journal that ends in the name of a super-journal.
_NAMES_ANOTHER = bytes.fromhex("d9d505f920a163d7")


def check_journals(path: Path) -> None:
    """See that what SQLite keeps beside a file is its own, before SQLite acts on it.

    SQLite writes to '-wal' and '-shm', waits for one that is a pipe, and undoes what '-journal'
    says was half written; if that ends in the name of a super-journal, SQLite deletes the file of
    that name. It writes such a name where databases are attached, which is never done here
    (https://www.sqlite.org/fileformat2.html, *The Rollback Journal*).
    """
    for suffix in ("-wal", "-shm", "-journal"):
        beside = path.with_name(f"{path.name}{suffix}")
        name = printable(beside.name)
        # Another run may remove it meanwhile.
        with suppress(FileNotFoundError):
            found = beside.lstat()
            if not stat.S_ISREG(found.st_mode) or found.st_nlink > 1:
                raise ResultFileError(f"'{name}' beside it must be a file of its own; remove that")
            if suffix == "-journal" and _last_bytes(beside, len(_NAMES_ANOTHER)) == _NAMES_ANOTHER:
                raise ResultFileError(
                    f"'{name}' beside it names another file, which SQLite would delete; "
                    "spincheck writes no such journal: remove it"
                )


def _last_bytes(path: Path, count: int) -> bytes:
    with path.open("rb") as file:
        size = file.seek(0, os.SEEK_END)
        file.seek(max(0, size - count))
        return file.read(count)


def log_of(path: Path) -> Path:
    """Where SQLite keeps the log of a file."""
    return path.with_name(f"{path.name}-wal")


def has_log(path: Path) -> bool:
    """Whether there is one with anything in it."""
    with suppress(OSError):
        return log_of(path).stat().st_size > 0
    return False
