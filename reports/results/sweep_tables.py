"""Sweeps in a result file: what was asked for, and every point as soon as it is there."""

import json
import sqlite3
from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import asdict
from typing import Any, NamedTuple

from ...scenarios import Errors, Scenario, loads
from .database import Database
from .records import Key
from .sweep_records import (
    Axis,
    Ensemble,
    EnsembleResult,
    Map,
    MapResult,
    PointResult,
    SweepPoint,
    sweep_points,
)
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


class StoredPoint(NamedTuple):
    """What tells whether a point has to be run: its identity, the method, and how it ended."""

    identity: str
    engine: str
    method: str
    cause: str
    reason: str


class SweepTables:
    """The sweeps of an open result file."""

    def __init__(self, database: Database) -> None:
        self._database = database

    def put(self, asked: Map | Ensemble, scenario: Scenario) -> None:
        """Record what is asked for."""
        values = (scenario.name, type(asked).__name__, json.dumps(asdict(asked)), scenario.text)
        with self._database.transaction() as connection:
            connection.execute("INSERT OR REPLACE INTO sweeps VALUES (?, ?, ?, ?)", values)

    def put_points(self, place: SweepPoint, points: Iterable[PointResult]) -> None:
        """Record points of one place."""
        records = [_record(place, point) for point in points]
        columns = ", ".join(records[0])
        marks = ", ".join(f":{name}" for name in records[0])
        with self._database.transaction() as connection:
            connection.executemany(
                f"INSERT OR REPLACE INTO points ({columns}) VALUES ({marks})", records
            )

    def stored(self, scenario: str) -> Iterator[StoredPoint]:
        """What there is of a scene's points, whichever sweep asked for it."""
        query = "SELECT place, engine, method, cause, reason FROM points WHERE scenario = ?"
        for record in self._database.query(query, (scenario,)):
            yield StoredPoint(*record)

    def points(self, asked: Map | Ensemble) -> tuple[PointResult, ...]:
        """The points there are, in the order of the places."""
        query = "SELECT * FROM points WHERE scenario = ? ORDER BY engine, method"
        found: dict[str, list[sqlite3.Row]] = defaultdict(list)
        for record in self._database.query(query, (asked.scenario,)):
            found[record["place"]].append(record)
        return tuple(
            _point(place, record)
            for place in sweep_points(asked)
            for record in found[place.identity]
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
        records = self._database.query(query, (kind.__name__,))
        return [(json.loads(r["asked"]), loads(r["toml"], r["scenario"])) for r in records]


def _record(place: SweepPoint, point: PointResult) -> dict[str, Any]:
    return {
        **asdict(point.key),
        "place": place.identity,
        **{name: getattr(point, name) for name in _PLAIN},
        "errors": json.dumps(asdict(point.errors)) if point.errors else None,
    }


@told
def _point(place: SweepPoint, record: sqlite3.Row) -> PointResult:
    return PointResult(
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
