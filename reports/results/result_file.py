"""A result file as a file: begun, opened, refused, locked against a second writer.

Written ahead (WAL), so that a report can be made while a study runs and a process killed at any
instruction leaves a whole file. `synchronous` is NORMAL: no commit waits for the disk, which a
killed process does not miss, since what it wrote is with the operating system; only a power cut
takes the last runs, never the file's wholeness (https://www.sqlite.org/pragma.html, synchronous),
and the next study makes them again.
"""

import fcntl
import os
import sqlite3
import stat
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from pathlib import Path

from ...scenarios import printable

#: "spin" in ASCII: tells a result file from any other SQLite database.
APPLICATION_ID = 0x7370696E
FORMAT = 8

_IN_WORDS = {
    sqlite3.SQLITE_FULL: "cannot be written: the disk is full",
    sqlite3.SQLITE_READONLY: "cannot be written: it is read-only",
    sqlite3.SQLITE_IOERR: "cannot be read or written: the disk fails or is full",
    sqlite3.SQLITE_CANTOPEN: "cannot be opened",
    sqlite3.SQLITE_BUSY: "another program holds it",
}
#: An SQLite error code's lowest byte is its kind.
_KIND = 0xFF


class ResultFileError(ValueError):
    """A result file is missing, not one of ours, of another format version, or not writable."""


@contextmanager
def opened(path: Path, schema: str, *, writing: bool) -> Iterator[sqlite3.Connection]:
    """Open a result file to read it, or to write it and begin it where there is none.

    Raises
    ------
    ResultFileError
        If the file is missing, cannot be opened, read or written, is not a result file of this
        format, or is being written by another process.
    """
    try:
        if not _is_there(path, "written" if writing else "read") and not writing:
            raise ResultFileError("no such result file; 'spincheck run' writes one")
        with _to_write(path, schema) if writing else _to_read(path) as connection:
            yield connection
    except sqlite3.DatabaseError as error:
        kind = getattr(error, "sqlite_errorcode", 0) & _KIND
        words = _IN_WORDS.get(kind, f"not a usable result file: {error}")
        raise ResultFileError(f"{printable(str(path))}: {words}") from error
    except ResultFileError as error:
        raise ResultFileError(f"{printable(str(path))}: {error}") from error


def _is_there(path: Path, purpose: str) -> bool:
    """Whether there is a file to open; a pipe, which would be waited for, is not one."""
    try:
        mode = path.stat().st_mode
    except FileNotFoundError:
        return False
    except OSError as error:
        raise ResultFileError(f"cannot be {purpose}: {error.strerror}") from None
    if not stat.S_ISREG(mode):
        kind = "a folder" if stat.S_ISDIR(mode) else "not a regular file"
        raise ResultFileError(f"cannot be {purpose}: it is {kind}")
    return True


@contextmanager
def _to_read(path: Path) -> Iterator[sqlite3.Connection]:
    address = f"{path.resolve().as_uri()}?mode=ro"
    with closing(sqlite3.connect(address, uri=True)) as connection:
        _check(connection)
        yield connection


@contextmanager
def _to_write(path: Path, schema: str) -> Iterator[sqlite3.Connection]:
    with _alone(path), closing(sqlite3.connect(path, check_same_thread=False)) as connection:
        begun = connection.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]
        if begun:
            _check(connection)
        # Can be chosen before there is anything in the file, and has no effect later.
        connection.execute("PRAGMA auto_vacuum = INCREMENTAL")
        connection.execute("PRAGMA journal_mode = WAL")
        connection.execute("PRAGMA synchronous = NORMAL")
        if not begun:
            _begin(connection, schema)
        try:
            yield connection
        finally:
            # A file at rest is one file without gaps, which can be read where nothing may be
            # written; where somebody reads it just now it stays as it is.
            with suppress(sqlite3.DatabaseError):
                connection.execute("PRAGMA busy_timeout = 0")
                connection.executescript("PRAGMA incremental_vacuum")
                connection.execute("PRAGMA journal_mode = DELETE")


@contextmanager
def _alone(path: Path) -> Iterator[None]:
    """Hold the file as its only writer; the system lets go of it when this process ends.

    The lock is not one of those by which SQLite lets readers and a writer take turns.
    """
    try:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
    except OSError as error:
        raise ResultFileError(f"cannot be written: {error.strerror}") from None
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        yield
    except BlockingIOError:
        raise ResultFileError("another 'spincheck run' is writing to it") from None
    finally:
        os.close(descriptor)


def _begin(connection: sqlite3.Connection, schema: str) -> None:
    """In one transaction, so that a file is begun or empty, whenever this is interrupted."""
    connection.executescript(
        f"BEGIN; PRAGMA application_id = {APPLICATION_ID}; PRAGMA user_version = {FORMAT};"
        f"{schema} COMMIT;"
    )


def _check(connection: sqlite3.Connection) -> None:
    if connection.execute("PRAGMA application_id").fetchone()[0] != APPLICATION_ID:
        raise ResultFileError("not a result file of spincheck")
    # Damage is told here, rather than stumbled upon in the middle of a report.
    found = connection.execute("PRAGMA quick_check(1)").fetchone()[0]
    if found != "ok":
        raise ResultFileError(f"damaged: {printable(found)}")
    version = connection.execute("PRAGMA user_version").fetchone()[0]
    if version != FORMAT:
        raise ResultFileError(f"result file format {version}, this version reads {FORMAT}")
