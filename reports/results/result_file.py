"""Creates, opens, checks and locks a result file.

SQLite's write-ahead log (WAL) is used, so that a report can be made while a study runs, and a
process killed at any instruction leaves an intact file. `synchronous` is NORMAL: commits do not
wait for the disk. A killed process loses nothing by that, since the operating system has all that
was written. A power cut does not damage the file, but may lose the last runs, which the next study
makes again (https://www.sqlite.org/pragma.html, synchronous).

A result file may come from anyone. Before any record is read, the digest of the file's schema is
compared with that of a valid one, so that no foreign view, trigger or expression is ever evaluated
(https://www.sqlite.org/security.html).
"""

import json
import secrets
import sqlite3
import stat
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import NamedTuple

from ...scenarios import printable
from .only_writer import ResultFileError as ResultFileError
from .only_writer import check_journals, has_log, log_of, only_writer

#: "spin" in ASCII: distinguishes a result file from other SQLite databases.
APPLICATION_ID = 0x7370696E
#: Version of the format: results of another one cannot be read.
FORMAT = 19
#: Largest size of a record, bytes; the motion of the longest window, 10⁶ samples, takes 112 MB.
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
#: Mask of the lowest byte of an SQLite error code, which is the primary code.
_KIND = 0xFF


class OpenFile(NamedTuple):
    """An open result file.

    Attributes
    ----------
    connection : SQLite's connection to the file
    check : function that raises `ResultFileError` if the file was removed or replaced since
    log_missing : whether the file is a copy, without its log, of a file that was being written
    """

    connection: sqlite3.Connection
    check: Callable[[], None]
    log_missing: bool


@contextmanager
def opened(path: Path, schema: str, *, writing: bool) -> Iterator[OpenFile]:
    """Open a result file for reading or for writing.

    Parameters
    ----------
    schema : the SQL statements that create the file's tables
    writing : whether the file is opened for writing; it is then created if there is none

    Raises
    ------
    ResultFileError
        If the file is missing, cannot be opened, read or written, is not a result file of this
        format, or is being written by another process.
    """
    schema = _SCHEMA + schema
    try:
        if not _is_there(path, "written" if writing else "read") and not writing:
            raise ResultFileError(
                "no such result file; 'spincheck run fast-top' writes one of a scene, "
                "'spincheck run' of the whole library"
            )
        # SQLite keeps its journals beside the file itself, not beside a link to it.
        place = path.resolve()
        check_journals(place)
        _check_log(place)
        with _to_write(place, schema) if writing else _to_read(place, schema) as file:
            yield file
    except sqlite3.DatabaseError as error:
        code = getattr(error, "sqlite_errorcode", 0)
        other = f"not a usable result file ({printable(str(error))}); 'spincheck run' writes one"
        words = _IN_WORDS.get(code) or _IN_WORDS.get(code & _KIND, other)
        raise ResultFileError(f"{printable(str(path))}: {words}") from error
    except ResultFileError as error:
        raise ResultFileError(f"{printable(str(path))}: {error}") from error


def _is_there(path: Path, purpose: str) -> bool:
    """Whether there is a regular file at the path; False if there is nothing.

    Parameters
    ----------
    purpose : "read" or "written", for the message

    Raises
    ------
    ResultFileError
        If there is something else, such as a folder, or a pipe, on which reading would block; if
        there is a link to nothing or to an empty file; or if the system denies access.
    """
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


@contextmanager
def _to_read(path: Path, schema: str) -> Iterator[OpenFile]:
    """Open an existing result file for reading; `schema` is the SQL that creates its tables."""
    # Checked before SQLite opens the file, which creates an empty log.
    log_missing = not has_log(path)
    with _connected(path, "mode=ro") as connection:
        connection.execute("PRAGMA query_only = ON")
        _check(connection, schema)
        (whole,) = connection.execute("SELECT min(whole) FROM file").fetchone()
        yield OpenFile(connection, lambda: None, log_missing and not whole)


@contextmanager
def _to_write(path: Path, schema: str) -> Iterator[OpenFile]:
    """Open a result file for writing, as its only writer; create it if there is none.

    `schema` is the SQL that creates its tables.
    """
    with only_writer(path) as check, _connected(path, "mode=rw") as connection:
        if connection.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]:
            _check(connection, schema)
        else:
            _begin(connection, schema)
        # Written into the file itself, before there is a log: so the file states that a part of its
        # contents may be in a log, and in that of which session.
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
            # SQLite's own message does not say that the file was removed.
            check()
            raise
        finally:
            # The log is written into the file and removed, so that the file can be read even where
            # nothing may be written. If another program reads the file now, the log stays.
            with suppress(sqlite3.DatabaseError):
                connection.execute("PRAGMA busy_timeout = 0")
                connection.executescript("PRAGMA incremental_vacuum")
                with connection:
                    connection.execute("UPDATE file SET whole = 1")
                connection.execute("PRAGMA journal_mode = DELETE")


@contextmanager
def _connected(path: Path, options: str) -> Iterator[sqlite3.Connection]:
    """Yield a connection to an SQLite file, with limits and checks in case it is harmful.

    Parameters
    ----------
    options : options of the connection, in the form of a URI's query, such as "mode=ro"

    Raises
    ------
    sqlite3.DatabaseError
        If the file cannot be opened, or is no SQLite file.
    """
    address = f"{path.as_uri()}?{options}"
    with closing(sqlite3.connect(address, uri=True, check_same_thread=False)) as connection:
        connection.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, LARGEST_RECORD)
        connection.text_factory = _text
        connection.execute("PRAGMA trusted_schema = OFF")
        connection.execute("PRAGMA cell_size_check = ON")
        try:
            connection.execute("SELECT count(*) FROM sqlite_master")
        except UnicodeDecodeError:
            # SQLite quotes the part of a schema that it cannot read, in bytes that may not be text.
            raise sqlite3.DatabaseError("its schema is not text") from None
        yield connection


def _check_log(path: Path) -> None:
    """Raise `ResultFileError` if the log beside a file belongs to another file.

    A killed run leaves such a log if its file is then moved away. SQLite would apply the log to the
    file that has the name now.
    """
    if not (has_log(path) and path.exists()):
        return
    by_itself = _session(path, "immutable=1")
    if by_itself is not None and _session(path, "mode=ro") != by_itself:
        raise ResultFileError(
            f"the log beside it, '{printable(log_of(path).name)}', belongs to another result file, "
            "whose run was killed: put those two side by side again, or delete the log, and with "
            "it the last runs of that one"
        )


def _session(path: Path, options: str) -> str | None:
    """Return the random name that a file got when it was last opened for writing.

    None is returned if the file is damaged, or no result file.

    Parameters
    ----------
    options : options of SQLite's connection; with "immutable=1" the write-ahead log is ignored

    Raises
    ------
    sqlite3.OperationalError
        If the file cannot be opened or read for another reason, such as a lock.
    """
    try:
        with _connected(path, options) as connection:
            return str(connection.execute("SELECT max(session) FROM file").fetchone()[0])
    except sqlite3.OperationalError as error:
        # If there is no such table, the file is no result file, which `_check` reports later. Other
        # errors, such as a lock, are raised at once.
        if getattr(error, "sqlite_errorcode", 0) & _KIND != sqlite3.SQLITE_ERROR:
            raise
    except sqlite3.DatabaseError:
        pass
    return None


def _begin(connection: sqlite3.Connection, schema: str) -> None:
    """Create the tables of an SQL schema in one transaction; the file stays empty if it fails."""
    # This has an effect only while the file is empty.
    connection.execute("PRAGMA auto_vacuum = INCREMENTAL")
    connection.executescript(
        f"BEGIN; PRAGMA application_id = {APPLICATION_ID}; PRAGMA user_version = {FORMAT};"
        f"{schema} COMMIT;"
    )


def _check(connection: sqlite3.Connection, schema: str) -> None:
    """Raise `ResultFileError` unless a file is a result file of this format, and undamaged.

    Parameters
    ----------
    schema : the SQL that creates such a file; the file must have exactly the same tables
    """
    if connection.execute("PRAGMA application_id").fetchone()[0] != APPLICATION_ID:
        raise ResultFileError("not a result file of spincheck")
    version = connection.execute("PRAGMA user_version").fetchone()[0]
    if version != FORMAT:
        remedy = (
            "move it away, and start that 'spincheck run' again, which makes its results anew"
            if version < FORMAT
            else "a newer spincheck reads it"
        )
        raise ResultFileError(
            f"result file format {version}, this version has format {FORMAT}: {remedy}"
        )
    if _digest_of(connection) != _digest_of_tables(schema):
        raise ResultFileError(f"its schema is not that of a result file of format {version}")
    # Damage is reported here rather than in the middle of a report.
    first_damage = connection.execute("PRAGMA quick_check(1)").fetchone()[0]
    if first_damage != "ok":
        raise ResultFileError(f"damaged: {printable(first_damage)}")


def _digest_of(connection: sqlite3.Connection) -> str:
    """Return the SHA-256 of a file's schema: type, name, table and SQL text of all objects."""
    query = "SELECT type, name, tbl_name, sql FROM sqlite_master"
    objects = sorted([*map(str, columns)] for columns in connection.execute(query))
    return sha256(json.dumps(objects).encode()).hexdigest()


def _text(content: bytes) -> str:
    """Return the text of bytes in a schema; bytes that are not UTF-8 are escaped."""
    return content.decode(errors="backslashreplace")


@cache
def _digest_of_tables(schema: str) -> str:
    """Return the digest (`_digest_of`) of a file that is created by the SQL of a schema."""
    with closing(sqlite3.connect(":memory:")) as connection:
        connection.executescript(schema)
        return _digest_of(connection)
