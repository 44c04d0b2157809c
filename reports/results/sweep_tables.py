"""Sweeps in a result file: their definitions, and every point as soon as it is run."""

import json
import math
import sqlite3
from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import asdict
from itertools import pairwise
from typing import Any, NamedTuple

from ...scenarios import Errors, Scenario, loads
from ...scenarios.vary import MAX_COUNT, Axis, check_path
from .column_values import as_result_file_error, from_json, scene_name, typed
from .database import Database, put
from .records import Key
from .sweep_records import (
    MAX_MEMBERS,
    MAX_SEED,
    TIMESTEP,
    Ensemble,
    EnsembleResult,
    Map,
    MapResult,
    PointResult,
    SweepPoint,
    sweep_point,
)

SCHEMA = """
-- A Map or an Ensemble, as JSON, and the scene that is varied.
CREATE TABLE sweeps (
    scenario TEXT, kind TEXT, asked TEXT, toml TEXT NOT NULL, checksum TEXT NOT NULL,
    PRIMARY KEY (scenario, kind, asked));
-- A place is known by what is different there, as JSON: two maps that share it share its points.
-- Engine and method are empty where it has no scene.
CREATE TABLE points (
    scenario TEXT, place TEXT, engine TEXT, method TEXT, timestep REAL NOT NULL,
    outcome TEXT NOT NULL, cause TEXT NOT NULL, reason TEXT NOT NULL, stopped_at REAL,
    errors TEXT, uncertainty REAL NOT NULL, steps INTEGER NOT NULL, checksum TEXT NOT NULL,
    PRIMARY KEY (scenario, place, engine, method));
"""
#: Engine and method of the result at a point whose numbers make no scene.
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


_STORED = ("place", "engine", "method", "cause", "reason")


class StoredPoint(NamedTuple):
    """A stored result in short: the point's identity, the method, and how the run ended."""

    identity: str
    engine: str
    method: str
    cause: str
    reason: str


class SweepTables:
    """The sweeps of an open result file."""

    def __init__(self, database: Database) -> None:
        self._database = database

    def put(self, sweep: Map | Ensemble, scenario: Scenario) -> None:
        """Store the definition of a sweep."""
        record = {
            "scenario": scenario.name,
            "kind": type(sweep).__name__,
            "asked": json.dumps(asdict(sweep)),
            "toml": scenario.text,
        }
        with self._database.transaction() as connection:
            put(connection, "sweeps", record)

    def put_points(self, point: SweepPoint, results: Iterable[PointResult]) -> None:
        """Record the results at one point."""
        with self._database.transaction() as connection:
            for result in results:
                put(connection, "points", _record(point, result))

    def stored(self, scenario: str) -> Iterator[StoredPoint]:
        """The stored results of a scene's points, of all sweeps."""
        for record in self._database.select("points", "scenario = ?", (scenario,)):
            yield StoredPoint(*(record[name] for name in _STORED))

    def points(self, sweep: Map | Ensemble) -> tuple[PointResult, ...]:
        """The stored results of a sweep, in the order of its points."""
        return _results(sweep, self._database.select("points", "scenario = ?", (sweep.scenario,)))

    def read(self) -> tuple[list[MapResult], list[EnsembleResult]]:
        """Every map and every ensemble, with their points."""
        points: dict[str, list[sqlite3.Row]] = defaultdict(list)
        for record in self._database.select("points"):
            points[record["scenario"]].append(record)
        maps, ensembles = [], []
        for record in self._database.select("sweeps", order="scenario, asked"):
            sweep, scenario = _sweep(record), _scene(record)
            results = _results(sweep, points[scenario.name])
            if isinstance(sweep, Map):
                maps.append(MapResult(sweep, scenario, results))
            else:
                ensembles.append(EnsembleResult(sweep, scenario, results))
        return maps, ensembles


def _results(sweep: Map | Ensemble, records: Iterable[sqlite3.Row]) -> tuple[PointResult, ...]:
    """The results of a sweep among those of its scene, in the order of its points.

    It loops over the stored results, not over all points of the sweep: few may have been run.
    """
    results: dict[SweepPoint, list[PointResult]] = defaultdict(list)
    for record in records:
        if (point := _point(sweep, record)) is not None:
            results[point].append(_result(point, record))
    return tuple(
        result
        for point in sorted(results, key=lambda point: point.at)
        for result in sorted(results[point], key=lambda one: (one.key.engine, one.key.method))
    )


def _record(point: SweepPoint, result: PointResult) -> dict[str, Any]:
    return {
        **asdict(result.key),
        "place": point.identity,
        **{name: getattr(result, name) for name in _PLAIN},
        "errors": json.dumps(asdict(result.errors)) if result.errors else None,
    }


@as_result_file_error
def _point(sweep: Map | Ensemble, record: sqlite3.Row) -> SweepPoint | None:
    """The point of a sweep that a record belongs to; None if it belongs to another sweep only."""
    return sweep_point(sweep, from_json(record["place"], dict))


@as_result_file_error
def _result(point: SweepPoint, record: sqlite3.Row) -> PointResult:
    result = PointResult(
        at=point.at,
        key=typed(Key(scene_name(record), record["engine"], record["method"])),
        errors=typed(Errors(**from_json(record["errors"], dict))) if record["errors"] else None,
        **{name: record[name] for name in _PLAIN},
    )
    return typed(result)


@as_result_file_error
def _scene(record: sqlite3.Row) -> Scenario:
    return loads(record["toml"], scene_name(record))


@as_result_file_error
def _sweep(record: sqlite3.Row) -> Map | Ensemble:
    """The stored definition of a sweep, checked to be one that a user can ask for."""
    sweep = from_json(record["asked"], dict)
    if record["kind"] == Ensemble.__name__:
        return _ensemble(sweep, scene_name(record))
    if record["kind"] == Map.__name__:
        return _map(sweep, _scene(record))
    raise ValueError(f"a sweep of kind '{record['kind']}'")


def _map(sweep: dict[str, Any], scene: Scenario) -> Map:
    first, second = (
        typed(Axis(axis["path"], tuple(axis["values"]), axis["logarithmic"]))
        for axis in sweep["axes"]
    )
    for axis in (first, second):
        check_path(scene, axis.path)
        _check_axis(axis)
    if first.path == second.path:
        raise ValueError(f"{first.path}: varied twice")
    grid = typed(Map(scene.name, (first, second), sweep["timestep"]))
    _check_timestep(grid.timestep)
    return grid


def _ensemble(sweep: dict[str, Any], scene: str) -> Ensemble:
    ensemble = typed(Ensemble(**{**sweep, "scenario": scene}))
    if not (0 < ensemble.members <= MAX_MEMBERS and 0 <= ensemble.seed <= MAX_SEED):
        raise ValueError(f"an ensemble of {ensemble.members} members and seed {ensemble.seed}")
    _check_timestep(ensemble.timestep)
    return ensemble


def _check_axis(axis: Axis) -> None:
    """See that an axis is one that `parse_axis` makes."""
    values, positive = axis.values, axis.logarithmic or axis.path == TIMESTEP
    if not 2 <= len(values) <= MAX_COUNT:
        raise ValueError(f"{axis.path}: {len(values)} values")
    if not (
        all(a < b for a, b in pairwise(values)) and -math.inf < values[0] <= values[-1] < math.inf
    ):
        raise ValueError(f"{axis.path}: its values do not increase")
    if positive and values[0] <= 0:
        raise ValueError(f"{axis.path}: {values[0]:g} is not positive")


def _check_timestep(timestep: float | None) -> None:
    if timestep is not None and not 0 < timestep < math.inf:
        raise ValueError(f"timestep: {timestep:g} s")
