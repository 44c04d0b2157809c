"""The contents of a result file. Each run is written as it ends, so that a study can be continued.

Before a study continues, results of another text of a scene, another engine or another spincheck
are dropped (`Store.keep_matching`).
"""

import sqlite3
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from ...engines import Engine, Method
from ...reference import Solution
from ...scenarios import Scenario
from . import table_records
from .cost_records import EffectsCost, PassCosts, StepCost
from .database import Database, put
from .default_records import DefaultEffects
from .records import UNSOLVED, Key, Pair, Row, Verdict
from .result_file import OpenFile, ResultFileError, opened
from .schema import SCHEMA
from .sweep_records import EnsembleResult, MapResult
from .sweep_tables import SweepTables

_OF_STUDIES = ("rows", "costs", "left_out", "default_effects", "verdicts")
_OF_ENGINES = (*_OF_STUDIES, "points")
_OF_SCENES = ("fingerprints", "scenes", "sweeps", *_OF_ENGINES)
_ONE_ENGINE = "scenario = ? AND engine = ?"
_ONE_METHOD = "scenario = ? AND engine = ? AND method = ?"


@dataclass(frozen=True, eq=False)
class SceneResult:
    """A scene as it was simulated, and its exact motion at the sample times."""

    scenario: Scenario
    solution: Solution


@dataclass(frozen=True, eq=False)
class Results:
    """Everything a report is made from.

    Attributes
    ----------
    methods : what each engine's adapter declared of its methods, in the order it lists them
    stock_timesteps : s, of the engines that have one
    """

    environment: dict[str, str]
    scenes: dict[str, SceneResult]
    rows: list[Row]
    verdicts: list[Verdict]
    effects: list[EffectsCost] = field(default_factory=list)
    passes: list[PassCosts] = field(default_factory=list)
    defaults: list[DefaultEffects] = field(default_factory=list)
    methods: dict[Pair, Method] = field(default_factory=dict)
    stock_timesteps: dict[str, float] = field(default_factory=dict)
    maps: list[MapResult] = field(default_factory=list)
    ensembles: list[EnsembleResult] = field(default_factory=list)


class Store:
    """An open result file.

    Attributes
    ----------
    log_missing : whether it is an incomplete copy, made while a run was writing
    """

    def __init__(self, file: OpenFile) -> None:
        self._database = Database(file.connection, file.check)
        self._select = self._database.select
        self.sweeps = SweepTables(self._database)
        self.log_missing = file.log_missing

    def put_environment(self, environment: dict[str, str]) -> None:
        """Record machine and versions."""
        with self._database.transaction() as connection:
            for name, value in environment.items():
                put(connection, "environment", {"name": name, "value": value})

    def put_methods(self, engines: Iterable[Engine]) -> None:
        """Record what adapters declare of all their methods."""
        with self._database.transaction() as connection:
            for engine in engines:
                connection.execute("DELETE FROM methods WHERE engine = ?", (engine.name,))
                for method in engine.methods:
                    put(connection, "methods", table_records.of_method(engine, method))

    def keep_matching(self, scenario: str, digests: dict[str, str]) -> int:
        """Drop results of a scene whose digests differ; returns how many verdicts were dropped.

        Parameters
        ----------
        digests : by engine name, of the engine; under "", of the scene and the program
        """
        dropped = 0
        with self._database.transaction() as connection:
            for engine, digest in digests.items():
                stored = self._select("fingerprints", _ONE_ENGINE, (scenario, engine))
                if not (stored and stored[0]["digest"] == digest):
                    dropped += self._drop(connection, scenario, engine)
                    record = {"scenario": scenario, "engine": engine, "digest": digest}
                    put(connection, "fingerprints", record)
        return dropped

    def _drop(self, connection: sqlite3.Connection, scenario: str, engine: str) -> int:
        """Drop results of an engine on a scene; with no engine, the scene and all its results."""
        tables = _OF_ENGINES if engine else _OF_SCENES
        where = _ONE_ENGINE if engine else "scenario = ?"
        names = (scenario, engine) if engine else (scenario,)
        dropped = {
            table: connection.execute(f"DELETE FROM {table} WHERE {where}", names).rowcount
            for table in tables
        }
        return dropped["verdicts"]

    def forget(self, keys: Iterable[Key]) -> None:
        """Drop the results of some methods on their scenes; points of sweeps are kept."""
        with self._database.transaction() as connection:
            for key in keys:
                for table in _OF_STUDIES:
                    connection.execute(f"DELETE FROM {table} WHERE {_ONE_METHOD}", _names(key))

    def put_scene(self, scenario: Scenario, solution: Solution) -> None:
        """Record a scene and its exact motion."""
        with self._database.transaction() as connection:
            put(connection, "scenes", table_records.of_scene(scenario, solution))
            # That row says that the scene could not be solved, which is now outdated.
            unsolved = "DELETE FROM rows WHERE scenario = ? AND timestep = ?"
            connection.execute(unsolved, (scenario.name, UNSOLVED))

    def put_row(self, row: Row) -> None:
        """Store a run with its samples: another process may have to reach the verdict."""
        with self._database.transaction() as connection:
            put(connection, "rows", table_records.of_row(row))

    def put_verdict(
        self,
        verdict: Verdict,
        timesteps: Sequence[float] = (),
        step_limit: int | None = None,
        discardable: Sequence[float] = (),
    ) -> None:
        """Store a verdict, and drop the samples that are no longer needed.

        Parameters
        ----------
        timesteps : s, those that were asked for; none for a verdict on a ladder
        step_limit : of a ladder that this limit cut short; else None
        discardable : timesteps, s, of the runs whose samples are dropped
        """
        record = table_records.of_verdict(verdict)
        record |= {"timesteps": _asked(timesteps), "step_limit": step_limit}
        names = _names(verdict.key)
        with self._database.transaction() as connection:
            put(connection, "verdicts", record)
            connection.executemany(
                f"UPDATE rows SET motion = NULL WHERE {_ONE_METHOD} AND timestep = ?",
                [(*names, timestep) for timestep in discardable],
            )

    def put_cost(self, key: Key, processor: str, cost: StepCost | None) -> None:
        """Store the cost of a step of a method on a scene; None if it cannot be timed."""
        with self._database.transaction() as connection:
            put(connection, "costs", table_records.of_cost(key, processor, cost))

    def put_left_out(self, cost: EffectsCost | PassCosts) -> None:
        """Store how much time is saved by what a method leaves out on a scene."""
        with self._database.transaction() as connection:
            put(connection, "left_out", table_records.of_left_out(cost))

    def put_default_effects(self, effects: DefaultEffects) -> None:
        """Store what each default of a method as shipped does to the motion of a scene."""
        with self._database.transaction() as connection:
            put(connection, "default_effects", table_records.of_default_effects(effects))

    def settled(self, scenario: str, timesteps: Sequence[float], step_limit: int) -> list[Verdict]:
        """The stored verdicts on a scene; without those that a smaller step limit cut short.

        Parameters
        ----------
        timesteps : s; none for verdicts on ladders
        step_limit : of the ladders asked for
        """
        where = "scenario = ? AND timesteps = ? AND (step_limit IS NULL OR step_limit >= ?)"
        records = self._select("verdicts", where, (scenario, _asked(timesteps), step_limit))
        return [table_records.verdict(record) for record in records]

    def rows_of(self, key: Key) -> list[Row]:
        """The stored runs of a method on a scene."""
        return [table_records.row(r) for r in self._select("rows", _ONE_METHOD, _names(key))]

    def failed_rows(self, scenario: str) -> list[Row]:
        """The runs of a scene that failed."""
        records = self._select("rows", "scenario = ? AND outcome = 'failed'", (scenario,))
        return [table_records.row(record) for record in records]

    def timed_on(self, processor: str) -> set[Key]:
        """The methods whose steps were timed; times of another processor are dropped."""
        with self._database.transaction() as connection:
            connection.execute("DELETE FROM costs WHERE processor != ?", (processor,))
        return {table_records.key(record) for record in self._select("costs")}

    def read(self, timesteps: Sequence[float] = ()) -> Results:
        """Everything in the file, with one verdict for each method and scene.

        Parameters
        ----------
        timesteps : s, of the verdicts that are wanted; if empty, the verdict on the ladder, or the
            latest of the others if there is none

        Raises
        ------
        ResultFileError
            If a record cannot be read.
        """
        costs = {table_records.key(record): record for record in self._select("costs")}
        row_records = self._select("rows", order="scenario, engine, method, -timestep")
        scene_records = self._select("scenes", order="scenario")
        environment = self._select("environment", order="name")
        methods = self._select("methods")
        left_out = [
            table_records.left_out(record)
            for record in self._select("left_out", order="scenario, engine, method")
        ]
        rows = [table_records.row(r, costs.get(table_records.key(r))) for r in row_records]
        maps, ensembles = self.sweeps.read()
        scenes = {r["scenario"]: SceneResult(*table_records.scene(r)) for r in scene_records}
        for row in rows:
            if row.errors is not None and row.key.scenario not in scenes:
                raise ResultFileError(f"a run has errors, but its scene is not there: {row.key}")
        return Results(
            environment=dict(table_records.environment(record) for record in environment),
            scenes=scenes,
            rows=rows,
            verdicts=self._verdicts(_asked(timesteps)),
            effects=[cost for cost in left_out if isinstance(cost, EffectsCost)],
            passes=[cost for cost in left_out if isinstance(cost, PassCosts)],
            defaults=[
                table_records.default_effects(record)
                for record in self._select("default_effects", order="scenario, engine, method")
            ],
            maps=maps,
            ensembles=ensembles,
            methods=dict(table_records.method(record) for record in methods),
            stock_timesteps=dict(filter(None, map(table_records.stock_timestep, methods))),
        )

    def _verdicts(self, asked: str) -> list[Verdict]:
        order = "scenario, engine, method, timesteps = '' DESC, rowid DESC"
        where = "timesteps = ?" if asked else "TRUE"
        first: dict[Key, Verdict] = {}
        for record in self._select("verdicts", where, (asked,) if asked else (), order):
            first.setdefault(table_records.key(record), table_records.verdict(record))
        return list(first.values())


def _names(key: Key) -> tuple[str, str, str]:
    return key.scenario, key.engine, key.method


def _asked(timesteps: Sequence[float]) -> str:
    return " ".join(repr(timestep) for timestep in sorted(timesteps))


@contextmanager
def open_store(path: Path, *, create: bool = False) -> Iterator[Store]:
    """Open a result file for reading; with `create` for writing, and create it if there is none.

    Raises
    ------
    ResultFileError
        As `result_file.opened`.
    """
    with opened(path, SCHEMA, writing=create) as file:
        yield Store(file)
