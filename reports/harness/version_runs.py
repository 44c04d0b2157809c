"""Runs one version of an engine on a scene: a run, a verdict on a ladder, the time of a step."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...engines import Engine, Method, Run
from ...reference import Solution, solve
from ...scenarios import Errors, Scenario, Trajectory, errors_between
from ..results.records import Verdict
from .choice import QUICK_STEPS
from .executors import CallFailed, Executor
from .ladder import Rung, single
from .step_cost import step_costs
from .study import Prepared, convergence_study_of, prepare, run_rungs, simulate
from .study_verdict import verdict_on

#: Rounds in which versions are timed in turn.
ROUNDS = 5


@dataclass(frozen=True, eq=False)
class VersionRun:
    """A method on a scene, in one version.

    Attributes
    ----------
    outcome, reason : of the run at the timestep asked for
    motion, errors : of that run; None if it did not finish
    verdict : of a short ladder
    seconds : CPU seconds a step, round by round; empty if it could not be timed
    """

    version: str
    outcome: str
    reason: str
    motion: Trajectory | None
    errors: Errors | None
    verdict: Verdict
    seconds: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class SolvedScene:
    """A scene with its exact motion, at the timestep asked for and down a ladder."""

    scenario: Scenario
    rung: Rung
    solution: Solution
    prepared: Prepared


def solved(scenario: Scenario, timestep: float) -> SolvedScene:
    """Solve a scene for runs at a timestep, s, and for short ladders."""
    rung = single(timestep, scenario.times)
    solution = solve(scenario, np.asarray(rung.sample_steps * timestep, dtype=float))
    ended = rung.until(len(solution.trajectory.t))
    return SolvedScene(scenario, ended, solution, prepare(scenario, [], QUICK_STEPS))


def version_runs(
    engines: Sequence[Engine], method: Method, scene: SolvedScene, executor: Executor
) -> list[VersionRun]:
    """Run a method in every version, and time versions in turn."""
    runs = [_run(engine, method, scene, executor) for engine in engines]
    verdicts = [_verdict(engine, method, scene, executor) for engine in engines]
    seconds = _seconds(engines, method, scene.scenario, executor)
    return [
        _version_run(engine, scene, run, verdict, times)
        for engine, run, verdict, times in zip(engines, runs, verdicts, seconds, strict=True)
    ]


def _version_run(
    engine: Engine,
    scene: SolvedScene,
    run: Run | CallFailed,
    verdict: Verdict,
    seconds: Sequence[float],
) -> VersionRun:
    outcome = "failed" if isinstance(run, CallFailed) else run.outcome
    motion = run.trajectory if isinstance(run, Run) and run.outcome == "ok" else None
    errors = None
    if motion is not None:
        errors = errors_between(scene.scenario, motion, scene.solution.trajectory)
    timed = tuple(seconds) if len(seconds) == ROUNDS else ()
    return VersionRun(engine.version, outcome, run.reason, motion, errors, verdict, timed)


def _run(
    engine: Engine, method: Method, scene: SolvedScene, executor: Executor
) -> Run | CallFailed:
    return executor.call_at(
        engine.site, simulate, engine, scene.scenario, method.name, scene.rung
    ).value


def _verdict(engine: Engine, method: Method, scene: SolvedScene, executor: Executor) -> Verdict:
    """The verdict on a short ladder, with the orders that this version declares."""
    own = engine.method(method.name)
    study = convergence_study_of(scene.scenario, engine, own, scene.prepared)
    for _ in run_rungs(study, executor):
        pass
    return verdict_on(study)


def _seconds(
    engines: Sequence[Engine], method: Method, scenario: Scenario, executor: Executor
) -> list[list[float]]:
    """CPU seconds a step of each version, round by round; versions in turn."""
    times: list[list[float]] = [[] for _ in engines]
    for _ in range(ROUNDS):
        for engine, seconds in zip(engines, times, strict=True):
            pairs = [(engine, method)]
            costs = executor.call_at(engine.site, step_costs, scenario, pairs).value
            if not isinstance(costs, CallFailed) and costs[0] is not None:
                seconds.append(costs[0].seconds_per_step)
    return times
