"""Times the steps of a scene's methods after all runs, and stores the costs."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from ...engines import Engine, Method
from ...scenarios import Scenario
from ..results.cost_records import MethodCost
from ..results.environment import processor
from ..results.store import Store
from .choice import Choice
from .effects_cost import effects_costs, first_pass_costs
from .executors import CallFailed, Executor
from .instructions import instructions_per_step
from .plan import SceneLeft, can_be_timed, settled_verdicts
from .step_cost import TimingRefused, measure, timed, timed_timestep


def time_scene(
    scene: SceneLeft,
    choice: Choice,
    store: Store,
    executor: Executor,
    progress: Callable[[str], None],
) -> None:
    """Time what a scene leaves out, then every method that can simulate it, in one call.

    All methods are timed, interleaved, even if only one is missing: times taken at different
    moments cannot be compared. Times are stored last, so a scene with times is complete; if the
    machine prevented the timing, the next run repeats it.
    """
    try:
        complaints = _time_scene(scene, choice, store, executor)
    except TimingRefused as refused:
        progress(f"{scene.scenario.name}  not timed, the same command times it: {refused}")
    else:
        progress("; ".join([f"{scene.scenario.name}  timed", *complaints]))


def _time_scene(
    scene: SceneLeft, choice: Choice, store: Store, executor: Executor
) -> Sequence[str]:
    scenario = scene.scenario
    _time_left_out(effects_costs, scenario, choice, store, executor)
    if scene.by_pass:
        _time_left_out(first_pass_costs, scenario, choice, store, executor)
    verdicts = {verdict.key: verdict for verdict in settled_verdicts(scenario, choice, store)}
    pairs = {
        key: pair
        for key, pair in choice.methods_on(scenario).items()
        if can_be_timed(scenario, pair, verdicts.get(key))
    }
    costs, complaints = measure(executor, scenario, list(pairs.values())) if pairs else ([], [])
    for (key, (engine, method)), cost in zip(pairs.items(), costs, strict=True):
        if choice.counted and cost is not None:
            count = instructions_per_step(scenario, engine, method, timed_timestep(scenario))
            cost = replace(cost, instructions_per_step=count)
        store.put(MethodCost(key, processor(), cost))
    return complaints


def _time_left_out(
    call: Callable[[Scenario, Engine, list[Method]], list[Any]],
    scenario: Scenario,
    choice: Choice,
    store: Store,
    executor: Executor,
) -> None:
    """Time what each engine leaves out of a scene."""
    methods: dict[str, tuple[Engine, list[Method]]] = {}
    for engine, method in choice.methods_on(scenario).values():
        if method.reader:
            continue
        methods.setdefault(engine.name, (engine, []))[1].append(method)
    for engine, chosen in methods.values():
        costs = timed(executor.call_at(engine.site, call, scenario, engine, chosen))
        for one in [] if isinstance(costs, CallFailed) else costs:
            store.put(one)
