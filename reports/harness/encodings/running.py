"""Runs scenes × engines × methods × encodings at one timestep each, and stores what came of it."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial

from ....engines import Engine, Method, Run
from ....engines.encodings import ENCODINGS, EncodedEngine, Encoding
from ....reference import Solution
from ....scenarios import Scenario
from ...results.encoding_records import EncodedRuns
from ...results.records import Key
from ...results.store import Store
from ..choice import Choice
from ..executors import CallFailed, Executor
from ..ladder import Rung
from ..prepared import Prepared, prepare
from .judged import Judge, Pair

#: The encoding that the others are compared with.
PLAIN = ENCODINGS["plain"]
#: Of a ladder, the rung that is run: two halvings below the coarsest, 0.05 rad a step at most.
RUNG = 2


def run_encodings(
    scenarios: Sequence[Scenario],
    choice: Choice,
    names: Sequence[str],
    store: Store,
    executor: Executor,
) -> list[EncodedRuns]:
    """Run every method on every scene in these encodings; each result is stored at once."""
    made = []
    for scenario in scenarios:
        limit = choice.max_steps_on(scenario)
        prepared = executor.call(prepare, scenario, choice.timesteps, limit).value
        if isinstance(prepared, CallFailed) or (chosen := _chosen(prepared)) is None:
            continue
        for runs in executor.each(_methods(scenario, choice, names, chosen, executor)):
            store.put(runs)
            made.append(runs)
    return made


def _chosen(prepared: Prepared) -> tuple[Rung, Solution] | None:
    """The timestep asked for, the first of several, or one of the ladder."""
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
) -> Iterator[Callable[[], EncodedRuns]]:
    """One task for each method; the scene as it is is run by all methods of an engine first."""
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
        runner = _Runner(scenario, engine, rung, executor)
        plain = {method.name: runner.run(PLAIN, method.name) for method in methods}
        for method in methods:
            yield partial(_encoded_runs, runner, method, plain, solution, names)


class _Runner:
    """Runs one scene in one engine, at one timestep and its halves."""

    def __init__(self, scenario: Scenario, engine: Engine, rung: Rung, executor: Executor) -> None:
        self.scenario, self.engine, self.rung, self._executor = scenario, engine, rung, executor

    def run(self, encoding: Encoding, method: str, halvings: int = 0) -> Run:
        """A run; one whose process is lost has failed."""
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
        """The encoding and the scene as it is."""
        return Pair(self.run(encoding, method, halvings), self.run(PLAIN, method, halvings))


def _simulate(engine: EncodedEngine, scenario: Scenario, method: str, rung: Rung) -> Run:
    """One run, in a worker: of a body held otherwise, the motion is wanted too."""
    own = engine.method(method)
    return engine.run(scenario, own, rung.timestep, rung.sample_steps, fails_if_unlike=False)


def _encoded_runs(
    runner: _Runner,
    method: Method,
    plain: dict[str, Run],
    solution: Solution,
    names: Sequence[str],
) -> EncodedRuns:
    """A method's answers to all encodings that were asked for."""
    scenario, engine, own = runner.scenario, runner.engine, plain[method.name]
    key = Key(scenario.name, engine.name, method.name)
    record = EncodedRuns(key, own.engine_version, runner.rung.timestep, ())
    if own.outcome != "ok":
        return replace(record, plain=f"{own.outcome}: {own.reason}")
    judge = Judge(
        scenario,
        solution,
        method.name,
        engine,
        partial(runner.pair, method.name),
        plain,
    )
    encodings = [ENCODINGS[name] for name in names]
    pairs = [Pair(runner.run(encoding, method.name), own) for encoding in encodings]
    each = map(judge.judged, encodings, pairs)
    return replace(record, each=tuple(each))
