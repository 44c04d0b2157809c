"""Times the steps of a scene's methods after all runs, and stores the costs."""

from collections.abc import Callable, Sequence

from ...results.cost_records import MethodCost
from ...results.environment import processor
from ...results.records import Key, variation
from ...results.store import Store
from ..choice import Choice, EngineMethod
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
    """Measure and store the cost of a step of every method that can simulate a scene.

    Some methods are timed a second time, with the parts of a step that they leave out by default
    (`left_out.with_all_left_in`).

    All methods are timed again, interleaved, even if the cost of only one is missing, as times
    taken at different moments cannot be compared. All costs are stored together at the end. If the
    machine prevented the timing, nothing is stored, and the next study repeats it.

    Parameters
    ----------
    choice : the engines and methods that are run
    progress : called with a sentence on how the timing ended
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
    """Time a scene and store its costs; return a sentence on each method that could not be timed.

    The methods are those of `choice` for the scene. It raises `TimingRefused`, and stores nothing,
    if the machine prevented the timing.
    """
    scenario = scene.scenario
    verdicts = {verdict.key: verdict for verdict in settled_verdicts(scenario, choice, store)}
    pairs = [
        pair
        for key, pair in choice.methods_on(scenario).items()
        if can_be_timed(scenario, pair, verdicts.get(key))
    ]
    apart: dict[EngineMethod, tuple[float, float] | CallFailed | None] = dict.fromkeys(pairs)
    for whole, method in with_all_left_in(scenario, pairs):
        found = timed(executor.call_at(whole.site, motions_apart, scenario, whole, method.name))
        apart[whole, method] = found
    costs, complaints = measure(executor, scenario, [*apart]) if apart else ([], [])
    made = []
    for ((engine, method), compared), cost in zip(apart.items(), costs, strict=True):
        until, difference = (None, None) if isinstance(compared, CallFailed | None) else compared
        key, varied = Key(scenario.name, engine.name, method.name), variation(engine.varied)
        made.append(MethodCost(key, processor(), cost, varied, difference, until))
    store.put(*made)
    return complaints
