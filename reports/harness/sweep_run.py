"""Runs one point of a sweep: one scene and timestep, each method against the scene's own motion."""

from collections.abc import Sequence

import numpy as np

from ...reference import Solution, solve_cheaply
from ...scenarios import Scenario, ScenarioError
from ..results.records import Key, Row
from ..results.sweep_records import PointOutcome, PointResult, SweepPoint
from .choice import EngineMethod
from .comparison import row_of
from .executors import CallFailed, cause_of, is_environmental
from .ladder import Rung, single
from .sweep_points import rung_at, scene_at

#: A run of more steps is not made: it would take about 1 s in MuJoCo, a few in PyBullet.
STEP_BUDGET = 1 << 17


def run_point(
    base: Scenario, point: SweepPoint, pairs: Sequence[EngineMethod]
) -> list[PointResult]:
    """One result for each method; a single one if the point's numbers make no valid scene.

    Without methods the exact motion is found, and there are no results.

    Parameters
    ----------
    base : the scene that is varied
    """
    scenario = _scene(base, point)
    if isinstance(scenario, PointResult):
        return [scenario]
    if not pairs:
        solve_cheaply(scenario, scenario.times)
    exact = _ExactMotions(scenario)
    return [_result(scenario, point, exact, pair) for pair in pairs]


def failed_point(
    base: Scenario, point: SweepPoint, pair: EngineMethod, failure: CallFailed
) -> PointResult:
    """The result of a method whose call has failed."""
    scenario = _scene(base, point)
    if isinstance(scenario, PointResult):
        return scenario
    rung = rung_at(point, scenario, pair[0])
    return _not_run(point, _key(base, pair), rung, "failed", failure.cause, failure.reason)


def _scene(base: Scenario, point: SweepPoint) -> Scenario | PointResult:
    """The scene of a point, or the result that says why there is none."""
    try:
        scenario = scene_at(point, base)
        if point.timestep is not None:
            single(point.timestep, scenario.times)
        return scenario
    except ScenarioError as error:
        # Without the line number: the varied file exists in memory only.
        reason = "; ".join(line.partition(": ")[2] for line in str(error).splitlines())
    except ValueError as error:
        reason = str(error)
    key = Key(base.name, "", "")
    return PointResult(point.at, key, point.timestep or 0.0, "invalid", "scene", reason)


class _ExactMotions:
    """The exact motion of a point's scene, found once for all methods of one timestep."""

    def __init__(self, scenario: Scenario) -> None:
        self._scenario = scenario
        self._solved: dict[float, Solution | str] = {}

    def at(self, rung: Rung) -> Solution | str:
        """The exact motion at the samples of a run, or why it could not be found."""
        if rung.timestep not in self._solved:
            self._solved[rung.timestep] = self._solve(rung)
        return self._solved[rung.timestep]

    def _solve(self, rung: Rung) -> Solution | str:
        try:
            times = np.asarray(rung.sample_steps * rung.timestep, dtype=float)
            return solve_cheaply(self._scenario, times)
        except Exception as error:
            if is_environmental(cause_of(error)):
                raise
            return f"the exact motion could not be found: {type(error).__name__}: {error}"


def _result(
    scenario: Scenario, point: SweepPoint, exact: _ExactMotions, pair: EngineMethod
) -> PointResult:
    engine, method = pair
    key = _key(scenario, pair)
    rung = rung_at(point, scenario, engine)
    if isinstance(rung, str):
        return _not_run(point, key, rung, "skipped", "steps", rung)
    if rung.steps > STEP_BUDGET:
        reason = f"it takes {rung.steps} steps, and a point may take {STEP_BUDGET}"
        return _not_run(point, key, rung, "skipped", "steps", reason)
    solution = exact.at(rung)
    if isinstance(solution, str):
        return _not_run(point, key, rung, "failed", "unsolved", solution)
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
    point: SweepPoint,
    key: Key,
    rung: Rung | str,
    outcome: PointOutcome,
    cause: str,
    reason: str,
) -> PointResult:
    timestep = rung.timestep if isinstance(rung, Rung) else 0.0
    return PointResult(point.at, key, timestep, outcome, cause, reason)


def _key(base: Scenario, pair: EngineMethod) -> Key:
    engine, method = pair
    return Key(base.name, engine.name, method.name)
