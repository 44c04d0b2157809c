"""Creates, opens, checks and locks a result file.

SQLite's write-ahead log (WAL) is used, so that a report can be made while a study runs, and a
process killed at any instruction leaves an intact file. `synchronous` is NORMAL: commits do not
wait for the disk. A killed process loses nothing by that, since the operating system has what it
wrote; a power cut may lose the last runs, which the next study makes again, but does not damage the
file (https://www.sqlite.org/pragma.html, synchronous).

A result file may come from anyone. Before anything is read from it, the digest of its schema is
compared with ours, so that no foreign view, trigger or expression is ever evaluated
(https://www.sqlite.org/security.html).
"""

import errno
import json
import os
import secrets
import sqlite3
import stat
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, contextmanager, suppress
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import NamedTuple

from ...scenarios import printable

#: "spin" in ASCII: distinguishes a result file from other SQLite databases.
APPLICATION_ID = 0x7370696E
FORMAT = 13
#: Bytes of a record, at most; the motion of the longest window, 10⁶ samples, has 112 MB.
LARGEST_RECORD = 1 << 28

_SCHEMA = """
-- Of the run that wrote last: its name, how often it committed, and whether all of that is in here
-- and none of it in a log beside.
CREATE TABLE file (session TEXT NOT NULL, commits INTEGER NOT NULL, whole INTEGER NOT NULL);
INSERT INTO file VALUES ('', 0, 1);
"""
_IN_WORDS = {
    sqlite3.SQLITE_READONLY_ROLLBACK: (
        "a run was killed while it wrote to it; start that 'spincheck run' again, which mends it"
    ),
    sqlite3.SQLITE_FULL: "cannot be written: the disk is full",
    sqlite3.SQLITE_READONLY: "cannot be written: it is read-only",
    sqlite3.SQLITE_IOERR: "cannot be read or written: the disk fails or is full",
    sqlite3.SQLITE_CANTOPEN: "cannot be opened",
    sqlite3.SQLITE_BUSY: "another program has locked it",
    sqlite3.SQLITE_TOOBIG: "a record is larger than any that spincheck writes",
}
#: The last bytes of a journal that ends in the name of a super-journal.
_NAMES_ANOTHER = bytes.fromhex("d9d505f920a163d7")
#: An SQLite error code's lowest byte is its kind.
_KIND = 0xFF
#: The byte that is locked on Windows, beyond the end of any result file: a lock within the file
#: would keep readers out.
_BEYOND = 1 << 62


class ResultFileError(ValueError):
    """A result file is missing, not one of ours, changed by others, or not writable."""


class OpenFile(NamedTuple):
    """An open result file.

    Attributes
    ----------
    check : raises `ResultFileError` if the file was removed or replaced
    format : the version of its format; an older one than `FORMAT` is only read
    log_missing : whether it is a copy without its log, made while a run was writing
    """

    connection: sqlite3.Connection
    check: Callable[[], None]
    log_missing: bool
    format: int = FORMAT


@contextmanager
def opened(
    path: Path, schema: str, older: Mapping[int, str], *, writing: bool
) -> Iterator[OpenFile]:
    """Open a result file for reading, or for writing; a new one is created if there is none.

    Parameters
    ----------
    schema : the tables as SQL
    older : of the older formats that are read, the digests of their schemas (`digest_of`)

    Raises
    ------
    ResultFileError
        If the file is missing, cannot be opened, read or written, is not a result file of this
        format, or is being written by another process.
    """
    schema = _SCHEMA + schema
    own = {FORMAT: _digest_of_tables(schema)}
    try:
        if not _is_there(path, "written" if writing else "read") and not writing:
            raise ResultFileError(
                "no such result file; 'spincheck run fast-top' writes one of a scene, "
                "'spincheck run' of the whole library"
            )
        # SQLite has its journals beside the file itself, not beside a link to it.
        place = path.resolve()
        _check_journals(place)
        _check_log(place)
        with (
            _to_write(place, schema, own) if writing else _to_read(place, {**older, **own}) as file
        ):
            yield file
    except sqlite3.DatabaseError as error:
        code = getattr(error, "sqlite_errorcode", 0)
        other = f"not a usable result file: {printable(str(error))}"
        words = _IN_WORDS.get(code) or _IN_WORDS.get(code & _KIND, other)
        raise ResultFileError(f"{printable(str(path))}: {words}") from error
    except ResultFileError as error:
        raise ResultFileError(f"{printable(str(path))}: {error}") from error


def _is_there(path: Path, purpose: str) -> bool:
    """Whether there is a file to open; pipes, which would block, are refused."""
    try:
        found = path.stat()
    except FileNotFoundError:
        if path.is_symlink():
            raise ResultFileError(f"cannot be {purpose}: it is a link to nothing") from None
        return False
    except OSError as error:
        raise ResultFileError(f"cannot be {purpose}: {error.strerror}") from None
    if not stat.S_ISREG(found.st_mode):
        kind = "a folder" if stat.S_ISDIR(found.st_mode) else "not a regular file"
        raise ResultFileError(f"cannot be {purpose}: it is {kind}")
    if path.is_symlink() and not found.st_size:
        raise ResultFileError(f"cannot be {purpose}: it is a link to an empty file")
    return True


def _check_journals(path: Path) -> None:
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


@contextmanager
def _to_read(path: Path, digests: Mapping[int, str]) -> Iterator[OpenFile]:
    # Before it is opened: opening creates an empty file.
    log_missing = not _has_log(path)
    with _connected(path, "mode=ro") as connection:
        connection.execute("PRAGMA query_only = ON")
        version = _check(connection, digests)
        (whole,) = connection.execute("SELECT min(whole) FROM file").fetchone()
        yield OpenFile(connection, lambda: None, log_missing and not whole, version)


@contextmanager
def _to_write(path: Path, schema: str, own: Mapping[int, str]) -> Iterator[OpenFile]:
    with _alone(path) as check, _connected(path, "mode=rw") as connection:
        if connection.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]:
            _check(connection, own)
        else:
            _begin(connection, schema)
        # Before there is a log, so that the file records that it has one, and which.
        session = "UPDATE file SET session = ?, whole = 0"
        connection.execute("PRAGMA journal_mode = DELETE")
        with connection:
            connection.execute(session, (secrets.token_hex(),))
        connection.execute("PRAGMA journal_mode = WAL")
        connection.execute("PRAGMA synchronous = NORMAL")
        try:
            yield OpenFile(connection, check, log_missing=False)
            check()
        except sqlite3.DatabaseError:
            # SQLite's own message does not tell that the file was removed.
            check()
            raise
        finally:
            # A file at rest is one file without gaps, which can be read where nothing may be
            # written; while another program reads it, the log stays.
            with suppress(sqlite3.DatabaseError):
                connection.execute("PRAGMA busy_timeout = 0")
                connection.executescript("PRAGMA incremental_vacuum")
                with connection:
                    connection.execute("UPDATE file SET whole = 1")
                connection.execute("PRAGMA journal_mode = DELETE")


@contextmanager
def _connected(path: Path, options: str) -> Iterator[sqlite3.Connection]:
    address = f"{path.as_uri()}?{options}"
    with closing(sqlite3.connect(address, uri=True, check_same_thread=False)) as connection:
        connection.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, LARGEST_RECORD)
        connection.text_factory = _text
        connection.execute("PRAGMA trusted_schema = OFF")
        connection.execute("PRAGMA cell_size_check = ON")
        try:
            connection.execute("SELECT count(*) FROM sqlite_master")
        except UnicodeDecodeError:
            # SQLite quotes what it cannot read of a schema, in bytes that are no text.
            raise sqlite3.DatabaseError("its schema is not text") from None
        yield connection


def _check_log(path: Path) -> None:
    """Check that the log beside a file is its own, not one left by a killed run of another file.

    SQLite would apply the log to whatever file now has the name.
    """
    if not (_has_log(path) and path.exists()):
        return
    by_itself = _session(path, "immutable=1")
    if by_itself is not None and _session(path, "mode=ro") != by_itself:
        raise ResultFileError(
            f"the log beside it, '{printable(_log(path).name)}', belongs to another result file, "
            "whose run was killed: put those two side by side again, or delete the log, and with "
            "it the last runs of that one"
        )


def _session(path: Path, options: str) -> str | None:
    """The name of the run that wrote last; None if it cannot be read."""
    try:
        with _connected(path, options) as connection:
            return str(connection.execute("SELECT max(session) FROM file").fetchone()[0])
    except sqlite3.OperationalError as error:
        # That it is not a result file is reported later; other errors, such as a lock, at once.
        if getattr(error, "sqlite_errorcode", 0) & _KIND != sqlite3.SQLITE_ERROR:
            raise
    except sqlite3.DatabaseError:
        pass
    return None


def _log(path: Path) -> Path:
    return path.with_name(f"{path.name}-wal")


def _has_log(path: Path) -> bool:
    with suppress(OSError):
        return _log(path).stat().st_size > 0
    return False


@contextmanager
def _alone(path: Path) -> Iterator[Callable[[], None]]:
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


def _begin(connection: sqlite3.Connection, schema: str) -> None:
    """Create the tables, in one transaction: if interrupted, the file stays empty."""
    # Has an effect only while the file is empty.
    connection.execute("PRAGMA auto_vacuum = INCREMENTAL")
    connection.executescript(
        f"BEGIN; PRAGMA application_id = {APPLICATION_ID}; PRAGMA user_version = {FORMAT};"
        f"{schema} COMMIT;"
    )


def _check(connection: sqlite3.Connection, digests: Mapping[int, str]) -> int:
    """The file's format, after a check that it is one of ours and undamaged."""
    if connection.execute("PRAGMA application_id").fetchone()[0] != APPLICATION_ID:
        raise ResultFileError("not a result file of spincheck")
    version = connection.execute("PRAGMA user_version").fetchone()[0]
    if version not in digests:
        known = " and ".join(map(str, sorted(digests)))
        does = "reads" if len(digests) > 1 else "continues"
        raise ResultFileError(f"result file format {version}, this version {does} {known}")
    if digest_of(connection) != digests[version]:
        raise ResultFileError(f"its schema is not that of a result file of format {version}")
    # Damage is reported here, not in the middle of a report.
    first_damage = connection.execute("PRAGMA quick_check(1)").fetchone()[0]
    if first_damage != "ok":
        raise ResultFileError(f"damaged: {printable(first_damage)}")
    return int(version)


def digest_of(connection: sqlite3.Connection) -> str:
    """SHA-256 of type, name, table and text of everything that a schema holds."""
    query = "SELECT type, name, tbl_name, sql FROM sqlite_master"
    objects = sorted([*map(str, columns)] for columns in connection.execute(query))
    return sha256(json.dumps(objects).encode()).hexdigest()


def _text(content: bytes) -> str:
    """Text of the schema, decoded; it may not be valid UTF-8."""
    return content.decode(errors="backslashreplace")


@cache
def _digest_of_tables(schema: str) -> str:
    with closing(sqlite3.connect(":memory:")) as connection:
        connection.executescript(schema)
        return digest_of(connection)
