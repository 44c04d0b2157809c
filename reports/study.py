"""Runs the grid: scenes × engines × methods × timesteps, each run in a worker of its own."""

from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..engines import Engine, Method, Run
from ..reference import Solution, solve
from ..scenarios import Scenario
from .cost import step_costs
from .descent import Descent, Single
from .environment import environment
from .ladder import MAX_STEPS, Rung, ladder, single
from .records import Key, Row, Verdict
from .store import Store
from .workers import Lost, Workers

Progress = Callable[[str], None]


@dataclass(frozen=True)
class Choice:
    """Which part of the grid to run; empty means all.

    Attributes
    ----------
    timesteps : s; the ladder is run where there are none
    """

    engines: tuple[Engine, ...]
    methods: tuple[str, ...] = ()
    timesteps: tuple[float, ...] = ()
    max_steps: int = MAX_STEPS

    def pairs(self) -> list[tuple[Engine, Method]]:
        """Every engine and method chosen."""
        return [
            (engine, method)
            for engine in self.engines
            for method in engine.methods
            if not self.methods or method.name in self.methods
        ]


@dataclass(frozen=True, eq=False)
class Prepared:
    """A scene's truth on its ladder, and on the single timesteps asked for."""

    solution: Solution
    rungs: list[Rung]
    singles: list[tuple[Rung, Solution]]


def prepare(scenario: Scenario, timesteps: Sequence[float], max_steps: int) -> Prepared:
    """Solve a scene at the sample times of its ladder and of every single timestep."""
    rough = solve(scenario, scenario.times)
    rungs = ladder(rough.trajectory, max_steps)
    solution = solve(scenario, _times(rungs[0]))
    within = len(solution.trajectory.t)
    rungs = [Rung(rung.timestep, rung.sample_steps[:within]) for rung in rungs]
    wanted = [single(dt, rough.trajectory.t) for dt in timesteps]
    return Prepared(solution, rungs, [(rung, solve(scenario, _times(rung))) for rung in wanted])


def simulate(engine: Engine, scenario: Scenario, method: str, rung: Rung) -> Run:
    """One run, in a worker."""
    return engine.run(scenario, engine.method(method), rung.timestep, rung.sample_steps)


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
    rungs = [] if timesteps else prepared.rungs
    return Descent(scenario, engine, method, prepared.solution, rungs, singles)


def run_study(
    scenarios: Sequence[Scenario],
    choice: Choice,
    store: Store,
    jobs: int,
    progress: Progress,
) -> None:
    """Run every scene and store each row as it ends, then the verdicts, then what a step costs."""
    store.put_environment(environment(choice.engines))
    with Workers(jobs) as workers:
        grid = _Grid(choice, store, workers, progress)
        for scenario in scenarios:
            grid.start(scenario)
        grid.drain()
    # Nothing else runs while steps are timed.
    with Workers(jobs=1) as workers:
        for scenario in scenarios:
            _time_steps(scenario, choice, store, workers, progress)


def _time_steps(
    scenario: Scenario, choice: Choice, store: Store, workers: Workers, progress: Progress
) -> None:
    """Time the methods that can simulate a scene, interleaved, in one worker."""
    pairs = [
        (engine, method.name)
        for engine, method in choice.pairs()
        if not engine.unsupported(scenario, method)
    ]
    costs = workers.result(workers.submit(step_costs, scenario, pairs))
    if isinstance(costs, Lost):
        progress(f"{scenario.name}: steps could not be timed: {costs.reason}")
        return
    for (engine, method), cost in zip(pairs, costs, strict=True):
        if cost is not None:
            key = Key(scenario.name, engine.name, method)
            store.put_cost(key, cost.seconds_per_step, cost.spread)
    progress(f"{scenario.name}  timed")


class _Grid:
    """The runs under way, and what to do when each ends."""

    def __init__(self, choice: Choice, store: Store, workers: Workers, progress: Progress) -> None:
        self._choice = choice
        self._store = store
        self._workers = workers
        self._progress = progress
        self._waiting: dict[Future[Any], Callable[[Any], None]] = {}

    def start(self, scenario: Scenario) -> None:
        """Solve the scene, and start its runs when that is done."""
        timesteps = {*self._choice.timesteps, *(e.timestep for e in scenario.expect)}
        self._submit(
            lambda result: self._prepared(scenario, result),
            prepare,
            scenario,
            sorted(timesteps),
            self._choice.max_steps,
        )

    def drain(self) -> None:
        """Run until nothing is under way."""
        while self._waiting:
            done, _ = wait(self._waiting, return_when=FIRST_COMPLETED)
            for future in done:
                self._waiting.pop(future)(self._workers.result(future))

    def _submit(self, then: Callable[[Any], None], call: Callable[..., Any], *args: Any) -> None:
        self._waiting[self._workers.submit(call, *args)] = then

    def _prepared(self, scenario: Scenario, prepared: Prepared | Lost) -> None:
        pairs = self._choice.pairs()
        if isinstance(prepared, Lost):
            for engine, method in pairs:
                key = Key(scenario.name, engine.name, method.name)
                reason = f"the reference could not be solved: {prepared.reason}"
                self._store.put_row(Row(key, engine.version, 0.0, "failed", reason))
                self._finish(Verdict(key, "failed", reason))
            return
        self._store.put_scene(scenario, prepared.solution)
        for engine, method in pairs:
            self._descend(descent_of(scenario, engine, method, prepared, self._choice.timesteps))

    def _descend(self, descent: Descent) -> None:
        """Run the next rung, and the one after when that is done, to the verdict."""
        rung = descent.next_rung()
        if rung is None:
            if finest := descent.finest_motion():
                self._store.put_row(finest)
            self._finish(descent.verdict())
            return

        def then(result: Run | Lost) -> None:
            # One motion a method is enough for a report: the finest, stored at the end.
            self._store.put_row(replace(descent.add(result), motion=None))
            self._descend(descent)

        self._submit(then, simulate, descent.engine, descent.scenario, descent.method.name, rung)

    def _finish(self, verdict: Verdict) -> None:
        self._store.put_verdict(verdict)
        key = verdict.key
        self._progress(f"{key.scenario}  {key.engine} {key.method}: {verdict.verdict}")


def _times(rung: Rung) -> np.ndarray[Any, np.dtype[np.float64]]:
    return np.asarray(rung.sample_steps * rung.timestep, dtype=float)
