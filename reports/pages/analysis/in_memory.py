"""Tables in memory that answer questions in SQL (https://sqlite.org/inmemorydb.html)."""

import sqlite3
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from statistics import median, median_high
from typing import Any
from weakref import finalize


class Tables:
    """Tables that are filled once, and queried in SQL with the aggregates `median`, `median_high`.

    If two values are in the middle, `median` is their mean, and `median_high` is the larger one.
    Infinite errors and costs are written as 9e999 in queries.

    Parameters
    ----------
    lines : the rows of each table; its key is the name of the table followed by the names of its
        columns, such as ``run (scene, engine)``
    views : SQL statements that define views
    """

    def __init__(self, lines: Mapping[str, Iterable[tuple[Any, ...]]], views: str = "") -> None:
        self._connection = sqlite3.connect(":memory:")
        finalize(self, self._connection.close)
        for of in (median, median_high):
            self._connection.create_aggregate(of.__name__, 1, partial(_Aggregate, of))  # type: ignore[arg-type]
        for table, of_table in lines.items():
            self._connection.execute(f"CREATE TABLE {table}")
            marks = ", ".join("?" * (table.count(",") + 1))
            name = table.partition(" ")[0]
            self._connection.executemany(f"INSERT INTO {name} VALUES ({marks})", of_table)
        self._connection.executescript(views)

    def ask(self, question: str, *values: Any) -> list[Any]:
        """Return the rows that an SQL query selects, with `values` for its question marks."""
        return self._connection.execute(question, values).fetchall()


class _Aggregate:
    """An SQL aggregate: a statistic of the numbers that are not NULL; NULL if all are.

    The method names are those that `sqlite3` calls.
    """

    def __init__(self, of: Callable[[list[float]], float]) -> None:
        self._of = of
        self._values: list[float] = []

    def step(self, value: float | None) -> None:
        """Take the next value into account; None, which stands for NULL, is ignored."""
        if value is not None:
            self._values.append(value)

    def finalize(self) -> float | None:
        """Return the statistic of the values; None if there are none."""
        return self._of(self._values) if self._values else None
