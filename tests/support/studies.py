"""Studies and ensembles of a result file, in this process unless a test brings an executor."""

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

import pytest
from spincheck.reports.harness.choice import Choice
from spincheck.reports.harness.convergence_study import ConvergenceStudy
from spincheck.reports.harness.executors import Executor, InProcess
from spincheck.reports.harness.plan import plan
from spincheck.reports.harness.study import run_and_judge, run_study
from spincheck.reports.harness.varied.ensemble import plan_ensemble, run_ensemble
from spincheck.reports.results.ensemble_records import Ensemble, points_of
from spincheck.reports.results.records import Record, Row
from spincheck.reports.results.results import Results
from spincheck.reports.results.store import Store, open_store
from spincheck.reports.results.verdicts import Verdict
from spincheck.scenarios import Scenario

Progress = Callable[[str], object]


def study(
    path: Path,
    scenes: Sequence[Scenario],
    choice: Choice,
    executor: Executor | None = None,
    progress: Progress = len,
) -> Results:
    """Run what is missing of a study; returns all that the file then holds."""
    with open_store(path, create=True) as store, executor or InProcess() as calls:
        run_study(plan(scenes, choice, store), choice, store, calls, progress)
        return store.read()


def run_members(
    path: Path,
    definition: Ensemble,
    scene: Scenario,
    choice: Choice,
    executor: Executor | None = None,
    progress: Progress = len,
) -> tuple[Row, ...]:
    """Run what is missing of an ensemble; returns its points."""
    with open_store(path, create=True) as store, executor or InProcess() as calls:
        run_ensemble(plan_ensemble(definition, scene, choice, store), scene, store, calls, progress)
        return points_of(definition, store.varied(scene.name))


def stop_at(
    monkeypatch: pytest.MonkeyPatch, ends: Callable[[Row], bool], begin: Callable[[], object]
) -> None:
    """Begin a study, and stop it before the first row for which that holds is stored."""
    put = Store.put

    def stopping(store: Store, *records: Record) -> None:
        if any(isinstance(record, Row) and ends(record) for record in records):
            raise KeyboardInterrupt
        put(store, *records)

    with monkeypatch.context() as patch:
        patch.setattr(Store, "put", stopping)
        with pytest.raises(KeyboardInterrupt):
            begin()


def verdict_of(study: ConvergenceStudy) -> Verdict:
    """Run the ladder of one method to its end."""
    return run_and_judge(study, InProcess())


def numbers_of(points: Iterable[Row]) -> list[dict[str, object]]:
    """All that is kept of points, which have no arrays."""
    return [vars(point) for point in points]
