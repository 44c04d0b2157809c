"""Runs scenes × engines × methods × encodings at one timestep each, and stores the rows."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial

from .....engines import Engine, Method, Run
from .....engines.encodings import ENCODINGS, EncodedEngine, Encoding
from .....reference import Solution
from .....scenarios import Scenario
from ....results.encoding_records import Beside
from ....results.records import Pair as EngineAndMethod
from ....results.records import Row, variation
from ....results.store import Store
from ...choice import Choice
from ...executors import CallFailed, Executor, may_succeed_if_repeated
from ...ladder import Rung
from ...prepared import Prepared, prepare
from ..defaults import varied_row
from .judged import Judge, Pair

#: The encoding that the others are compared with: the unchanged scene.
PLAIN = ENCODINGS["plain"]
#: Index of the ladder's rung that is run: two halvings below the coarsest, 0.05 rad a step at most.
RUNG = 2


def run_encodings(
    scenarios: Sequence[Scenario],
    choice: Choice,
    names: Sequence[str],
    store: Store,
    executor: Executor,
) -> list[Row]:
    """Run every method on every scene in some encodings; stored runs only if the user asks again.

    Returns the rows, each of which is stored at once.
    """
    rows: list[Row] = []
    for scenario in scenarios if names else ():
        limit = choice.max_steps_on(scenario)
        prepared = executor.call(prepare, scenario, choice.timesteps, limit).value
        if isinstance(prepared, CallFailed) or (chosen := _chosen(prepared)) is None:
            continue
        wanted = [variation({"as": name}) for name in names]
        there: dict[EngineAndMethod, list[Row]] = {}
        for row in [] if choice.again else store.varied(scenario.name):
            is_settled = not may_succeed_if_repeated(row.cause, row.reason, choice.time_limit)
            if is_settled and row.timestep == chosen[0].timestep and row.variation in wanted:
                there.setdefault(row.pair, []).append(row)
        for made in executor.each(_methods(scenario, choice, names, chosen, executor, there)):
            store.put(*made)
            rows += made
    return rows


def _chosen(prepared: Prepared) -> tuple[Rung, Solution] | None:
    """Return the user's first timestep, or one of the ladder, with the exact motion."""
    if prepared.singles:
        return prepared.singles[0]
    rungs = prepared.ladder.rungs
    return (rungs[min(RUNG, len(rungs) - 1)], prepared.solution) if rungs else None


def _methods(
    scenario: Scenario,
    choice: Choice,
    names: Sequence[str],
    chosen: tuple[Rung, Solution],
    executor: Executor,
    there: Mapping[EngineAndMethod, list[Row]],
) -> Iterator[Callable[[], list[Row]]]:
    """Yield a task for each method; first, all methods of an engine run the unchanged scene."""
    rung, solution = chosen
    for engine in choice.engines:
        if engine.of_file or not engine.applies_to(scenario):
            continue
        methods = [
            method
            for chosen_engine, method in choice.pairs()
            if chosen_engine is engine
            and not method.as_shipped
            and not engine.unsupported(scenario, method)
        ]
        stored = {method.name: there.get((engine.name, method.name), []) for method in methods}
        if all(len(rows) == len(names) for rows in stored.values()):
            yield from (partial(list, rows) for rows in stored.values())
            continue
        runner = _Runner(scenario, engine, rung, executor)
        plain = {method.name: runner.run(PLAIN, method.name) for method in methods}
        for method in methods:
            yield partial(_encoded_rows, runner, method, plain, solution, names)


class _Runner:
    """Runs one scene in one engine, at one timestep and its halves."""

    def __init__(self, scenario: Scenario, engine: Engine, rung: Rung, executor: Executor) -> None:
        self.scenario, self.engine, self.rung, self._executor = scenario, engine, rung, executor

    def run(self, encoding: Encoding, method: str, halvings: int = 0) -> Run:
        """Return a run, which has failed if its process was lost."""
        named = (self.engine.name, self.engine.version, method)
        if why_not := encoding.why_not(self.engine, self.scenario):
            return Run(*named, self.rung.timestep, "unsupported", why_not)
        rung = replace(
            self.rung,
            timestep=self.rung.timestep / 2**halvings,
            sample_steps=self.rung.sample_steps << halvings,
        )
        encoded = EncodedEngine(self.engine, encoding.name)
        answer = self._executor.call_at(
            self.engine.site, _simulate, encoded, self.scenario, method, rung
        ).value
        if isinstance(answer, CallFailed):
            return Run(*named, rung.timestep, "failed", answer.reason, answer.cause)
        return answer

    def pair(self, method: str, encoding: Encoding, halvings: int) -> Pair:
        """Return the runs in the encoding and of the unchanged scene."""
        return Pair(self.run(encoding, method, halvings), self.run(PLAIN, method, halvings))


def _simulate(engine: EncodedEngine, scenario: Scenario, method: str, rung: Rung) -> Run:
    """Return one run, in a worker; a difference of the body does not fail it."""
    own = engine.method(method)
    return engine.run(scenario, own, rung.timestep, rung.sample_steps, fails_if_unlike=False)


def _encoded_rows(
    runner: _Runner,
    method: Method,
    plain: dict[str, Run],
    solution: Solution,
    names: Sequence[str],
) -> list[Row]:
    """Return the rows of a method in all encodings that were asked for."""
    scenario, engine, own = runner.scenario, runner.engine, plain[method.name]
    pair_at = partial(runner.pair, method.name)
    judge = Judge(scenario, solution, method.name, engine, pair_at, plain)
    rows = []
    for encoding in (ENCODINGS[name] for name in names):
        if own.outcome != "ok":
            run = Run(engine.name, own.engine_version, method.name, own.timestep, "unsupported")
            beside = Beside("left out", f"the scene as it is {own.outcome}: {own.reason}")
        else:
            run = runner.run(encoding, method.name)
            beside = judge.judged(encoding, Pair(run, own))
        varied = EncodedEngine(engine, encoding.name)
        row = varied_row(scenario, varied, run, runner.rung, solution)
        rows.append(replace(row, beside=beside))
    return rows
