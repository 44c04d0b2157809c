"""Result files changed by hand, as whoever sends one can: with checksums that fit, or without."""

import sqlite3
from contextlib import closing
from pathlib import Path

from spincheck.reports.results.checksum import CHECKSUM, checksum
from spincheck.reports.results.database import shown


def columns(path: Path) -> list[tuple[str, str]]:
    """Table and column of everything that a file holds; checksums left out."""
    with closing(sqlite3.connect(path)) as connection:
        names = connection.execute("SELECT name FROM sqlite_master WHERE type = 'table'").fetchall()
        return [
            (table, row[1])
            for (table,) in names
            if connection.execute(f"SELECT count(*) FROM {table}").fetchone()[0]
            for row in connection.execute(f"PRAGMA table_info({table})")
            if row[1] != CHECKSUM
        ]


def change(path: Path, places: list[tuple[str, str]], value: object) -> None:
    """Put a value into columns, in the first record of each table, and leave the checksums."""
    with closing(sqlite3.connect(path)) as connection, connection:
        for table, column in places:
            connection.execute(
                f'UPDATE {table} SET "{column}" = ? WHERE rowid = (SELECT min(rowid) FROM {table})',
                (value,),
            )


def forge(path: Path, places: list[tuple[str, str]], value: object) -> None:
    """The same, with the checksums that belong to it."""
    change(path, places, value)
    seal(path)


def seal(path: Path) -> None:
    """Compute the checksum of every record anew."""
    with closing(sqlite3.connect(path)) as connection, connection:
        connection.row_factory = sqlite3.Row
        # As a reader sees it.
        connection.text_factory = lambda content: shown(content.decode(errors="backslashreplace"))
        for table in sorted({table for table, _ in columns(path)} - {"file"}):
            for record in connection.execute(f"SELECT rowid AS at, * FROM {table}").fetchall():
                content = {name: value for name, value in dict(record).items() if name != "at"}
                connection.execute(
                    f"UPDATE {table} SET {CHECKSUM} = ? WHERE rowid = ?",
                    (checksum(table, content), record["at"]),
                )
