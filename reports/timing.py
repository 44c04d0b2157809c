"""Times the steps of a scene's methods and stores what they cost, once all runs are done."""

from collections.abc import Callable

from ..scenarios import Scenario
from .choice import Choice
from .cost import measure
from .environment import processor
from .plan import can_be_timed
from .records import Key
from .store import Store
from .workers import Workers


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
    progress("; ".join([f"{scenario.name}  timed", *complaints]))
