"""Times the steps of a scene's methods after all runs, and stores the costs."""

from collections.abc import Callable, Sequence

from ...results.cost_records import MethodCost
from ...results.environment import processor
from ...results.records import Key, variation
from ...results.store import Store
from ..choice import Choice
from ..executors import CallFailed, Executor
from ..plan import SceneLeft, can_be_timed, settled_verdicts
from .left_out import motions_apart, with_all_left_in
from .step_cost import TimingRefused, measure, timed


def time_scene(
    scene: SceneLeft,
    choice: Choice,
    store: Store,
    executor: Executor,
    progress: Callable[[str], None],
) -> None:
    """Time in one call every method that can simulate a scene, some also with all left in.

    All methods are timed, interleaved, even if only one has no time yet: times taken at different
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
    verdicts = {verdict.key: verdict for verdict in settled_verdicts(scenario, choice, store)}
    pairs = [
        pair
        for key, pair in choice.methods_on(scenario).items()
        if can_be_timed(scenario, pair, verdicts.get(key))
    ]
    whole = with_all_left_in(scenario, pairs)
    apart = [
        timed(executor.call_at(engine.site, motions_apart, scenario, engine, method.name))
        for engine, method in whole
    ]
    of_motions, pairs = [*([None] * len(pairs)), *apart], [*pairs, *whole]
    costs, complaints = measure(executor, scenario, pairs) if pairs else ([], [])
    made = []
    for (engine, method), cost, found in zip(pairs, costs, of_motions, strict=True):
        until, difference = (None, None) if isinstance(found, CallFailed | None) else found
        key, varied = Key(scenario.name, engine.name, method.name), variation(engine.varied)
        made.append(MethodCost(key, processor(), cost, varied, difference, until))
    store.put(*made)
    return complaints
