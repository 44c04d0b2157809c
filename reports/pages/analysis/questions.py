"""The results as SQL tables, which the report's pages and the terminal query.

``run`` has a line for each run, and ``usual`` a line for each run at the timestep that an engine's
users get by default. ``tried`` has a line for each method on a scene, ``unasked`` a line for each
effect that acted in a run though the scene does not call for it, and ``altered`` a line for each
default of an engine that alone alters the equations of motion of a scene.

The tables are made in memory from a result file. Numbers are in SI units, angles in rad. The error
of a run without errors is infinite; what is not known is NULL.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import starmap
from typing import Any
from weakref import WeakKeyDictionary

from ...harness.timesteps.stock import COMMON_TIMESTEP
from ...results.records import Key, OfMethod, Pair, Row
from .in_memory import Tables
from .measures import DEGREES, TURNS
from .report_data import MethodRuns, ReportData, SceneRuns
from .timesteps import survival

RUN = (
    "run (scene, engine, method, version, timestep, stock, outcome, simulated, attitude, turns,"
    " attitude_a_turn, seconds)"
)
TRIED = (
    "tried (scene, hard, engine, method, place, shipped, verdict, judged_as_shipped, unmet,"
    " seconds, survives, turn, at_least)"
)
UNASKED = "unasked (scene, engine, method, timestep, name)"
ALTERED = "altered (scene, engine, method, name)"
VIEWS = f"""
CREATE VIEW own AS
    SELECT engine, coalesce(max(CASE WHEN stock AND timestep <> {COMMON_TIMESTEP!r}
        THEN timestep END), {COMMON_TIMESTEP!r}) AS timestep
    FROM tried LEFT JOIN run USING (scene, engine, method) GROUP BY engine;
CREATE VIEW usual AS
    SELECT run.*, place, shipped, verdict, judged_as_shipped
    FROM run JOIN own USING (engine, timestep) JOIN tried USING (scene, engine, method)
    WHERE stock AND simulated;
"""
_FILLED: "WeakKeyDictionary[ReportData, Tables]" = WeakKeyDictionary()


def ask(gathered: ReportData, question: str, *values: Any) -> list[Any]:
    """Return the rows that an SQL query selects from the results of a report.

    The tables are `run`; `tried`, methods on scenes; `unasked`, effects that acted though a scene
    does not call for them; and `altered`, defaults of engines that alter the equations of motion.
    The view `own` has the engines' stock timesteps, and `usual` the runs at these.

    Parameters
    ----------
    gathered : the results; they are put into the tables when the first query is asked
    question, values : the query, and values for its question marks
    """
    if gathered not in _FILLED:
        _FILLED[gathered] = _filled(gathered)
    return _FILLED[gathered].ask(question, *values)


def _filled(gathered: ReportData) -> Tables:
    """Return the tables `run`, `tried`, `unasked` and `altered`, filled from a report's data."""
    place = {pair: k for k, pair in enumerate(gathered.pairs)}
    every = [(scene, runs, place[runs.pair]) for scene in gathered.scenes for runs in scene.methods]
    rows = [row for _, runs, _ in every for row in runs.rows]
    measured = [one for scene in gathered.scenes for one in scene.defaults]
    lines = {
        RUN: map(_run, rows),
        TRIED: starmap(_tried, every),
        UNASKED: ((*_names(r.key), r.timestep, name) for r in rows for name in _unasked(r)),
        ALTERED: ((*_names(m.key), one.name) for m in measured for one in m.each if one.acts),
    }
    return Tables(lines, VIEWS)


def _names(key: Key) -> tuple[str, str, str]:
    """Return the names of scene, engine and method that a key has, in this order."""
    return key.scenario, key.engine, key.method


def _run(row: Row) -> tuple[Any, ...]:
    """Return a run as a line of the table ``run``, whose columns `RUN` names."""
    return (
        *_names(row.key),
        row.engine_version,
        row.timestep,
        row.stock,
        row.outcome,
        row.simulated,
        row.errors.attitude if row.errors else math.inf,
        TURNS.of(row),
        row.attitude_a_turn if row.errors else None,
        row.seconds_per_step,
    )


def _tried(scene: SceneRuns, runs: MethodRuns, place: int) -> tuple[Any, ...]:
    """Return a method on a scene as a line of the table ``tried``, whose columns `TRIED` names.

    `place` is the method's index in `ReportData.pairs`.
    """
    verdict = runs.verdict
    survived = survival(runs.rows, scene.fastest_rate if scene.solved else None)
    return (
        scene.name,
        scene.solved is not None and scene.solved.scenario.hard,
        *runs.pair,
        place,
        runs.as_shipped,
        verdict and verdict.verdict,
        verdict and verdict.as_shipped,
        verdict and bool(verdict.unmet),
        runs.rows[-1].seconds_per_step if runs.rows else None,
        survived and survived.timestep,
        survived and survived.turn,
        survived and survived.at_least,
    )


def _unasked(row: Row) -> Iterable[str]:
    """Return the names of what acted in a run though the scene does not call for it."""
    # Names with numbers are left out: they state measured sizes, which differ between scenes.
    names = [name for name in row.unasked if not any(map(str.isdigit, name))]
    return dict.fromkeys([*names, *["a velocity clamp"] * (row.cause == "clamp")])


def own_timesteps(gathered: ReportData) -> dict[str, float]:
    """Return each engine's stock timestep, s; 1 ms for an engine that has none."""
    return dict(ask(gathered, "SELECT engine, timestep FROM own"))


def verdict_counts(gathered: ReportData, *, as_shipped: bool) -> dict[str, int]:
    """Return how often each verdict was given to a method on a scene, by the verdict's word.

    Parameters
    ----------
    as_shipped : True to count methods as shipped alone, False to count all others
    """
    where = "verdict IS NOT NULL AND judged_as_shipped = ?"
    question = f"SELECT verdict, count(*) FROM tried WHERE {where} GROUP BY verdict"
    return dict(ask(gathered, question, as_shipped))


def as_shipped(gathered: ReportData) -> list[Pair]:
    """Return the methods as shipped, as pairs of engine and method."""
    return ask(gathered, "SELECT DISTINCT engine, method FROM tried WHERE shipped ORDER BY place")


@dataclass(frozen=True)
class Usual(OfMethod):
    """One method's runs at its engine's stock timestep, over the scenes that it can simulate.

    Attributes
    ----------
    timestep : s
    shipped : whether the method is as shipped
    scenes : number of scenes, each with one run
    unfinished : number of runs without errors
    blew_up, failed : number of runs that diverged, and that failed
    middle, largest : the median and the largest attitude error, degrees; a run without errors
        counts as infinitely wrong
    worst : the scene of the largest error
    worst_finished, largest_finished : the scene of the largest finite error, and that error,
        degrees; None if no run has errors
    turns : the median number of turns until the attitude is off by 1°; infinite if it never is,
        None if not known
    a_turn : the median error that a turn adds to the attitude, degrees; None if not known
    """

    engine: str
    method: str
    timestep: float
    shipped: bool
    scenes: int
    unfinished: int
    blew_up: int
    failed: int
    middle: float
    largest: float
    worst: str
    worst_finished: str | None
    largest_finished: float | None
    turns: float | None
    a_turn: float | None


_USUAL = f"""
WITH finished AS (SELECT * FROM usual WHERE attitude < 9e999)
SELECT engine, method, timestep, shipped, count(*), sum(attitude = 9e999),
    sum(outcome = 'diverged'), sum(outcome = 'failed'),
    median_high(attitude) * {DEGREES!r}, max(attitude) * {DEGREES!r},
    (SELECT scene FROM usual AS u WHERE (u.engine, u.method) = (o.engine, o.method)
        ORDER BY attitude DESC, scene LIMIT 1),
    (SELECT scene FROM finished AS f WHERE (f.engine, f.method) = (o.engine, o.method)
        ORDER BY attitude DESC, scene LIMIT 1),
    max(CASE WHEN attitude < 9e999 THEN attitude END) * {DEGREES!r},
    median_high(turns), median(attitude_a_turn) * {DEGREES!r}
FROM usual AS o GROUP BY engine, method ORDER BY place
"""


def at_stock(gathered: ReportData) -> list[Usual]:
    """Return the errors at the engine's stock timestep, for each method that was run at it."""
    return [Usual(*line) for line in ask(gathered, _USUAL)]


def leading(gathered: ReportData) -> list[Pair]:
    """Return the methods to show first: for each engine, one as shipped and one clean method.

    The method as shipped is the first that the adapter lists. The clean method is, among those that
    can simulate the most scenes, the one with the smallest median error at the stock timestep.
    """
    first = {engine: (engine, method) for engine, method in reversed(as_shipped(gathered))}
    others = [one for one in at_stock(gathered) if not one.shipped]
    best: dict[str, Pair] = {}
    for one in sorted(others, key=lambda one: (-one.scenes, one.middle)):
        best.setdefault(one.engine, one.pair)
    return [*first.values(), *best.values()]
