"""Computes the missing results of an ensemble, point by point.

A point is one member of the ensemble at one timestep. One call runs all methods at a point, so that
its scene is solved only once. If that call fails, the scene is solved by a call of its own, which
shows whether the reference or an engine has failed. Then each method is run by a call of its own,
so that a crash costs the result of one method only.
"""

import json
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

from ....scenarios import Scenario
from ...results.ensemble_records import DefinedEnsemble, Ensemble, EnsemblePoint
from ...results.environment import environment
from ...results.fingerprints import fingerprints
from ...results.records import Pair, Row, variation
from ...results.store import Store
from ..choice import Choice, EngineMethod
from ..executors import CallFailed, Executor, cause_of_unsolved, may_succeed_if_repeated
from ..executors.compiling import compile_side_by_side
from .point import not_run, run_point

Progress = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class PointLeft:
    """A member of an ensemble at a timestep, and the engines and methods without a result there."""

    point: EnsemblePoint
    to_run: Sequence[EngineMethod]


@dataclass(frozen=True, eq=False)
class EnsemblePlan:
    """The results of an ensemble that are missing.

    A point is a member of the ensemble at the timestep of its runs.

    Attributes
    ----------
    pairs : the methods asked for, with their engines
    stored : names of the engines and methods that have a result at a point, by the text that
        identifies the point (`variation`)
    total : number of points of the ensemble
    complete : number of points at which no result is missing
    """

    ensemble: Ensemble
    pairs: Sequence[EngineMethod]
    stored: Mapping[str, Collection[Pair]]
    total: int
    complete: int

    @property
    def missing(self) -> int:
        """Number of points at which a result is missing."""
        return self.total - self.complete

    def left(self) -> Iterator[PointLeft]:
        """Yield the points at which a result is missing.

        They are made one by one, as all of them might not fit into memory.
        """
        for point in self.ensemble.points():
            there = self.stored.get(variation(point.varied), ())
            if to_run := _to_run(self.pairs, there):
                yield PointLeft(point, to_run)


def plan_ensemble(ensemble: Ensemble, base: Scenario, choice: Choice, store: Store) -> EnsemblePlan:
    """Store the definition of an ensemble, and return which of its results are missing.

    If `Choice.again` is set, all of them count as missing.

    Parameters
    ----------
    base : the scene that the ensemble varies
    """
    store.rest_on(tuple(fingerprints(base, choice.engines)))
    store.put_environment(environment(choice.engines))
    store.put_methods(choice.engines)
    store.put(DefinedEnsemble(base.name, ensemble, base.text))
    pairs = list(choice.methods_on(base).values())
    stored: dict[str, set[Pair]] = {}
    for row in [] if choice.again else store.varied(base.name):
        if not may_succeed_if_repeated(row.cause, row.reason, choice.time_limit):
            stored.setdefault(row.variation, set()).add(row.pair)
    complete = sum(
        not _to_run(pairs, there) and ensemble.point(json.loads(varied)) is not None
        for varied, there in stored.items()
    )
    return EnsemblePlan(ensemble, pairs, stored, len(ensemble), complete)


def _to_run(pairs: Sequence[EngineMethod], there: Collection[Pair]) -> list[EngineMethod]:
    """Return the methods that have no result at a point (a member at a timestep).

    Parameters
    ----------
    pairs : the methods asked for, with their engines
    there : names of the engines and methods that have a result at the point
    """
    return [pair for pair in pairs if (pair[0].name, pair[1].name) not in there]


def run_ensemble(
    plan: EnsemblePlan, base: Scenario, store: Store, executor: Executor, progress: Progress
) -> None:
    """Compute the missing results of an ensemble; store those of a point as soon as it is done.

    A point is a member of the ensemble at the timestep of its runs.

    Parameters
    ----------
    plan : the results that are missing
    base : the scene that the ensemble varies
    progress : called with the name of each completed point
    """
    if plan.missing:
        compile_side_by_side(executor)
    tasks = (partial(study_point, left, base, store, executor) for left in plan.left())
    for point in executor.each(tasks):
        progress(str(point))


def study_point(left: PointLeft, base: Scenario, store: Store, executor: Executor) -> EnsemblePoint:
    """Run the methods that have no result at a point, store the results, and return the point.

    Parameters
    ----------
    left : the point, which is a member of the ensemble at a timestep; and the methods to run
    base : the scene that the ensemble varies
    """
    store.put(*_rows(left, base, executor))
    return left.point


def _rows(
    left: PointLeft, base: Scenario, executor: Executor, *, is_solved: bool = False
) -> list[Row]:
    """Return the missing rows of a member at a timestep, from one call for all methods.

    If that call fails, a second call only solves the exact motion. If this fails too, the rows are
    `failed`; else each method is run by a call of its own, and only the row of a method whose call
    fails again is `failed`.

    Parameters
    ----------
    left : the member, the timestep, and the methods without a row
    base : the scene that the ensemble varies
    is_solved : whether it is already known that the exact motion can be found
    """
    rows = executor.call(run_point, base, left.point, left.to_run).value
    if not isinstance(rows, CallFailed):
        return rows
    solved = () if is_solved else executor.call(run_point, base, left.point, ()).value
    if isinstance(solved, CallFailed):
        reason = f"the exact motion could not be found: {solved.reason}"
        unsolved = CallFailed(reason, cause_of_unsolved(solved))
        return [_failed(left, base, pair, unsolved) for pair in left.to_run]
    if len(left.to_run) == 1:
        return [_failed(left, base, left.to_run[0], rows)]
    alone = [PointLeft(left.point, [pair]) for pair in left.to_run]
    return [row for one in alone for row in _rows(one, base, executor, is_solved=True)]


def _failed(left: PointLeft, base: Scenario, pair: EngineMethod, failure: CallFailed) -> Row:
    """Return the row of a method on a member of an ensemble, if its call has failed.

    Parameters
    ----------
    left : the member, with its timestep
    base : the scene that the ensemble varies
    pair : the method, with its engine
    failure : why the call failed
    """
    return not_run(base, left.point, pair, "failed", failure.cause, failure.reason)
