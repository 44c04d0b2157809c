"""A connection to a result file that several threads share."""

import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from threading import RLock
from typing import Any


class Database:
    """Queries and transactions, one at a time."""

    def __init__(self, connection: sqlite3.Connection) -> None:
        connection.row_factory = sqlite3.Row
        self._connection = connection
        self._one_at_a_time = RLock()

    @contextmanager
    def transaction(self) -> Iterator[sqlite3.Connection]:
        """All of what is written in here, or none of it."""
        with self._one_at_a_time, self._connection:
            yield self._connection

    def query(self, text: str, values: Sequence[Any] = ()) -> list[sqlite3.Row]:
        """All rows of a query."""
        with self._one_at_a_time:
            return self._connection.execute(text, values).fetchall()
