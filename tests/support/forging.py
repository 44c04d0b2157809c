"""Result files changed by hand, as whoever sends one can: with checksums that fit, or without."""

import json
import sqlite3
from contextlib import closing
from pathlib import Path

from spincheck.reports.results.database import CHECKSUM, checksum, shown

#: Before a field of the JSON in a column.
FIELD = "record."


def columns(path: Path) -> list[tuple[str, str]]:
    """Table and column of everything that a file holds, JSON field by field; no checksums."""
    with closing(sqlite3.connect(path)) as connection:
        connection.row_factory = sqlite3.Row
        places = []
        for table in tables(path):
            if first := connection.execute(f"SELECT * FROM {table}").fetchone():
                columns_of = first.keys()
                fields = json.loads(first["record"]) if "record" in columns_of else {}
                names = [*(f"{FIELD}{name}" for name in fields), *columns_of]
                places += [(table, name) for name in names if name != CHECKSUM]
        return places


def tables(path: Path) -> list[str]:
    """The names of a file's tables."""
    with closing(sqlite3.connect(path)) as connection:
        query = "SELECT name FROM sqlite_master WHERE type = 'table'"
        return [name for (name,) in connection.execute(query)]


def _opened(path: Path) -> sqlite3.Connection:
    """A connection that waits for no disk: nobody needs the file after a power cut."""
    connection = sqlite3.connect(path)
    connection.execute("PRAGMA synchronous = OFF")
    return connection


def change(path: Path, places: list[tuple[str, str]], value: object) -> None:
    """Put a value into columns, in the first record of each table, and leave the checksums."""
    with closing(_opened(path)) as connection, connection:
        for table, place in places:
            column, changed = place, value
            first = f"WHERE rowid = (SELECT min(rowid) FROM {table})"
            if place.startswith(FIELD):
                (text,) = connection.execute(f"SELECT record FROM {table} {first}").fetchone()
                in_json = value.decode("latin1") if isinstance(value, bytes) else value
                changed = json.dumps(json.loads(text) | {place.removeprefix(FIELD): in_json})
                column = "record"
            connection.execute(f'UPDATE {table} SET "{column}" = ? {first}', (changed,))


def forge(path: Path, places: list[tuple[str, str]], value: object) -> None:
    """The same, with the checksums that belong to it."""
    change(path, places, value)
    seal(path)


def seal(path: Path) -> None:
    """Compute the checksum of every record anew."""
    with closing(_opened(path)) as connection, connection:
        connection.row_factory = sqlite3.Row
        # As a reader sees it.
        connection.text_factory = lambda content: shown(content.decode(errors="backslashreplace"))
        for table in sorted({*tables(path)} - {"file"}):
            for record in connection.execute(f"SELECT rowid AS at, * FROM {table}").fetchall():
                content = {name: value for name, value in dict(record).items() if name != "at"}
                connection.execute(
                    f"UPDATE {table} SET {CHECKSUM} = ? WHERE rowid = ?",
                    (checksum(table, content), record["at"]),
                )
