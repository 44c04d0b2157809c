"""Runs a point of a sweep: one scene and timestep, each method against the scene's own truth."""

from collections.abc import Iterator, Sequence
from functools import lru_cache

import numpy as np

from ...engines import Engine
from ...reference import Solution, solve
from ...scenarios import Scenario, ScenarioError, loads
from ..results.records import Key, Row
from ..results.sweep_records import Point, PointOutcome
from .comparison import row_of
from .executors.worker_slot import Lost
from .ladder import Rung
from .sweep_points import Place

#: A run of more steps than this is skipped: a second of MuJoCo's, a few of PyBullet's.
STEP_BUDGET = 1 << 17

#: Engine and name of the method.
Pair = tuple[Engine, str]


def run_place(text: str, name: str, place: Place, pairs: Sequence[Pair]) -> list[Point]:
    """One point a method; one in all where the place has no scene.

    Parameters
    ----------
    text, name : of the scene that is varied
    """
    found = _found(text, name, place)
    if isinstance(found, Point):
        return [found]
    scenario, rung = found
    if rung.steps > STEP_BUDGET:
        reason = f"it takes {rung.steps} steps, and a point may take {STEP_BUDGET}"
        return _without_runs(place, _keys(name, pairs), rung, "skipped", "steps", reason)
    try:
        solution = solve(scenario, np.asarray(rung.sample_steps * rung.timestep, dtype=float))
    except Exception as error:
        reason = f"the reference could not be solved: {type(error).__name__}: {error}"
        return _without_runs(place, _keys(name, pairs), rung, "failed", "unsolved", reason)
    return list(_runs(scenario, place, rung, solution, pairs))


def lost_point(text: str, name: str, place: Place, pair: Pair, lost: Lost) -> Point:
    """The point of a method that took its process with it."""
    found = _found(text, name, place)
    if isinstance(found, Point):
        return found
    _, rung = found
    keys = _keys(name, [pair])
    return _without_runs(place, keys, rung, "failed", lost.cause, lost.reason)[0]


def _found(text: str, name: str, place: Place) -> tuple[Scenario, Rung] | Point:
    """The scene of a place and its run, or the point that says there is none."""
    try:
        scenario = place.scene(_base(text, name))
        return scenario, place.rung(scenario)
    except ScenarioError as error:
        # Without the line, which is of a file that nobody has.
        reason = "; ".join(line.partition(": ")[2] for line in str(error).splitlines())
    except ValueError as error:
        reason = str(error)
    timestep = place.timestep or 0.0
    return Point(place.at, Key(name, "", ""), timestep, "invalid", "scene", reason)


@lru_cache(maxsize=1)
def _base(text: str, name: str) -> Scenario:
    """The scene that is varied, the same for thousands of points."""
    return loads(text, name)


def _runs(
    scenario: Scenario, place: Place, rung: Rung, solution: Solution, pairs: Sequence[Pair]
) -> Iterator[Point]:
    within = Rung(rung.timestep, rung.sample_steps[: len(solution.trajectory.t)])
    for key, (engine, method) in zip(_keys(scenario.name, pairs), pairs, strict=True):
        run = engine.run(scenario, engine.method(method), within.timestep, within.sample_steps)
        row = row_of(scenario, key, engine.version, within, run, solution)
        yield _point(place, row)


def _point(place: Place, row: Row) -> Point:
    return Point(
        place.at,
        row.key,
        row.timestep,
        row.outcome,
        row.cause,
        row.reason,
        row.stopped_at,
        row.errors,
        row.uncertainty,
        row.steps,
    )


def _without_runs(
    place: Place, keys: Sequence[Key], rung: Rung, outcome: PointOutcome, cause: str, reason: str
) -> list[Point]:
    return [Point(place.at, key, rung.timestep, outcome, cause, reason) for key in keys]


def _keys(name: str, pairs: Sequence[Pair]) -> list[Key]:
    return [Key(name, engine.name, method) for engine, method in pairs]
