"""The lock of a result file's only writer."""

import errno
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from .result_file_error import ResultFileError

#: The byte that is locked on Windows, beyond the end of any result file: a lock within the file
#: would keep readers out.
_BEYOND = 1 << 62


@contextmanager
def only_writer(path: Path) -> Iterator[Callable[[], None]]:
    """Lock the file as its only writer; the system releases the lock when this process ends.

    The lock is independent of those by which SQLite coordinates readers and a writer. Yields a
    function that raises if the file has been removed or replaced since.
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
    with suppress(FileNotFoundError):
        if os.path.samestat(path.stat(), os.fstat(descriptor)):
            return
    raise ResultFileError(
        "was removed or replaced while it was being written; what this run has found is lost"
    )
