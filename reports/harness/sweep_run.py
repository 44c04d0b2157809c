"""Runs one point of a sweep: one scene and timestep, each method against the scene's own motion."""

from collections.abc import Sequence

import numpy as np

from ...reference import Solution, solve
from ...scenarios import Scenario, ScenarioError
from ..results.records import Key, Row
from ..results.sweep_records import PointOutcome, PointResult, SweepPoint
from .choice import EngineMethod
from .comparison import row_of
from .executors import CallFailed, cause_of, is_environmental
from .ladder import Rung
from .sweep_points import rung_at, scene_at

#: A run of more steps is not made: it would take about 1 s in MuJoCo, a few in PyBullet.
STEP_BUDGET = 1 << 17


def run_point(
    base: Scenario, point: SweepPoint, pairs: Sequence[EngineMethod]
) -> list[PointResult]:
    """One result for each method; a single one if the point's numbers make no valid scene.

    Parameters
    ----------
    base : the scene that is varied
    """
    run = _scene_and_rung(base, point)
    if isinstance(run, PointResult):
        return [run]
    scenario, rung = run
    keys = _keys(base, pairs)
    if rung.steps > STEP_BUDGET:
        reason = f"it takes {rung.steps} steps, and a point may take {STEP_BUDGET}"
        return [_not_run(point, key, rung, "skipped", "steps", reason) for key in keys]
    try:
        solution = solve(scenario, np.asarray(rung.sample_steps * rung.timestep, dtype=float))
    except Exception as error:
        if is_environmental(cause_of(error)):
            raise
        reason = f"the exact motion could not be found: {type(error).__name__}: {error}"
        return [_not_run(point, key, rung, "failed", "unsolved", reason) for key in keys]
    return [_result(scenario, point, rung, solution, pair) for pair in pairs]


def failed_point(
    base: Scenario, point: SweepPoint, pair: EngineMethod, failure: CallFailed
) -> PointResult:
    """The result of a method whose call has failed."""
    run = _scene_and_rung(base, point)
    if isinstance(run, PointResult):
        return run
    (key,) = _keys(base, [pair])
    return _not_run(point, key, run[1], "failed", failure.cause, failure.reason)


def _scene_and_rung(base: Scenario, point: SweepPoint) -> tuple[Scenario, Rung] | PointResult:
    """The scene of a point and its rung, or the result that says why there is none."""
    try:
        scenario = scene_at(point, base)
        return scenario, rung_at(point, scenario)
    except ScenarioError as error:
        # Without the line number: the varied file exists in memory only.
        reason = "; ".join(line.partition(": ")[2] for line in str(error).splitlines())
    except ValueError as error:
        reason = str(error)
    key = Key(base.name, "", "")
    return PointResult(point.at, key, point.timestep or 0.0, "invalid", "scene", reason)


def _result(
    scenario: Scenario, point: SweepPoint, rung: Rung, solution: Solution, pair: EngineMethod
) -> PointResult:
    engine, method = pair
    (key,) = _keys(scenario, [pair])
    within = Rung(rung.timestep, rung.sample_steps[: len(solution.trajectory.t)])
    run = engine.run(scenario, method, within.timestep, within.sample_steps)
    return _of_row(point, row_of(scenario, key, engine.version, within, run, solution))


def _of_row(point: SweepPoint, row: Row) -> PointResult:
    return PointResult(
        point.at,
        row.key,
        row.timestep,
        row.outcome,
        row.cause,
        row.reason,
        row.stopped_at,
        row.errors,
        row.reference_uncertainty,
        row.steps,
    )


def _not_run(
    point: SweepPoint, key: Key, rung: Rung, outcome: PointOutcome, cause: str, reason: str
) -> PointResult:
    return PointResult(point.at, key, rung.timestep, outcome, cause, reason)


def _keys(base: Scenario, pairs: Sequence[EngineMethod]) -> list[Key]:
    return [Key(base.name, engine.name, method.name) for engine, method in pairs]
