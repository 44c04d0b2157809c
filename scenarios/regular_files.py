"""Reads regular files and writes new ones: no pipe is waited for, no link is written through.

All files that come from outside are read here, and all files that users ask for are written here.
Result files, which SQLite reads and writes, have checks of their own
(`reports/results/result_file.py`).
"""

import errno
import os
import secrets
import stat
from collections.abc import Collection, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

#: Largest size of a user's model, URDF or MJCF, bytes; the largest of public packages have one
#: million.
LARGEST_MODEL = 1 << 25
#: Largest length of a file name that is made of a text, characters.
LONGEST_NAME = 100
#: Flag with which opening a pipe does not wait for a writer; Windows has no such pipes.
_AT_ONCE = getattr(os, "O_NONBLOCK", 0)


def read_regular(path: Path, limit: int) -> bytes:
    """Return the bytes of a file; if there are more than `limit`, the first `limit` + 1 of them.

    Raises
    ------
    OSError
        If the file cannot be read or is not a regular file.
    """
    try:
        with open(path, "rb", opener=_opened) as file:
            return file.read(limit + 1)
    # Raised for a name with a NUL, or with characters that no file's name can have.
    except ValueError as error:
        raise OSError(errno.EINVAL, str(error), str(path)) from None


def is_own(folder: Path) -> bool:
    """Whether a folder is this user's or root's and not writable by all; true if it is missing.

    Write access of its group, or by access-control lists, is not examined. It is always true on
    Windows.
    """
    try:
        found = folder.stat()
    except FileNotFoundError:
        return True
    # Windows has neither owners nor modes.
    owners = {0, getattr(os, "getuid", lambda: found.st_uid)()}
    return found.st_uid in owners and not (os.name == "posix" and found.st_mode & stat.S_IWOTH)


def file_name(text: str, taken: Collection[str]) -> str:
    """Return a file name made of a text, different from all names in `taken`.

    Characters that file names may not have become hyphens; case does not distinguish names.
    """
    plain = "".join(c if c.isalnum() or c in "-_." else "-" for c in text)
    plain = plain.lstrip("-_.")[:LONGEST_NAME] or "unnamed"
    name, count, others = plain, 1, {other.lower() for other in taken}
    while name.lower() in others:
        count += 1
        name = f"{plain}-{count}"
    return name


def write_new(path: Path, text: str, *, replace: bool = True) -> None:
    """Write a text into a new file, with the same bytes on every system.

    Parameters
    ----------
    replace : whether a file of the same name is replaced

    Raises
    ------
    OSError
        If the file cannot be written; FileExistsError if a file of that name exists and `replace`
        is false.
    """
    if not replace and os.path.lexists(path):
        raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(path))
    with replacing(path) as new:
        new.write_text(text, encoding="utf-8", newline="\n")


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Yield the path of a new empty file, which replaces `path` at the end of the block.

    So a reader finds either the whole old file or the whole new one. If `path` is a link, the link
    is replaced and not the file that it leads to.

    Raises
    ------
    OSError
        If the file cannot be written, or if `path` is a folder, a pipe or a device.
    """
    if os.path.lexists(path) and not path.is_symlink():
        _check(path.lstat().st_mode, path)
    new = path.with_name(f".spincheck-{secrets.token_hex(8)}{path.suffix}")
    try:
        # Give it the user's usual permissions, which files of `tempfile` do not have.
        os.close(os.open(new, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666))
        yield new
        new.replace(path)
    except OSError as error:
        if error.errno is None or error.filename not in (None, str(new)):
            raise
        # The error of the attempt to write is reported, not one of cleaning up.
        raise OSError(error.errno, error.strerror, str(path)) from None
    finally:
        # The temporary file is left over only if something failed, and then it may be impossible to
        # remove.
        with suppress(OSError):
            new.unlink()


def _opened(name: str, flags: int) -> int:
    """Open a regular file with flags of `os.open`, without waiting; return its descriptor.

    `OSError` is raised if it cannot be opened or is not a regular file.
    """
    descriptor = os.open(name, flags | _AT_ONCE)
    try:
        _check(os.fstat(descriptor).st_mode, name)
    except OSError:
        os.close(descriptor)
        raise
    return descriptor


def _check(mode: int, path: Path | str) -> None:
    """Raise `OSError` unless a mode, as of `os.stat`, is that of a regular file."""
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, "it is a folder", str(path))
    if not stat.S_ISREG(mode):
        raise OSError(errno.EINVAL, "it is not a regular file", str(path))
