"""A connection to a result file that several threads share; records are mappings by column name.

Every record has a checksum (`checksum`). It detects accidental changes, but it is no signature:
whoever forges a record can compute its checksum. Control characters in texts are escaped when they
are written and when they are read, so that no text in a result file controls a terminal.
"""

import json
import math
import sqlite3
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from hashlib import sha256
from threading import RLock
from typing import Any

from ...scenarios import printable
from .result_file import ResultFileError

#: Name of the checksum's column, in every table.
CHECKSUM = "checksum"


def checksum(table: str, record: Mapping[str, Any]) -> str:
    """Return the SHA-256, hexadecimal, of the texts and numbers that SQLite stores of a record.

    Motions are left out: they may be dropped later, and their archives have checksums of their own
    (CRC-32, as in every zip file).

    Parameters
    ----------
    table : name of the table
    record : the values, by column
    """
    content = {
        name: _as_stored(value)
        for name, value in record.items()
        if name != CHECKSUM and value is not None and not isinstance(value, bytes)
    }
    # SQLite keeps an infinity or a NaN as NULL.
    content = {name: value for name, value in content.items() if value is not None}
    return sha256(json.dumps([table, content], sort_keys=True).encode()).hexdigest()


def _as_stored(value: Any) -> str | float | None:
    """Return a value as SQLite would return it: NaN as None, −0 as 0, other numbers as floats."""
    if isinstance(value, str):
        return value
    number = float(value) + 0.0
    return None if math.isnan(number) else number


class Database:
    """A connection to a result file that makes queries and transactions, one at a time.

    Parameters
    ----------
    connection : SQLite's connection to a result file
    check : called before every commit; raises if the file was removed or replaced
    """

    def __init__(
        self, connection: sqlite3.Connection, check: Callable[[], None] = lambda: None
    ) -> None:
        connection.row_factory = sqlite3.Row
        connection.text_factory = _text
        self._connection = connection
        self._check = check
        self._one_at_a_time = RLock()

    @contextmanager
    def transaction(self) -> Iterator[sqlite3.Connection]:
        """Yield the connection; store all that the block writes, or nothing if the block raises."""
        with self._one_at_a_time, self._connection:
            yield self._connection
            # This writes the page with the session's name into the log, so that every log shows to
            # which file it belongs (`result_file._check_log`).
            self._connection.execute("UPDATE file SET commits = commits + 1")
            self._check()

    def select(
        self, table: str, where: str = "TRUE", values: Sequence[Any] = (), order: str = "rowid"
    ) -> list[sqlite3.Row]:
        """Return the records of a table that a condition selects.

        Parameters
        ----------
        table : name of the table
        where : the condition, in SQL
        values : values of the condition's parameters, its question marks
        order : what the records are sorted by, in SQL

        Raises
        ------
        ResultFileError
            If a record was changed after it was written.
        """
        query = f"SELECT * FROM {table} WHERE {where} ORDER BY {order}"
        with self._one_at_a_time:
            records = self._connection.execute(query, values).fetchall()
        for record in records:
            if record[CHECKSUM] != checksum(table, dict(record)):
                raise ResultFileError(
                    f"a record was changed after it was written (its checksum differs): "
                    f"'{table}', {_named(record)}"
                )
        return records


def put(connection: sqlite3.Connection, table: str, record: Mapping[str, Any]) -> None:
    """Write a record, with its checksum, into a table; a record with the same key is replaced.

    Parameters
    ----------
    table : name of the table
    record : the values of the record, by column
    """
    written = {n: shown(value) if isinstance(value, str) else value for n, value in record.items()}
    written[CHECKSUM] = checksum(table, written)
    columns = ", ".join(f'"{name}"' for name in written)
    marks = ", ".join(f":{name}" for name in written)
    connection.execute(f"INSERT OR REPLACE INTO {table} ({columns}) VALUES ({marks})", written)


def shown(text: str) -> str:
    """Return a text with its control characters escaped, except tabs and line ends."""
    if text.isprintable():
        return text
    lines = ("\t".join(map(printable, line.split("\t"))) for line in text.split("\n"))
    return "\n".join(lines)


def _text(content: bytes) -> str:
    """Return the text of bytes from a result file; bytes that are not UTF-8 are escaped."""
    return shown(content.decode(errors="backslashreplace"))


def _named(record: sqlite3.Row) -> str:
    """Return the first three values of a record as one text, which identifies it in a message."""
    return printable(", ".join(str(value) for value in tuple(record)[:3]), 100)
