"""Times the steps of a scene's methods and stores what they cost, once all runs are done."""

from collections.abc import Callable, Sequence

from ..engines import Engine, Method
from ..scenarios import Scenario
from .choice import Choice
from .cost import measure
from .effects_cost import EffectsCost, PassCosts, effects_cost, pass_costs
from .environment import processor
from .plan import can_be_timed
from .records import Key
from .store import Store
from .workers import Lost, Workers


def time_steps(
    scenario: Scenario,
    choice: Choice,
    store: Store,
    workers: Workers,
    progress: Callable[[str], None],
) -> None:
    """Time every method that can simulate a scene, interleaved, in one worker.

    All of them even where one alone is missing: times taken apart are not to be compared.
    """
    verdicts = {v.key: v for v in store.settled(choice.timesteps, choice.max_steps)}
    pairs = {}
    for engine, method in choice.pairs():
        key = Key(scenario.name, engine.name, method.name)
        if can_be_timed(scenario, (engine, method), verdicts.get(key)):
            pairs[key] = (engine, method.name)
    costs, complaints = measure(workers, scenario, list(pairs.values())) if pairs else ([], [])
    for key, cost in zip(pairs, costs, strict=True):
        seconds = (cost.seconds_per_step, cost.spread) if cost else (None, None)
        store.put_cost(key, processor(), *seconds)
    _time_left_out(effects_cost, scenario, choice, store, workers)
    progress("; ".join([f"{scenario.name}  timed", *complaints]))


def time_passes(
    scenarios: Sequence[Scenario], choice: Choice, store: Store, workers: Workers
) -> None:
    """Time what is left out pass by pass, on one scene: a heavy top where there is one."""
    heavy = [scenario for scenario in scenarios if scenario.called_for == {"gravity", "pivot"}]
    _time_left_out(pass_costs, (heavy or scenarios)[0], choice, store, workers)


def _time_left_out(
    call: Callable[[Scenario, Engine, Method], EffectsCost | PassCosts | None],
    scenario: Scenario,
    choice: Choice,
    store: Store,
    workers: Workers,
) -> None:
    """Time what each engine's first method leaves out; its other methods leave out the same."""
    first = {engine.name: (engine, method) for engine, method in reversed(choice.pairs())}
    for engine, method in first.values():
        found = workers.result(workers.submit(call, scenario, engine, method))
        if found is not None and not isinstance(found, Lost):
            store.put_left_out(found)
