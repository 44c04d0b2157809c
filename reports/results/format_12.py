"""Reads result files of format 12, whose tables had a column for each field.

They are converted in memory, record by record, after their checksums have been compared; what they
did not hold is absent, and every value is checked when it is read, as of any file.
"""

import json
import sqlite3
from collections.abc import Iterator
from typing import Any

from .database import Database, put
from .result_file import OpenFile
from .tables import DIGEST, TABLES, as_result_file_error

SCHEMA = """
CREATE TABLE environment (
    name TEXT PRIMARY KEY, value TEXT NOT NULL, checksum TEXT NOT NULL);
CREATE TABLE methods (
    engine TEXT, method TEXT, "order" INTEGER NOT NULL, attitude_order INTEGER NOT NULL,
    summary TEXT NOT NULL, effects TEXT NOT NULL, requires TEXT NOT NULL,
    max_rotation_per_step REAL NOT NULL, as_shipped INTEGER NOT NULL, stock_timestep REAL,
    checksum TEXT NOT NULL, PRIMARY KEY (engine, method));
CREATE TABLE fingerprints (
    scenario TEXT, engine TEXT, digest TEXT NOT NULL, checksum TEXT NOT NULL,
    PRIMARY KEY (scenario, engine));
CREATE TABLE scenes (
    scenario TEXT PRIMARY KEY, digest TEXT NOT NULL, toml TEXT NOT NULL, method TEXT NOT NULL,
    uncertainty TEXT NOT NULL, conditioning TEXT NOT NULL, horizon REAL, truth BLOB NOT NULL,
    checksum TEXT NOT NULL);
CREATE TABLE rows (
    scenario TEXT, engine TEXT, method TEXT, timestep REAL, engine_version TEXT NOT NULL,
    outcome TEXT NOT NULL, reason TEXT NOT NULL, cause TEXT NOT NULL, lost INTEGER NOT NULL,
    stock INTEGER NOT NULL, unasked TEXT NOT NULL, stopped_at REAL, errors TEXT, drifts TEXT,
    uncertainty REAL NOT NULL, steps INTEGER NOT NULL, motion BLOB, printed TEXT NOT NULL,
    checksum TEXT NOT NULL, PRIMARY KEY (scenario, engine, method, timestep));
CREATE TABLE costs (
    scenario TEXT, engine TEXT, method TEXT, processor TEXT NOT NULL, seconds_per_step REAL,
    seconds_spread REAL, wall_seconds_per_step REAL, checksum TEXT NOT NULL,
    PRIMARY KEY (scenario, engine, method));
CREATE TABLE left_out (
    scenario TEXT, engine TEXT, method TEXT, kind TEXT, record TEXT NOT NULL,
    checksum TEXT NOT NULL, PRIMARY KEY (scenario, engine, method, kind));
CREATE TABLE default_effects (
    scenario TEXT, engine TEXT, method TEXT, record TEXT NOT NULL, checksum TEXT NOT NULL,
    PRIMARY KEY (scenario, engine, method));
CREATE TABLE verdicts (
    scenario TEXT, engine TEXT, method TEXT, timesteps TEXT, verdict TEXT NOT NULL,
    reason TEXT NOT NULL, signal TEXT NOT NULL, "order" REAL, limit_error REAL,
    tolerance REAL, signals TEXT NOT NULL, unmet TEXT NOT NULL, as_shipped INTEGER NOT NULL,
    known INTEGER NOT NULL, step_limit INTEGER, checksum TEXT NOT NULL,
    PRIMARY KEY (scenario, engine, method, timesteps));
CREATE TABLE sweeps (
    scenario TEXT, kind TEXT, asked TEXT, toml TEXT NOT NULL, checksum TEXT NOT NULL,
    PRIMARY KEY (scenario, kind, asked));
CREATE TABLE points (
    scenario TEXT, place TEXT, engine TEXT, method TEXT, timestep REAL NOT NULL,
    outcome TEXT NOT NULL, cause TEXT NOT NULL, reason TEXT NOT NULL, stopped_at REAL,
    errors TEXT, uncertainty REAL NOT NULL, steps INTEGER NOT NULL, checksum TEXT NOT NULL,
    PRIMARY KEY (scenario, place, engine, method));
"""

Columns = dict[str, Any]

_KEY = ("scenario", "engine", "method", "timestep")
_JSON = ("errors", "drifts", "unasked", "signals", "unmet", "uncertainty", "conditioning")
_JSON_OF_METHODS = ("effects", "requires")
_TRUE_OR_FALSE = ("lost", "stock", "as_shipped", "known")
_RENAMED = {"lost": "without_skill", "known": "expected_failure"}
_COST = ("seconds_per_step", "seconds_spread", "wall_seconds_per_step")


def converted(file: OpenFile, schema: str) -> OpenFile:
    """The file with its records in the tables of the present format, in memory.

    Parameters
    ----------
    schema : of the present format
    """
    connection = sqlite3.connect(":memory:", check_same_thread=False)
    connection.executescript(schema)
    undated = {table.name for table in TABLES if table.rests_on}
    for table, columns in _records(Database(file.connection, file.check)):
        put(connection, table, columns | ({DIGEST: ""} if table in undated else {}))
    return file._replace(connection=connection)


@as_result_file_error
def _records(old: Database) -> list[tuple[str, Columns]]:
    """Table and columns of every record, as they are stored now."""

    def each(table: str) -> Iterator[Columns]:
        for record in map(dict, old.select(table)):
            del record["checksum"]
            yield record

    kinds = {"EffectsCost": "effects_costs", "PassCosts": "pass_costs"}
    return [
        *(("environment", _columns(one, ("name",))) for one in each("environment")),
        *(("engines", one) for one in _engines(each("methods"))),
        *(("scenes", _scene(one)) for one in each("scenes")),
        *(("rows", _row(one)) for one in each("rows")),
        *(("verdicts", _verdict(one)) for one in each("verdicts")),
        *(("costs", _cost(one)) for one in each("costs")),
        *((kinds[one.pop("kind")], one) for one in each("left_out")),
        *(("default_effects", one) for one in each("default_effects")),
        *(("sweeps", _sweep(one)) for one in each("sweeps")),
        *(("points", _point(one)) for one in each("points")),
    ]


def _columns(
    old: Columns, key: tuple[str, ...] = _KEY, json_columns: tuple[str, ...] = _JSON
) -> Columns:
    """A record with the columns of its key, and all others but blobs as one JSON object."""
    content = {
        _RENAMED.get(name, name): _value(name, value, json_columns)
        for name, value in old.items()
        if name not in key and value is not None
    }
    return {name: old[name] for name in key if name in old} | {"record": json.dumps(content)}


def _value(name: str, value: Any, json_columns: tuple[str, ...]) -> Any:
    if name in json_columns:
        return json.loads(value)
    return bool(value) if name in _TRUE_OR_FALSE else value


def _engines(methods: Iterator[Columns]) -> Iterator[Columns]:
    """What each engine declares; format 12 had a record for each of its methods."""
    engines: dict[str, Columns] = {}
    for old in methods:
        name, timestep = old.pop("engine"), old.pop("stock_timestep")
        engine = engines.setdefault(name, {"methods": [], "stock_timestep": timestep})
        declared = {n: _value(n, value, _JSON_OF_METHODS) for n, value in old.items()}
        engine["methods"].append({"name": declared.pop("method")} | declared)
    for name, engine in engines.items():
        yield {"name": name, "record": json.dumps(engine)}


def _scene(old: Columns) -> Columns:
    del old["digest"]
    trajectory = old.pop("truth")
    return _columns(old, ("scenario",)) | {"trajectory": trajectory}


def _row(old: Columns) -> Columns:
    motion = old.pop("motion")
    old["reference_uncertainty"] = old.pop("uncertainty")
    return _columns(old) | {"motion": motion}


def _verdict(old: Columns) -> Columns:
    timesteps = [float(text) for text in old.pop("timesteps").split()]
    return _columns(old) | {"timesteps": json.dumps(timesteps)}


def _sweep(old: Columns) -> Columns:
    sweep = json.loads(old["asked"])
    return _columns({"scenario": old["scenario"], "toml": old["toml"]}) | {
        "sweep": json.dumps(sweep | {"scenario": old["scenario"]})
    }


def _point(old: Columns) -> Columns:
    old["reference_uncertainty"] = old.pop("uncertainty")
    # Found by its place, from which its coordinates are taken.
    old["at"] = []
    return _columns(old, ("scenario", "place", "engine", "method"))


def _cost(old: Columns) -> Columns:
    cost = {name: old.pop(name) for name in _COST}
    timed = None if cost["seconds_per_step"] is None else cost
    return _columns(old) | {"record": json.dumps({"processor": old["processor"], "cost": timed})}
