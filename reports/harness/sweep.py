"""Runs what is missing of a sweep, point by point, on whatever executor it is handed.

One call runs all methods at a point, so that its scene is solved once. Where that call fails, the
scene is solved alone, to tell the reference from the engines, and then each method is run alone:
a crash costs one method's result.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

from ...scenarios import Scenario
from ..results.environment import environment
from ..results.fingerprints import digests
from ..results.store import Store
from ..results.sweep_records import Ensemble, Map, PointResult, SweepPoint, sweep_points
from ..results.sweep_tables import NO_SCENE
from .choice import Choice, EngineMethod
from .executors import CallFailed, Executor, may_succeed_if_repeated
from .sweep_run import failed_point, run_point

Progress = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class PointLeft:
    """A point, and the methods whose results are missing there."""

    point: SweepPoint
    to_run: Sequence[EngineMethod]


@dataclass(frozen=True, eq=False)
class SweepPlan:
    """What is left of a sweep.

    Attributes
    ----------
    complete : points that lack nothing
    """

    left: list[PointLeft]
    complete: int

    def __str__(self) -> str:
        """What is used again, in words; empty where that is nothing."""
        total = len(self.left) + self.complete
        return f"{self.complete} of {total} points are there already" if self.complete else ""


def plan_sweep(sweep: Map | Ensemble, base: Scenario, choice: Choice, store: Store) -> SweepPlan:
    """Record what is asked for, drop what is out of date, and see what is missing."""
    store.keep_matching(base.name, digests(base, choice.engines))
    store.put_environment(environment(choice.engines))
    store.put_methods(choice.engines)
    store.sweeps.put(sweep, base)
    pairs = choice.pairs()
    stored: dict[str, set[tuple[str, str]]] = {}
    for result in store.sweeps.stored(base.name):
        if not may_succeed_if_repeated(result.cause, result.reason, choice.time_limit):
            stored.setdefault(result.identity, set()).add((result.engine, result.method))
    left, total = [], 0
    for point in sweep_points(sweep):
        total += 1
        there = stored.get(point.identity, set())
        if NO_SCENE in there:
            continue
        missing = [pair for pair in pairs if (pair[0].name, pair[1].name) not in there]
        if missing:
            left.append(PointLeft(point, missing))
    return SweepPlan(left, total - len(left))


def run_sweep(
    plan: SweepPlan, base: Scenario, store: Store, executor: Executor, progress: Progress
) -> None:
    """Run what is left, and store the results of every point as soon as they are there."""
    tasks = (partial(study_point, left, base, store, executor) for left in plan.left)
    for point in executor.each(tasks):
        progress(str(point))


def study_point(left: PointLeft, base: Scenario, store: Store, executor: Executor) -> SweepPoint:
    """One point, from the exact motion to the stored results of all its methods."""
    answer = executor.call(run_point, base, left.point, left.to_run)
    if isinstance(answer.value, CallFailed):
        results = _one_by_one(left, base, answer.value, executor)
    else:
        results = answer.value
    store.sweeps.put_points(left.point, results)
    return left.point


def _one_by_one(
    left: PointLeft, base: Scenario, failure: CallFailed, executor: Executor
) -> list[PointResult]:
    """The results at a point where the call that was to run all methods has failed."""
    solved = executor.call(run_point, base, left.point, ()).value
    if isinstance(solved, CallFailed):
        reason = f"the exact motion could not be found: {solved.reason}"
        unsolved = CallFailed(reason, "unsolved")
        return [failed_point(base, left.point, pair, unsolved) for pair in left.to_run]
    if len(left.to_run) == 1:
        return [failed_point(base, left.point, left.to_run[0], failure)]
    results: list[PointResult] = []
    for pair in left.to_run:
        alone = executor.call(run_point, base, left.point, [pair]).value
        if isinstance(alone, CallFailed):
            alone = [failed_point(base, left.point, pair, alone)]
        results += alone
    return results
