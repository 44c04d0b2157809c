"""Runs the grid: scenes × engines × methods × timesteps, in workers, scene by scene.

Whatever ends is stored at once, and whatever is stored is not run again: a study that was stopped
at any moment is gone on with by running it again.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from queue import SimpleQueue
from typing import Any

import numpy as np

from ...engines import Engine, Method, Run
from ...reference import Solution, solve
from ...scenarios import Scenario
from ...scenarios.fastest_rate import pace
from ..results.environment import environment
from ..results.records import UNSOLVED, Key, Row, Verdict
from ..results.store import Store
from .choice import Choice
from .convergence_study import Descent, Single
from .executors.local_workers import Call, Workers
from .executors.worker_slot import Lost, may_end_otherwise
from .ladder import Ladder, Rung, ladder, single
from .plan import Plan, SceneLeft, plan
from .step_cost import one_thread
from .timing import time_scene

#: More than are under way at a time: the methods of the scenes at hand.
MODELS = 64

Progress = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class Prepared:
    """A scene's truth on its ladder, and on the single timesteps asked for."""

    solution: Solution
    ladder: Ladder
    singles: list[tuple[Rung, Solution]]


def prepare(scenario: Scenario, timesteps: Sequence[float], max_steps: int) -> Prepared:
    """Solve a scene at the sample times of its ladder and of every single timestep.

    Where the truth ends at its horizon, so do the runs.
    """
    rough = solve(scenario, scenario.times)
    samples = len(rough.trajectory.t)
    found = ladder(scenario.window, pace(scenario, rough.trajectory), samples, max_steps)
    solution = solve(scenario, found.times)
    singles = []
    for timestep in timesteps:
        rung = single(timestep, rough.trajectory.t)
        truth = solve(scenario, _times(rung))
        singles.append((rung.until(len(truth.trajectory.t)), truth))
    return Prepared(solution, found.until(len(solution.trajectory.t)), singles)


@dataclass(frozen=True)
class _Model:
    """A scene in an engine, by one method; told apart by names and digest."""

    engine_name: str
    method: str
    digest: str
    engine: Engine = field(compare=False)
    scenario: Scenario = field(compare=False)


@lru_cache(maxsize=MODELS)
def _departures(model: _Model) -> str:
    """What is odd about its first steps, whatever the timestep: found out once a process."""
    return model.engine.departures(model.scenario, model.engine.method(model.method))


def simulate(engine: Engine, scenario: Scenario, method: str, rung: Rung) -> Run:
    """One run, in a worker; if it is ok or lags, what is odd about its first steps besides."""
    run = engine.run(scenario, engine.method(method), rung.timestep, rung.sample_steps)
    if not (run.outcome == "ok" or run.cause == "lag"):
        return run
    if not (said := _departures(_Model(engine.name, method, scenario.digest, engine, scenario))):
        return run
    said = "; ".join(filter(None, (run.reason, said)))
    if run.outcome == "ok":
        return replace(run, cause="law", reason=said)
    # What lags however small the step is no clamp.
    return replace(run, outcome="failed", cause="clock", reason=said)


def descent_of(
    scenario: Scenario,
    engine: Engine,
    method: Method,
    prepared: Prepared,
    timesteps: Sequence[float] = (),
) -> Descent:
    """The runs of a method: the timesteps asked for, those promised about, and the ladder.

    Where timesteps are asked for there is no ladder.
    """
    singles = []
    for rung, solution in prepared.singles:
        wanted = (engine.name, method.name, rung.timestep)
        promises = tuple(e for e in scenario.expect if (e.engine, e.method, e.timestep) == wanted)
        if promises or rung.timestep in timesteps:
            singles.append(Single(rung, solution, promises))
    taken = None if timesteps else prepared.ladder
    return Descent(scenario, engine, method, prepared.solution, taken, singles)


def run_study(
    scenarios: Sequence[Scenario],
    choice: Choice,
    store: Store,
    jobs: int,
    progress: Progress,
) -> None:
    """Run what is missing of every scene."""
    carry_out(plan(scenarios, choice, store), choice, store, jobs, progress)


def carry_out(left: Plan, choice: Choice, store: Store, jobs: int, progress: Progress) -> None:
    """Run what is left, storing each row and each verdict as it ends, then time the steps."""
    store.put_environment(environment(choice.engines, choice.max_steps))
    store.put_methods(choice.engines)
    with Workers(jobs, choice.time_limit) as workers:
        grid = _Grid(choice, store, workers, progress)
        for rank, scene in enumerate(left.scenes):
            if scene.to_run:
                grid.start(scene, rank)
        grid.drain()
    # Nothing else runs while steps are timed.
    with one_thread(), Workers(1, choice.time_limit) as workers:
        for scene in left.scenes:
            if scene.to_time:
                time_scene(scene, choice, store, workers, progress)


class _Grid:
    """The runs under way, and what to do when each ends."""

    def __init__(self, choice: Choice, store: Store, workers: Workers, progress: Progress) -> None:
        self._choice = choice
        self._store = store
        self._workers = workers
        self._progress = progress
        self._under_way: dict[Call[Any], Callable[[Call[Any]], None]] = {}
        self._done: SimpleQueue[Call[Any]] = SimpleQueue()

    def start(self, scene: SceneLeft, rank: int) -> None:
        """Solve a scene, and start its runs when that is done; scenes of lower rank go first."""
        promised = {expected.timestep for expected in scene.scenario.expect}
        timesteps = sorted({*self._choice.timesteps, *promised})
        self._submit(
            lambda done: self._prepared(scene, rank, done.outcome()),
            rank,
            prepare,
            scene.scenario,
            timesteps,
            self._choice.max_steps_on(scene.scenario),
        )

    def drain(self) -> None:
        """Run until nothing is under way."""
        while self._under_way:
            done = self._done.get()
            self._under_way.pop(done)(done)

    def _submit(
        self,
        then: Callable[[Call[Any]], None],
        rank: int,
        call: Callable[..., Any],
        *arguments: Any,
    ) -> None:
        future = self._workers.submit_ranked(rank, call, *arguments)
        self._under_way[future] = then
        future.add_done_callback(lambda _: self._done.put(future))

    def _prepared(self, scene: SceneLeft, rank: int, prepared: Prepared | Lost) -> None:
        scenario = scene.scenario
        if isinstance(prepared, Lost):
            for engine, method in scene.to_run:
                key = Key(scenario.name, engine.name, method.name)
                reason = f"the reference could not be solved: {prepared.reason}"
                self._store.put_row(
                    Row(key, engine.version, UNSOLVED, "failed", reason, "unsolved")
                )
                self._finish(Verdict(key, "failed", reason))
            return
        self._store.put_scene(scenario, prepared.solution)
        for engine, method in scene.to_run:
            descent = descent_of(scenario, engine, method, prepared, self._choice.timesteps)
            rows = self._store.rows_of(descent.key)
            limit = self._choice.time_limit
            there = {r.timestep: r for r in rows if not may_end_otherwise(r.reason, limit)}
            self._descend(descent, there, rank)

    def _descend(self, descent: Descent, there: dict[float, Row], rank: int) -> None:
        """Take the rungs that are there already, then run the next one, down to the verdict."""
        while rung := descent.next_rung():
            row = there.get(rung.timestep)
            if row is None or not descent.can_take(row):
                break
            descent.take(row)
        else:
            limit = self._choice.max_steps_on(descent.scenario) if descent.cut_short else None
            self._finish(descent.verdict(), limit, descent.spent())
            return

        def then(done: Call[Any]) -> None:
            row = descent.add(done.outcome(), done.printed)
            self._store.put_row(row)
            self._descend(descent, there | {row.timestep: row}, rank)

        scenario, engine, method = descent.scenario, descent.engine, descent.method.name
        self._submit(then, rank, simulate, engine, scenario, method, rung)

    def _finish(
        self, verdict: Verdict, step_limit: int | None = None, spent: Sequence[float] = ()
    ) -> None:
        self._store.put_verdict(verdict, self._choice.timesteps, step_limit, spent)
        key = verdict.key
        self._progress(f"{key.scenario}  {key.engine} {key.method}: {verdict.verdict}")


def _times(rung: Rung) -> np.ndarray[Any, np.dtype[np.float64]]:
    return np.asarray(rung.sample_steps * rung.timestep, dtype=float)
