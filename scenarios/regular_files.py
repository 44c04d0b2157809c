"""Reads regular files and writes new ones: no pipe is waited for, no link is written through.

All files that come from outside are read here, and all that users ask for are written here. Result
files, which SQLite reads and writes, have checks of their own (`reports/results/result_file.py`).
"""

import errno
import os
import secrets
import stat
from collections.abc import Collection, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

#: Bytes of a user's model, URDF or MJCF; the largest of public packages have one million.
LARGEST_MODEL = 1 << 25
#: Characters of a name that is made of a text.
LONGEST_NAME = 100
#: Opening a pipe would wait for a writer; Windows has no such pipes.
_AT_ONCE = getattr(os, "O_NONBLOCK", 0)


def read_regular(path: Path, limit: int) -> bytes:
    """The bytes of a file: at most one more than `limit`, which tells that it is larger.

    Raises
    ------
    OSError
        If it cannot be read or is not a regular file.
    """
    try:
        with open(path, "rb", opener=_opened) as file:
            return file.read(limit + 1)
    # A name with a NUL, or with characters that no file's name has.
    except ValueError as error:
        raise OSError(errno.EINVAL, str(error), str(path)) from None


def is_own(folder: Path) -> bool:
    """Whether nobody else may put code into a folder, or it is not there yet; root may anywhere."""
    try:
        found = folder.stat()
    except FileNotFoundError:
        return True
    # Windows has neither.
    owners = {0, getattr(os, "getuid", lambda: found.st_uid)()}
    return found.st_uid in owners and not (os.name == "posix" and found.st_mode & stat.S_IWOTH)


def file_name(text: str, taken: Collection[str]) -> str:
    """A text in characters that files' names may have, another one than those taken."""
    plain = "".join(c if c.isalnum() or c in "-_." else "-" for c in text)
    plain = plain.lstrip("-_.")[:LONGEST_NAME] or "unnamed"
    name, count, others = plain, 1, {other.lower() for other in taken}
    while name.lower() in others:
        count += 1
        name = f"{plain}-{count}"
    return name


def write_new(path: Path, text: str, *, replace: bool = True) -> None:
    """Write a text as a new file, the same bytes on every system.

    Parameters
    ----------
    replace : whether an earlier file of that name gives way

    Raises
    ------
    OSError
        If it cannot be written; FileExistsError if there is one that may not be replaced.
    """
    if not replace and os.path.lexists(path):
        raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(path))
    with replacing(path) as new:
        new.write_text(text, encoding="utf-8", newline="\n")


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Yield an empty file beside `path`, which takes its place at the end of the block.

    A reader finds the old file or the new one, whole. A link of that name is replaced.

    Raises
    ------
    OSError
        If it cannot be written, or what has that name is a folder, a pipe or a device.
    """
    if os.path.lexists(path) and not path.is_symlink():
        _check(path.lstat().st_mode, path)
    new = path.with_name(f".spincheck-{secrets.token_hex(8)}{path.suffix}")
    try:
        # With the user's usual rights, which those of `tempfile` are not.
        os.close(os.open(new, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666))
        yield new
        new.replace(path)
    except OSError as error:
        if error.errno is None or error.filename not in (None, str(new)):
            raise
        # Nobody has asked for the other.
        raise OSError(error.errno, error.strerror, str(path)) from None
    finally:
        # It is not there, unless something failed; on a read-only disk not even then.
        with suppress(OSError):
            new.unlink()


def _opened(name: str, flags: int) -> int:
    descriptor = os.open(name, flags | _AT_ONCE)
    try:
        _check(os.fstat(descriptor).st_mode, name)
    except OSError:
        os.close(descriptor)
        raise
    return descriptor


def _check(mode: int, path: Path | str) -> None:
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, "it is a folder", str(path))
    if not stat.S_ISREG(mode):
        raise OSError(errno.EINVAL, "it is not a regular file", str(path))
