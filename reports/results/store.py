"""Reads and writes the records of a result file.

Results that rest on another version of scene, engine or program stay in the file, but do not count:
they are not returned (`Store.rest_on`), and can be deleted by `Store.tidy`.
"""

import json
import sqlite3
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from typing import Any, TypeVar

from ...engines import Engine
from ...reference import Solution
from ...scenarios import Scenario
from . import tables
from .database import Database, put
from .default_records import default_effects
from .ensemble_records import DefinedEnsemble, swept
from .evidence import Evidence
from .provenance_records import DeclaredEngine, EnvironmentEntry, Fingerprint
from .records import UNSOLVED, Key, Record, Row, SolvedScene
from .result_file import OpenFile, ResultFileError, opened
from .results import Results, SceneResult
from .tables import DIGEST, Table, as_result_file_error
from .verdicts import Verdict

R = TypeVar("R", bound=Record)

SCHEMA = "".join(table.sql for table in tables.TABLES)
#: Number of hexadecimal digits that are kept of the digest of what a record rests on.
DIGITS = 16
_TABLE_OF: dict[type[Record], Table[Any]] = {table.record: table for table in tables.TABLES}
_ONE_METHOD = "scenario = ? AND engine = ? AND method = ?"
#: SQL condition that selects the runs of a method on a scene in which nothing is varied.
_AS_IT_IS = f"{_ONE_METHOD} AND variation = ''"
_SORTED = "scenario, engine, method"


class Store:
    """An open result file.

    Parameters
    ----------
    file : the connection to the file, and how it was opened

    Attributes
    ----------
    log_missing : whether the file is an incomplete copy of a file that was being written
    """

    def __init__(self, file: OpenFile) -> None:
        self._database = Database(file.connection, file.check)
        self.log_missing = file.log_missing
        self._fingerprints: dict[tuple[str, str, str], str] = {}
        self._take_fingerprints(self.select(tables.FINGERPRINTS))

    def put(self, *records: Record) -> None:
        """Store records, all or none of them; each replaces a stored record with the same key."""
        with self._database.transaction() as connection:
            self._put(connection, *records)

    def _put(self, connection: sqlite3.Connection, *records: Record) -> None:
        """Store records within a transaction that has begun; see `put`."""
        for record in records:
            table = _TABLE_OF[type(record)]
            columns = table.columns(record)
            if table.rests_on:
                columns[DIGEST] = self._digest(table, columns)
            put(connection, table.name, columns)

    def select(
        self, table: Table[R], where: str = "TRUE", values: Sequence[Any] = (), order: str = "rowid"
    ) -> list[R]:
        """Return the stored records of a table that a condition selects, and that count.

        Records do not count if they rest on another version of scene, engine or program.

        Parameters
        ----------
        where : the condition, in SQL
        values : values of the condition's parameters, its question marks
        order : what the records are sorted by, in SQL

        Raises
        ------
        ResultFileError
            If a record was changed after it was written, or cannot be read.
        """
        found = self._database.select(table.name, where, values, order)
        return [table.read(one) for one in found if self._counts(table, one)]

    def _counts(self, table: Table[Any], columns: sqlite3.Row) -> bool:
        """Whether a record, given by its columns, rests on the present scene, engine and program.

        If it does not, it does not count as a result.
        """
        return not table.rests_on or columns[DIGEST] == self._digest(table, columns)

    def _digest(self, table: Table[Any], columns: Mapping[str, Any] | sqlite3.Row) -> str:
        """Return the digest that a record of a table must have to count.

        It is the digest of the fingerprints that the record rests on; empty if none of them is
        known.

        Parameters
        ----------
        columns : the record's values, by column
        """
        engine = columns["engine"] if "engine" in table.key else ""
        parts = [
            self._fingerprints.get((columns["scenario"], engine if kind == "engine" else "", kind))
            for kind in table.rests_on
        ]
        joined = "\n".join(part or "" for part in parts)
        return sha256(joined.encode()).hexdigest()[:DIGITS] if any(parts) else ""

    def _take_fingerprints(self, fingerprints: Iterable[Fingerprint]) -> None:
        """Keep fingerprints for `_digest`; results that rest on others no longer count."""
        self._fingerprints |= {(f.scenario, f.engine, f.kind): f.digest for f in fingerprints}

    def rest_on(self, fingerprints: Sequence[Fingerprint]) -> int:
        """Store fingerprints of a scene; its results that rest on others no longer count.

        Parameters
        ----------
        fingerprints : at least one, all of the same scene

        Returns
        -------
        The number of stored verdicts that counted before and no longer count
        """
        scenario = fingerprints[0].scenario
        verdicts = self._database.select("verdicts", "scenario = ?", (scenario,))
        before = sum(self._counts(tables.VERDICTS, one) for one in verdicts)
        self.put(*fingerprints)
        self._take_fingerprints(fingerprints)
        return before - sum(self._counts(tables.VERDICTS, one) for one in verdicts)

    def tidy(self) -> int:
        """Delete the records that rest on another version of scene, engine or program.

        Returns
        -------
        The number of deleted records
        """
        deleted = 0
        with self._database.transaction() as connection:
            for table in (table for table in tables.TABLES if table.rests_on):
                key = (*table.key, DIGEST)
                where = " AND ".join(f"{name} IS ?" for name in key)
                for one in self._database.select(table.name):
                    if not self._counts(table, one):
                        values = [one[name] for name in key]
                        connection.execute(f"DELETE FROM {table.name} WHERE {where}", values)
                        deleted += 1
        return deleted

    def put_environment(self, environment: dict[str, str]) -> None:
        """Store what results may depend on, as texts by name: the machine, and versions."""
        self.put(*(EnvironmentEntry(name, value) for name, value in environment.items()))

    def put_methods(self, engines: Iterable[Engine]) -> None:
        """Store what the adapters of engines declare about them and their methods."""
        self.put(*map(DeclaredEngine.of, engines))

    def forget(self, keys: Iterable[Key]) -> None:
        """Delete the results of methods on scenes; rows in which something is varied are kept.

        Parameters
        ----------
        keys : scene, engine and method of the results to delete
        """
        with self._database.transaction() as connection:
            for key in keys:
                for table in tables.OF_STUDIES:
                    where = _AS_IT_IS if table is tables.ROWS else _ONE_METHOD
                    connection.execute(f"DELETE FROM {table.name} WHERE {where}", _names(key))

    def put_scene(self, scenario: Scenario, solution: Solution) -> None:
        """Store a scene and its exact motion.

        Rows are deleted if they say that this motion could not be found.
        """
        with self._database.transaction() as connection:
            self._put(connection, SolvedScene.of(scenario, solution))
            unsolved = "DELETE FROM rows WHERE scenario = ? AND timestep = ? AND variation = ''"
            connection.execute(unsolved, (scenario.name, UNSOLVED))

    def put_verdict(
        self, verdict: Verdict, evidence: Evidence | None = None, discardable: Sequence[float] = ()
    ) -> None:
        """Store a verdict and its evidence, and drop samples that are no longer needed.

        Parameters
        ----------
        evidence : the evidence that the verdict rests on; None if there is none
        discardable : timesteps, s, of those runs of the same method and scene whose samples are
            dropped
        """
        with self._database.transaction() as connection:
            self._put(connection, verdict)
            if evidence:
                self._put(connection, evidence)
            digest = self._digest(tables.ROWS, vars(verdict.key))
            where = f"{_AS_IT_IS} AND timestep = ? AND {DIGEST} = ?"
            connection.executemany(
                f"UPDATE rows SET motion = NULL WHERE {where}",
                [(*_names(verdict.key), timestep, digest) for timestep in discardable],
            )

    def evidence(self, key: Key) -> Evidence | None:
        """Return the evidence on a method on a scene; None if none is stored."""
        return next(iter(self.select(tables.EVIDENCE, _ONE_METHOD, _names(key))), None)

    def settled(self, scenario: str, timesteps: Sequence[float], step_limit: int) -> list[Verdict]:
        """Return the stored verdicts on a scene that need not be made again.

        A verdict is left out if its ladder ended at a step limit that is smaller than the present
        one.

        Parameters
        ----------
        scenario : the scene's name
        timesteps : the timesteps asked for, s; empty for verdicts on ladders
        step_limit : the present limit on the number of steps of a ladder's run
        """
        where = "scenario = ? AND timesteps = ?"
        stored = self.select(tables.VERDICTS, where, (scenario, _as_stored(timesteps)))
        return [v for v in stored if v.step_limit is None or v.step_limit >= step_limit]

    def rows_of(self, key: Key) -> list[Row]:
        """Return the stored runs of a method on a scene, except those in which something is varied.

        `Row.varied` tells what may be varied, such as the member of an ensemble.
        """
        return self.select(tables.ROWS, _AS_IT_IS, _names(key))

    def failed_rows(self, scenario: str) -> list[Row]:
        """Return the failed runs of a scene, except those in which something is varied.

        `Row.varied` tells what may be varied, such as the member of an ensemble.

        Parameters
        ----------
        scenario : the scene's name
        """
        rows = self.select(tables.ROWS, "scenario = ? AND variation = ''", (scenario,))
        return [row for row in rows if row.outcome == "failed"]

    def refused_evidence(self, scenario: str) -> list[Evidence]:
        """Return the evidence on methods whose steps could not be examined, or runs not replayed.

        Parameters
        ----------
        scenario : the scene's name
        """
        found = self.select(tables.EVIDENCE, "scenario = ?", (scenario,))
        return [evidence for evidence in found if evidence.refusal]

    def forget_costs_of_other_processors(self, processor: str) -> None:
        """Delete the costs of a method on a scene if any of them was measured on another processor.

        Methods and scenes are treated one by one; costs of varied engines are deleted as well.

        Parameters
        ----------
        processor : name of the processor whose costs are kept
        """
        others = [one.key for one in self.select(tables.COSTS) if one.processor != processor]
        with self._database.transaction() as connection:
            for key in others:
                connection.execute(f"DELETE FROM costs WHERE {_ONE_METHOD}", _names(key))

    def keys_with_timing(self) -> set[Key]:
        """Return the methods on scenes for which the cost of the unvaried engine is stored.

        The stored cost may be None, which says that the steps cannot be timed.
        """
        return {one.key for one in self.select(tables.COSTS, "variation = ''")}

    def read(self, timesteps: Sequence[float] = ()) -> Results:
        """Return everything in the file, with one verdict for each method and scene.

        Parameters
        ----------
        timesteps : the timesteps of the verdicts that are wanted, s; if empty, the verdict on the
            ladder is returned or, if there is none, the latest other verdict

        Raises
        ------
        ResultFileError
            If a record cannot be read or was changed after it was written, or if a run has errors
            although its scene is missing.
        """
        costs = self.select(tables.COSTS, order=f"{_SORTED}, rowid")
        seconds = {one.key: vars(one.cost) for one in costs if one.cost and not one.variation}
        stored = self.select(tables.ROWS, order=f"{_SORTED}, -timestep, rowid")
        varied = [row for row in stored if row.variation]
        rows = [
            replace(row, **{name: of_step[name] for name in vars(row).keys() & of_step})
            if (of_step := seconds.get(row.key))
            else row
            for row in stored
            if not row.variation
        ]
        scenes = {
            stored.scenario: SceneResult(*as_result_file_error(stored.solved)())
            for stored in self.select(tables.SCENES, order="scenario")
        }
        for row in rows:
            if row.errors is not None and row.key.scenario not in scenes:
                raise ResultFileError(f"a run has errors, but its scene is not there: {row.key}")
        engines = self.select(tables.ENGINES)
        return Results(
            environment={
                one.name: one.value for one in self.select(tables.ENVIRONMENT, order="name")
            },
            scenes=scenes,
            rows=rows,
            verdicts=self._verdicts(_as_stored(timesteps)),
            costs=[one for one in costs if one.variation],
            varied=varied,
            defaults=default_effects(rows, varied),
            evidence=self.select(tables.EVIDENCE, order=_SORTED),
            ensembles=as_result_file_error(swept)(self._ensembles(), varied),
            methods={(e.name, method.name): method for e in engines for method in e.methods},
            stock_timesteps={e.name: e.stock_timestep for e in engines if e.stock_timestep},
            single_precision=frozenset(e.name for e in engines if e.single_precision),
        )

    def varied(self, scenario: str) -> list[Row]:
        """Return those stored runs of a scene in which something is varied (`Row.varied`).

        Parameters
        ----------
        scenario : the scene's name
        """
        return self.select(tables.ROWS, "scenario = ? AND variation != ''", (scenario,))

    def _ensembles(self) -> list[DefinedEnsemble]:
        """Return the definitions of the stored ensembles, sorted by scene."""
        return self.select(tables.ENSEMBLES, order="scenario, ensemble")

    def _verdicts(self, timesteps: str) -> list[Verdict]:
        """Return one verdict for each method and scene, chosen as `read` does.

        Parameters
        ----------
        timesteps : `timesteps` of `read`, in the form that `_as_stored` returns
        """
        where, values = ("timesteps = ?", (timesteps,)) if timesteps != _LADDER else ("TRUE", ())
        order = f"{_SORTED}, timesteps = '{_LADDER}' DESC, rowid DESC"
        first: dict[Key, Verdict] = {}
        for verdict in self.select(tables.VERDICTS, where, values, order):
            first.setdefault(verdict.key, verdict)
        return list(first.values())


def _names(key: Key) -> tuple[str, str, str]:
    """Return scene, engine and method of a key: the values of the parameters in `_ONE_METHOD`."""
    return key.scenario, key.engine, key.method


def _as_stored(timesteps: Sequence[float]) -> str:
    """Return timesteps, s, in the form in which they are stored with a verdict: sorted, as JSON."""
    return json.dumps(sorted(timesteps))


#: The stored form of a ladder's timesteps.
_LADDER = _as_stored(())


@contextmanager
def open_store(path: Path, *, create: bool = False) -> Iterator[Store]:
    """Open a result file.

    Parameters
    ----------
    create : whether the file is opened for writing, and created if there is none; else it is opened
        for reading

    Raises
    ------
    ResultFileError
        If the file is missing, cannot be used, is no result file of this format, or is to be
        written while another process writes to it.
    """
    with opened(path, SCHEMA, writing=create) as file:
        yield Store(file)
