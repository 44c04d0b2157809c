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

#: Of its tables, as `result_file.digest_of` gives it.
SCHEMA_DIGEST = "d557e638327efe5c879987229a7de5c3dc42c60ee5ea27057999361c85f3ac2e"

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


def _columns(old: Columns, key: tuple[str, ...] = _KEY) -> Columns:
    """A record with the columns of its key, and all others but blobs as one JSON object."""
    content = {
        _RENAMED.get(name, name): _value(name, value, _JSON)
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
