"""Runs methods of engines on scenes, judges them by the exact motions, and stores the results.

Every result is stored as soon as it is made, and stored results are not made again: a study that
was stopped at any moment continues when it is started again. `study_method` runs one method on one
scene.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial

from ...engines import Engine, Method, Run
from ...engines.engine import clamped_start
from ...scenarios import Scenario
from ..results.environment import environment
from ..results.evidence import Evidence
from ..results.records import UNSOLVED, Key, Row
from ..results.store import Store
from ..results.verdicts import Verdict
from .choice import Choice
from .convergence_study import ConvergenceStudy, PlannedRun
from .costs.timing import time_scene
from .executors import CallFailed, Executor, cause_of_unsolved, may_succeed_if_repeated
from .executors.compiling import compile_side_by_side
from .judging import judge
from .measuring.examine import examine_or_refuse
from .measuring.replay import examine_runs
from .plan import Plan
from .prepared import Prepared, SceneReference
from .timesteps.ladder import Rung
from .timesteps.stock import stock_runs_of
from .varied.defaults import runs_with_defaults

Progress = Callable[[str], None]


def run_study(
    left: Plan, choice: Choice, store: Store, executor: Executor, progress: Progress
) -> None:
    """Make the missing verdicts on all scenes, then measure the missing costs of steps.

    Nothing else runs while steps are timed. Each row, verdict and cost is stored as soon as it is
    made.

    Parameters
    ----------
    left : the missing results
    choice : what the user asked for: engines, methods, timesteps and limits
    progress : called with a sentence on each verdict and each timing
    """
    store.put_environment(environment(choice.engines, choice.max_steps))
    store.put_methods(choice.engines)
    if left.scenes:
        compile_side_by_side(executor)
    tasks = (
        partial(study_method, scene.scenario, engine, method, reference, choice, store, executor)
        for scene in left.scenes
        for reference in [SceneReference(scene.scenario, choice)]
        for engine, method in scene.to_run
    )
    for verdict in executor.each(tasks):
        key = verdict.key
        progress(f"{key.scenario}  {key.engine} {key.method}: {verdict.verdict}")
    alone = executor.alone()
    for scene in left.scenes:
        if scene.to_time:
            time_scene(scene, choice, store, alone, progress)


def study_method(
    scenario: Scenario,
    engine: Engine,
    method: Method,
    reference: SceneReference,
    choice: Choice,
    store: Store,
    executor: Executor,
) -> Verdict:
    """Run one method on one scene, store the verdict, and return it.

    Stored runs that suffice are not made again. If the exact motion cannot be found, the verdict is
    `failed`.

    Parameters
    ----------
    reference : the scene's exact motion, which all methods share; it is solved if it is not yet
    choice : what the user asked for: timesteps and limits
    """
    key = Key(scenario.name, engine.name, method.name)
    solved = reference.get(executor, store)
    if isinstance(solved, CallFailed):
        return _verdict_of_unsolved(key, engine, solved, choice, store)
    begin = partial(convergence_study_of, scenario, engine, method, solved, choice.timesteps)
    stored = {
        row.timestep: row
        for row in store.rows_of(key)
        if not may_succeed_if_repeated(row.cause, row.reason, choice.time_limit)
    }
    # Stored runs are judged again from the evidence that is stored with them.
    before = store.evidence(key)
    if before and may_succeed_if_repeated(before.cause, before.refusal, choice.time_limit):
        before = None
    study = begin(before)
    if not is_run(study, stored):
        study = begin(None)
        # The evidence of steps from exact states does not depend on the ladder, and is kept.
        study.steps = before.steps if before else None
        for row in run_rungs(study, executor, stored):
            store.put(row)
        _run_with_some_defaults(study, executor, store)
    store.put(*study.refusals())
    verdict = judge(study.records)
    step_limit = choice.max_steps_on(scenario) if study.cut_short else None
    verdict = replace(verdict, timesteps=tuple(sorted(choice.timesteps)), step_limit=step_limit)
    store.put_verdict(verdict, study.evidence, study.discardable_timesteps())
    return verdict


def _run_with_some_defaults(study: ConvergenceStudy, executor: Executor, store: Store) -> None:
    """Make and store runs with different sets of an engine's defaults, to find what each does.

    A default is something that the engine does to motions unless it is told not to, such as
    damping. The sets are: none of the defaults, each of them alone, and all but one, for each.

    The runs are made at the longest stock timestep that suits the scene, and only if the method is
    the engine's first one as shipped. Nothing is stored if the engine has no defaults, if it would
    limit the turn in the first step (`clamped_start`), or if the call fails.
    """
    scenario, engine, method = study.scenario, study.engine, study.method
    first = next((other for other in engine.methods if other.as_shipped), None)
    made = [(run.rung, run.solution) for run in study.stock if run.rung and run.solution]
    if not made or method != first or not engine.defaults(scenario, method):
        return
    rung, solution = max(made, key=lambda run: run[0].timestep)
    if clamped_start(scenario, method, rung.timestep):
        return
    # The report's first screen, which counts the defaults that act, only uses plain scenes.
    at = None if scenario.hard else study.places
    arguments = (scenario, engine, method.name, rung, solution, at)
    rows = executor.call_at(engine.site, runs_with_defaults, *arguments).value
    if not isinstance(rows, CallFailed):
        store.put(*rows)


def is_run(study: ConvergenceStudy, stored: Mapping[float, Row]) -> bool:
    """Return whether the evidence and all runs of a study are stored.

    Stored rows are added to the study, up to the first that is missing or does not suffice
    (`PlannedRun.is_answered_by`).

    Parameters
    ----------
    stored : stored rows, by timestep, s
    """
    if study.before is None:
        return False
    runs = study.runs()
    with suppress(StopIteration):
        planned = next(runs)
        while (row := stored.get(planned.rung.timestep)) and planned.is_answered_by(row):
            planned = runs.send(row)
        return False
    return True


def run_and_judge(study: ConvergenceStudy, executor: Executor) -> Verdict:
    """Make all runs of a method, and return the verdict, without storing anything."""
    for _ in run_rungs(study, executor):
        pass
    return judge(study.records)


def run_rungs(
    study: ConvergenceStudy, executor: Executor, stored: Mapping[float, Row] | None = None
) -> Iterator[Row]:
    """Make the runs of a study in order, and measure the evidence, until the method can be judged.

    Parameters
    ----------
    stored : stored rows, by timestep, s; a run is not made again if its row suffices
        (`PlannedRun.is_answered_by`)

    Yields
    ------
    The rows of the runs made now, each compared with the exact motion
    """
    scenario, engine, method = study.scenario, study.engine, study.method
    if not engine.unsupported(scenario, method):
        _examine(study, executor)
    runs = study.runs()
    with suppress(StopIteration):
        planned = next(runs)
        while True:
            rung = planned.rung
            row = (stored or {}).get(rung.timestep)
            if row is None or not planned.is_answered_by(row):
                answer = executor.call_at(
                    engine.site, simulate, engine, scenario, method.name, rung
                )
                row = study.compare(planned, answer)
                yield row
            planned = runs.send(row)
    _examine_runs(study, executor)


def convergence_study_of(
    scenario: Scenario,
    engine: Engine,
    method: Method,
    prepared: Prepared,
    timesteps: Sequence[float] = (),
    before: Evidence | None = None,
) -> ConvergenceStudy:
    """Return the study of a method on a scene, before its first run.

    Parameters
    ----------
    prepared : the exact motion and the timesteps of all runs on the scene
    timesteps : the timesteps asked for, s. If there are any, runs are made only at these, and at
        timesteps with expectations; else at those with expectations, on the ladder, and at stock
        timesteps
    before : the stored evidence that the method was judged by before; None if there is none
    """
    singles = []
    for rung, solution in prepared.singles:
        run = (engine.name, method.name, rung.timestep)
        expectations = tuple(e for e in scenario.expect if (e.engine, e.method, e.timestep) == run)
        if expectations or rung.timestep in timesteps:
            singles.append(PlannedRun(rung, solution, "single", expectations=expectations))
    return ConvergenceStudy(
        scenario,
        engine,
        method,
        prepared.solution,
        None if timesteps else prepared.ladder,
        singles,
        [] if timesteps else stock_runs_of(engine, scenario, prepared.stock),
        before,
        places=prepared.places,
        steps=before.steps if before else None,
    )


def simulate(engine: Engine, scenario: Scenario, method: str, rung: Rung) -> Run:
    """Return a run of a method at the timestep and the samples of a rung, made in this process."""
    return engine.run(scenario, engine.method(method), rung.timestep, rung.sample_steps)


def _examine(study: ConvergenceStudy, executor: Executor) -> None:
    """Examine the method's single steps from exact states, by a call of the executor.

    The evidence, or why there is none, is set in the study. Nothing is done if single steps are not
    tested, or if their evidence is known already.
    """
    at, site = study.places, study.engine.site
    if at is not None and study.steps is None:
        arguments = (study.engine, study.scenario, study.method.name, at)
        found = executor.call_at(site, examine_or_refuse, *arguments).value
        if isinstance(found, CallFailed):
            study.refusal = found
        else:
            study.steps, study.refusal = found


def _examine_runs(study: ConvergenceStudy, executor: Executor) -> None:
    """Replay the ladder's finest run and other runs, by a call of the executor.

    The evidence, or why there is none, is set in the study. Nothing is replayed if single steps
    show a fault or could not be examined.
    """
    at, steps, site = study.places, study.steps, study.engine.site
    ladder, others = study.made_runs
    if at is None or steps is None or steps.fault:
        return
    arguments = (study.engine, study.scenario, study.method.name, at, steps, ladder, others)
    found = executor.call_at(site, examine_runs, *arguments).value
    if isinstance(found, CallFailed):
        study.refusal = found
    else:
        study.replays, study.own_steps, study.refusal = found


def _verdict_of_unsolved(
    key: Key, engine: Engine, failure: CallFailed, choice: Choice, store: Store
) -> Verdict:
    """Return a `failed` verdict, which says that the exact motion could not be found.

    The verdict is stored, and so is a row with the same reason.

    Parameters
    ----------
    key : names of scene, engine and method
    failure : why the call that should find the exact motion failed
    choice : what the user asked for; the verdict states its timesteps
    """
    reason = f"the exact motion could not be found: {failure.reason}"
    store.put(Row(key, engine.version, UNSOLVED, "failed", reason, cause_of_unsolved(failure)))
    verdict = Verdict(key, "failed", reason, timesteps=tuple(sorted(choice.timesteps)))
    store.put_verdict(verdict)
    return verdict
