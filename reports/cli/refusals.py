"""Errors of the operating system, each as one message instead of a traceback."""

import errno
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from .stopping import STDOUT, print_nowhere
from .terminal import BAD_INPUT, NOT_RUN, Complaint

#: Error numbers of an output that cannot be written.
_OF_OUTPUT = (errno.ENOSPC, errno.EPIPE, errno.EBADF, errno.EIO, errno.EFBIG, errno.EDQUOT)


def refusal(error: Exception) -> Complaint | None:
    """The message for an error of the operating system; None for any other error."""
    from ..harness.executors import cause_of

    if isinstance(error, FileNotFoundError) and error.filename is None:
        return Complaint("the current folder was deleted; change to another", NOT_RUN)
    if isinstance(error, OSError) and error.filename is not None:
        return unusable(error.filename, error)
    if isinstance(error, OSError) and error.errno in _OF_OUTPUT:
        print_nowhere(STDOUT)
        return Complaint(f"the output cannot be written: {error.strerror}", NOT_RUN)
    if isinstance(error, MemoryError):
        return Complaint("there is not enough memory", NOT_RUN)
    if cause_of(error) == "environment":
        return Complaint(f"the system does not let it go on: {error}", NOT_RUN)
    return None


@contextmanager
def written(place: Path | str) -> Iterator[None]:
    """Have a file or folder that cannot be written end the command with one message."""
    try:
        yield
    except OSError as error:
        raise unusable(error.filename or place, error, "written") from None


def unusable(place: Path | str, error: OSError, purpose: str = "used") -> Complaint:
    """The complaint about a file or folder that cannot be written or used."""
    from ...scenarios import printable

    where = printable(str(place))
    return Complaint(f"{where}: cannot be {purpose}: {error.strerror}", BAD_INPUT)
