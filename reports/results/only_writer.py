"""The lock of a result file's only writer, and the files that SQLite keeps beside it."""

import errno
import os
import stat
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from ...scenarios import printable

#: Last bytes of a journal that ends in the name of a super-journal.
_NAMES_ANOTHER = bytes.fromhex("d9d505f920a163d7")


def check_journals(path: Path) -> None:
    """Raise if a file that SQLite keeps beside a result file may do harm to other files.

    It must be called before SQLite acts on those files. SQLite writes to '-wal' and '-shm', waits
    if one of them is a pipe, and undoes what '-journal' says was half written. If '-journal' ends
    in the name of a super-journal, SQLite deletes the file of that name. SQLite writes such a name
    only if databases are attached, which is never done here
    (https://www.sqlite.org/fileformat2.html, *The Rollback Journal*).

    Raises
    ------
    ResultFileError
        If one of the files is a link or no regular file, or names another file to be deleted.
    """
    for suffix in ("-wal", "-shm", "-journal"):
        beside = path.with_name(f"{path.name}{suffix}")
        name = printable(beside.name)
        # Another process may remove the file meanwhile.
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
    """Return the last `count` bytes of a file, or all if it has fewer."""
    with path.open("rb") as file:
        size = file.seek(0, os.SEEK_END)
        file.seek(max(0, size - count))
        return file.read(count)


def log_of(path: Path) -> Path:
    """Return the path of the write-ahead log that SQLite keeps beside a file."""
    return path.with_name(f"{path.name}-wal")


def has_log(path: Path) -> bool:
    """Whether a file has a write-ahead log that is not empty."""
    with suppress(OSError):
        return log_of(path).stat().st_size > 0
    return False


class ResultFileError(ValueError):
    """A result file is missing, cannot be used, or was changed by another program."""


#: The byte that is locked on Windows, beyond the end of any result file: a lock within the file
#: would keep readers out.
_BEYOND = 1 << 62


@contextmanager
def only_writer(path: Path) -> Iterator[Callable[[], None]]:
    """Lock a result file, so that only this process writes to it until the block ends.

    The file is created if there is none. The block gets a function that raises `ResultFileError` if
    the file has been removed or replaced since it was locked. The system releases the lock if this
    process dies. SQLite's own locks, which coordinate readers and a writer, are independent of it.

    Raises
    ------
    ResultFileError
        If the file cannot be written, or another process has locked it.
    """
    try:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
    except OSError as error:
        raise ResultFileError(f"cannot be written: {error.strerror}") from None
    try:
        _lock(descriptor)
        yield lambda: _check_still_there(path, descriptor)
    finally:
        os.close(descriptor)


def _lock(descriptor: int) -> None:
    """Lock an open file for this process.

    It raises `ResultFileError` if another process has locked the file, or its file system has no
    locks.
    """
    try:
        if sys.platform == "win32":
            import msvcrt

            os.lseek(descriptor, _BEYOND, os.SEEK_SET)
            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        else:
            import fcntl

            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        if error.errno in (errno.EWOULDBLOCK, errno.EACCES, errno.EDEADLK):
            raise ResultFileError("another 'spincheck run' is writing to it") from None
        raise ResultFileError(
            f"cannot be locked against a second run: {error.strerror}; "
            "put it on a disk of this computer"
        ) from None


def _check_still_there(path: Path, descriptor: int) -> None:
    """Raise `ResultFileError` unless the path still leads to the file open as `descriptor`."""
    with suppress(FileNotFoundError):
        if os.path.samestat(path.stat(), os.fstat(descriptor)):
            return
    raise ResultFileError(
        "was removed or replaced while it was being written; what this run has found is lost"
    )
