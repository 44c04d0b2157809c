"""Sweeps in a result file: what was asked for, and every point as soon as it is there."""

import json
import sqlite3
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import asdict
from typing import Any

from ...scenarios import Errors, Scenario, loads
from ..harness.executors.worker_slot import may_end_otherwise
from ..harness.sweep_points import Place, places
from .records import Key
from .sweep_records import Axis, Ensemble, EnsembleResult, Map, MapResult, Point
from .table_records import told

SCHEMA = """
-- A Map or an Ensemble, as JSON, and the scene that is varied.
CREATE TABLE sweeps (
    scenario TEXT, kind TEXT, asked TEXT, toml TEXT NOT NULL,
    PRIMARY KEY (scenario, kind, asked));
-- A place is known by what is different there, as JSON: two maps that share it share its points.
-- Engine and method are empty where it has no scene.
CREATE TABLE points (
    scenario TEXT, place TEXT, engine TEXT, method TEXT, timestep REAL NOT NULL,
    outcome TEXT NOT NULL, cause TEXT NOT NULL, reason TEXT NOT NULL, stopped_at REAL,
    errors TEXT, uncertainty REAL NOT NULL, steps INTEGER NOT NULL,
    PRIMARY KEY (scenario, place, engine, method));
"""
#: Engine and method of the point of a place that has no scene.
NO_SCENE = ("", "")
_PLAIN = (
    "timestep",
    "outcome",
    "cause",
    "reason",
    "stopped_at",
    "uncertainty",
    "steps",
)


class SweepTables:
    """The sweeps of an open result file."""

    def __init__(self, connection: sqlite3.Connection) -> None:
        self._connection = connection

    def put(self, asked: Map | Ensemble, scenario: Scenario) -> None:
        """Record what is asked for."""
        values = (scenario.name, type(asked).__name__, json.dumps(asdict(asked)), scenario.text)
        with self._connection:
            self._connection.execute("INSERT OR REPLACE INTO sweeps VALUES (?, ?, ?, ?)", values)

    def put_points(self, place: Place, points: Iterable[Point]) -> None:
        """Record points of one place."""
        records = [_record(place, point) for point in points]
        columns = ", ".join(records[0])
        marks = ", ".join(f":{name}" for name in records[0])
        with self._connection:
            self._connection.executemany(
                f"INSERT OR REPLACE INTO points ({columns}) VALUES ({marks})", records
            )

    def there(
        self, scenario: str, time_limit: float | None = None
    ) -> dict[str, set[tuple[str, str]]]:
        """Engines and methods of the points there are of a scene, by what places are known by.

        Those that somebody killed, or that a lesser time limit stopped, are to be run again.
        """
        query = "SELECT place, engine, method, reason FROM points WHERE scenario = ?"
        found: dict[str, set[tuple[str, str]]] = defaultdict(set)
        for place, engine, method, reason in self._connection.execute(query, (scenario,)):
            if not may_end_otherwise(reason, time_limit):
                found[place].add((engine, method))
        return found

    def points(self, asked: Map | Ensemble) -> tuple[Point, ...]:
        """The points there are, in the order of the places."""
        query = "SELECT * FROM points WHERE scenario = ? ORDER BY engine, method"
        found: dict[str, list[sqlite3.Row]] = defaultdict(list)
        for record in self._connection.execute(query, (asked.scenario,)):
            found[record["place"]].append(record)
        return tuple(
            _point(place, record) for place in places(asked) for record in found[place.known_by]
        )

    def maps(self) -> list[MapResult]:
        """Every map, with its points."""
        found = [(_map(asked), scenario) for asked, scenario in self._asked(Map)]
        return [MapResult(asked, scenario, self.points(asked)) for asked, scenario in found]

    def ensembles(self) -> list[EnsembleResult]:
        """Every ensemble, with its points."""
        found = [(Ensemble(**asked), scenario) for asked, scenario in self._asked(Ensemble)]
        return [EnsembleResult(asked, scenario, self.points(asked)) for asked, scenario in found]

    def _asked(self, kind: type) -> list[tuple[dict[str, Any], Scenario]]:
        query = "SELECT * FROM sweeps WHERE kind = ? ORDER BY scenario, asked"
        records = self._connection.execute(query, (kind.__name__,)).fetchall()
        return [(json.loads(r["asked"]), loads(r["toml"], r["scenario"])) for r in records]


def _record(place: Place, point: Point) -> dict[str, Any]:
    return {
        **asdict(point.key),
        "place": place.known_by,
        **{name: getattr(point, name) for name in _PLAIN},
        "errors": json.dumps(asdict(point.errors)) if point.errors else None,
    }


@told
def _point(place: Place, record: sqlite3.Row) -> Point:
    return Point(
        at=place.at,
        key=Key(record["scenario"], record["engine"], record["method"]),
        errors=Errors(**json.loads(record["errors"])) if record["errors"] else None,
        **{name: record[name] for name in _PLAIN},
    )


@told
def _map(asked: dict[str, Any]) -> Map:
    first, second = (
        Axis(axis["path"], tuple(axis["values"]), axis["logarithmic"]) for axis in asked["axes"]
    )
    return Map(asked["scenario"], (first, second), asked["timestep"])
