"""The result file: SQLite, each row written as its run ends."""

import io
import json
import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..reference import Solution
from ..scenarios import Errors, Scenario, Trajectory, loads
from .records import Key, Row, Verdict

#: "spin" in ASCII: tells a result file from any other SQLite database.
APPLICATION_ID = 0x7370696E
FORMAT = 1

_SCHEMA = """
CREATE TABLE environment (name TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE scenes (
    name TEXT PRIMARY KEY, digest TEXT NOT NULL, toml TEXT NOT NULL, method TEXT NOT NULL,
    uncertainty TEXT NOT NULL, conditioning TEXT NOT NULL, horizon REAL, truth BLOB NOT NULL);
CREATE TABLE rows (
    scenario TEXT, engine TEXT, method TEXT, timestep REAL, engine_version TEXT NOT NULL,
    outcome TEXT NOT NULL, reason TEXT NOT NULL, stopped_at REAL, errors TEXT, drifts TEXT,
    uncertainty REAL NOT NULL, steps INTEGER NOT NULL, seconds_per_step REAL, seconds_spread REAL,
    motion BLOB, printed TEXT NOT NULL, PRIMARY KEY (scenario, engine, method, timestep));
CREATE TABLE verdicts (
    scenario TEXT, engine TEXT, method TEXT, verdict TEXT NOT NULL, reason TEXT NOT NULL,
    signal TEXT NOT NULL, "order" REAL, limit_error REAL, limit_estimate REAL,
    broken TEXT NOT NULL, as_shipped INTEGER NOT NULL, PRIMARY KEY (scenario, engine, method));
"""


class ResultFileError(ValueError):
    """A result file is missing, not one of ours, or of another format version."""


@dataclass(frozen=True, eq=False)
class SceneResult:
    """A scene as it was simulated, and its truth at the sample times."""

    scenario: Scenario
    solution: Solution


@dataclass(frozen=True, eq=False)
class Results:
    """Everything a report is made from."""

    environment: dict[str, str]
    scenes: dict[str, SceneResult]
    rows: list[Row]
    verdicts: list[Verdict]


class Store:
    """An open result file."""

    def __init__(self, connection: sqlite3.Connection) -> None:
        self._connection = connection

    def put_environment(self, environment: dict[str, str]) -> None:
        """Record machine and versions."""
        self._insert_many("environment", [{"name": k, "value": v} for k, v in environment.items()])

    def put_scene(self, scenario: Scenario, solution: Solution) -> None:
        """Record a scene and its truth, in place of all that was known of a scene of that name."""
        for table, column in (("scenes", "name"), ("rows", "scenario"), ("verdicts", "scenario")):
            self._connection.execute(f"DELETE FROM {table} WHERE {column} = ?", (scenario.name,))
        record = {
            "name": scenario.name,
            "digest": scenario.digest,
            "toml": scenario.text,
            "method": solution.method,
            "uncertainty": json.dumps(asdict(solution.uncertainty)),
            "conditioning": json.dumps(asdict(solution.conditioning)),
            "horizon": solution.horizon,
            "truth": _pack(solution.trajectory),
        }
        self._insert_many("scenes", [record])

    def put_row(self, row: Row) -> None:
        """Record a run."""
        record: dict[str, Any] = {name: getattr(row, name) for name in _PLAIN_ROW} | asdict(row.key)
        record["errors"] = json.dumps(asdict(row.errors)) if row.errors else None
        record["drifts"] = json.dumps(row.drifts) if row.drifts is not None else None
        record["motion"] = _pack(row.motion) if row.motion is not None else None
        self._insert_many("rows", [record])

    def put_cost(self, key: Key, seconds_per_step: float, seconds_spread: float) -> None:
        """Record what a step of a method costs on a scene, in all its rows."""
        with self._connection:
            self._connection.execute(
                "UPDATE rows SET seconds_per_step = ?, seconds_spread = ? "
                "WHERE scenario = ? AND engine = ? AND method = ?",
                (seconds_per_step, seconds_spread, key.scenario, key.engine, key.method),
            )

    def put_verdict(self, verdict: Verdict) -> None:
        """Record a verdict."""
        record = {name: getattr(verdict, name) for name in _PLAIN_VERDICT} | asdict(verdict.key)
        record["broken"] = json.dumps(verdict.broken)
        record["as_shipped"] = verdict.as_shipped
        self._insert_many("verdicts", [record])

    def read(self) -> Results:
        """Everything in the file.

        Raises
        ------
        ResultFileError
            If a record cannot be read.
        """
        try:
            return Results(
                environment={r["name"]: r["value"] for r in self._select("environment", "name")},
                scenes={r["name"]: _scene(r) for r in self._select("scenes", "name")},
                rows=[_row(r) for r in self._select("rows", "scenario, engine, method, -timestep")],
                verdicts=[
                    _verdict(r) for r in self._select("verdicts", "scenario, engine, method")
                ],
            )
        except (sqlite3.DatabaseError, ValueError, KeyError, IndexError) as error:
            raise ResultFileError(f"a record cannot be read: {error}") from error

    def _select(self, table: str, order: str) -> list[sqlite3.Row]:
        return self._connection.execute(f"SELECT * FROM {table} ORDER BY {order}").fetchall()

    def _insert_many(self, table: str, records: list[dict[str, Any]]) -> None:
        if not records:
            return
        columns = ", ".join(f'"{name}"' for name in records[0])
        marks = ", ".join(f":{name}" for name in records[0])
        with self._connection:
            self._connection.executemany(
                f"INSERT OR REPLACE INTO {table} ({columns}) VALUES ({marks})", records
            )


_PLAIN_ROW = (
    "engine_version",
    "timestep",
    "outcome",
    "reason",
    "stopped_at",
    "uncertainty",
    "steps",
    "seconds_per_step",
    "seconds_spread",
    "printed",
)
_PLAIN_VERDICT = ("verdict", "reason", "signal", "order", "limit_error", "limit_estimate")


@contextmanager
def open_store(path: Path, *, create: bool = False) -> Iterator[Store]:
    """Open a result file, and with `create` begin one where there is none.

    Raises
    ------
    ResultFileError
        If the file is missing, cannot be opened, or is not a result file of this format.
    """
    new = not path.exists()
    if new and not create:
        raise ResultFileError(f"{path}: no such result file; 'spincheck run' writes one")
    try:
        with closing(sqlite3.connect(path)) as connection:
            connection.row_factory = sqlite3.Row
            _begin(connection) if new else _check(connection)
            yield Store(connection)
    except sqlite3.DatabaseError as error:
        raise ResultFileError(f"{path}: not a usable result file: {error}") from error
    except ResultFileError as error:
        raise ResultFileError(f"{path}: {error}") from error


def _begin(connection: sqlite3.Connection) -> None:
    connection.execute("PRAGMA journal_mode = WAL")
    connection.execute(f"PRAGMA application_id = {APPLICATION_ID}")
    connection.execute(f"PRAGMA user_version = {FORMAT}")
    connection.executescript(_SCHEMA)


def _check(connection: sqlite3.Connection) -> None:
    if connection.execute("PRAGMA application_id").fetchone()[0] != APPLICATION_ID:
        raise ResultFileError("not a result file of spincheck")
    version = connection.execute("PRAGMA user_version").fetchone()[0]
    if version != FORMAT:
        raise ResultFileError(f"result file format {version}, this version reads {FORMAT}")


def _scene(record: sqlite3.Row) -> SceneResult:
    scenario = loads(record["toml"], record["name"])
    solution = Solution(
        trajectory=_unpack(record["truth"]),
        method=record["method"],
        uncertainty=Errors(**json.loads(record["uncertainty"])),
        conditioning=Errors(**json.loads(record["conditioning"])),
        horizon=record["horizon"],
    )
    return SceneResult(scenario, solution)


def _row(record: sqlite3.Row) -> Row:
    return Row(
        key=_key(record),
        errors=Errors(**json.loads(record["errors"])) if record["errors"] else None,
        drifts=json.loads(record["drifts"]) if record["drifts"] else None,
        motion=_unpack(record["motion"]) if record["motion"] else None,
        **{name: record[name] for name in _PLAIN_ROW},
    )


def _verdict(record: sqlite3.Row) -> Verdict:
    broken = tuple(json.loads(record["broken"]))
    plain = {name: record[name] for name in _PLAIN_VERDICT}
    as_shipped = bool(record["as_shipped"])
    return Verdict(key=_key(record), broken=broken, as_shipped=as_shipped, **plain)


def _key(record: sqlite3.Row) -> Key:
    return Key(record["scenario"], record["engine"], record["method"])


def _pack(motion: Trajectory) -> bytes:
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **vars(motion))
    return buffer.getvalue()


def _unpack(blob: bytes) -> Trajectory:
    with np.load(io.BytesIO(blob), allow_pickle=False) as arrays:
        return Trajectory(**{name: arrays[name] for name in arrays.files})
