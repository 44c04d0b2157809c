"""Runs what is missing of a sweep, point by point, on an executor.

One call runs all methods at a point, so that its scene is solved once. If that call fails, the
scene is solved alone, to find out whether the reference or an engine failed, and then each method
is run alone: a crash costs one method's result.
"""

import json
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

from ...scenarios import Scenario
from ..results.environment import environment
from ..results.fingerprints import fingerprints
from ..results.records import Pair
from ..results.store import Store
from ..results.sweep_records import (
    Ensemble,
    Map,
    PointResult,
    SweepPoint,
)
from ..results.sweep_tables import NO_SCENE
from .choice import Choice, EngineMethod
from .compiling import compile_side_by_side
from .executors import CallFailed, Executor, cause_of_unsolved, may_succeed_if_repeated
from .sweep_run import failed_point, run_point

Progress = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class PointLeft:
    """A point, and the methods whose results are missing there."""

    point: SweepPoint
    to_run: Sequence[EngineMethod]


@dataclass(frozen=True, eq=False)
class SweepPlan:
    """What a sweep still has to do.

    Attributes
    ----------
    pairs : the methods asked for
    stored : engine and method of the stored results, by the point's identity
    total, complete : number of points asked for, and of complete ones
    """

    sweep: Map | Ensemble
    pairs: Sequence[EngineMethod]
    stored: Mapping[str, Collection[Pair]]
    total: int
    complete: int

    @property
    def missing(self) -> int:
        """Number of incomplete points."""
        return self.total - self.complete

    def left(self) -> Iterator[PointLeft]:
        """The incomplete points, one by one: a sweep may have more than fit into memory."""
        for point in self.sweep.points():
            if to_run := _to_run(self.pairs, self.stored.get(point.identity, ())):
                yield PointLeft(point, to_run)

    def __str__(self) -> str:
        """How many stored points are used again, in words; empty if none."""
        if not self.complete:
            return ""
        return f"{self.complete} of {self.total} points are stored already"


def plan_sweep(sweep: Map | Ensemble, base: Scenario, choice: Choice, store: Store) -> SweepPlan:
    """Store the definition, and determine what is missing."""
    store.rest_on(tuple(fingerprints(base, choice.engines)))
    store.put_environment(environment(choice.engines))
    store.put_methods(choice.engines)
    store.sweeps.put(sweep, base)
    pairs = choice.pairs()
    stored: dict[str, set[Pair]] = {}
    for result in [] if choice.again else store.sweeps.stored(base.name):
        if not may_succeed_if_repeated(result.cause, result.reason, choice.time_limit):
            key = result.key
            stored.setdefault(result.place, set()).add((key.engine, key.method))
    complete = sum(
        not _to_run(pairs, there) and sweep.point(json.loads(identity)) is not None
        for identity, there in stored.items()
    )
    return SweepPlan(sweep, pairs, stored, len(sweep), complete)


def _to_run(pairs: Sequence[EngineMethod], there: Collection[Pair]) -> list[EngineMethod]:
    """The methods that have no result at a point."""
    if NO_SCENE in there:
        return []
    return [pair for pair in pairs if (pair[0].name, pair[1].name) not in there]


def run_sweep(
    plan: SweepPlan, base: Scenario, store: Store, executor: Executor, progress: Progress
) -> None:
    """Run the missing points, and store the results of each as soon as it is run."""
    if plan.missing:
        compile_side_by_side(executor)
    tasks = (partial(study_point, left, base, store, executor) for left in plan.left())
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
        unsolved = CallFailed(reason, cause_of_unsolved(solved))
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
