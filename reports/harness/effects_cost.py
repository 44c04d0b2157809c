"""Measures the cost and the effect of the passes that a scene does not call for."""

import math
from collections.abc import Callable, Sequence
from functools import partial
from statistics import median

import numpy as np

from ...engines import Engine, EngineError, Method, Session
from ...engines.fault import ENVIRONMENTAL
from ...scenarios import FloatArray, Scenario
from ..results.cost_records import EffectsCost, PassCost, PassCosts, Ratio
from ..results.records import Key
from .step_cost import TimingSample, interleaved, timed_timestep

#: Angle turned in a step at the start, rad, where motions are compared: small for any method.
COMPARED_TURN = 0.05
#: Largest number of steps of that comparison.
MOST_STEPS = 1 << 13
#: Number of times at which the two motions are compared.
COMPARED = 16
#: Number of equal sessions timed beside the passes: their differences are the noise.
CONTROLS = 3


def effects_costs(
    scenario: Scenario, engine: Engine, methods: Sequence[Method]
) -> list[EffectsCost]:
    """Time every distinct set of passes left out of a scene.

    Of the methods that leave out the same, the first is timed, and one of the highest order, which
    reports recommend.
    """
    alike: dict[tuple[str, ...], list[Method]] = {}
    for method in _able(scenario, engine, methods):
        alike.setdefault(engine.left_out(scenario, method), []).append(method)
    timed = {
        method.name: method
        for group in alike.values()
        for method in (group[0], max(group, key=lambda one: one.order))
    }
    costs = (effects_cost(scenario, engine, method) for method in timed.values())
    return [one for one in costs if one is not None]


def first_pass_costs(
    scenario: Scenario, engine: Engine, methods: Sequence[Method]
) -> list[PassCosts]:
    """Time each pass left out, by the first method that can simulate the scene."""
    costs = (pass_costs(scenario, engine, m) for m in _able(scenario, engine, methods)[:1])
    return [one for one in costs if one is not None]


def _able(scenario: Scenario, engine: Engine, methods: Sequence[Method]) -> list[Method]:
    return [method for method in methods if not engine.unsupported(scenario, method)]


def effects_cost(scenario: Scenario, engine: Engine, method: Method) -> EffectsCost | None:
    """Time a method with and without what it leaves out, and compare the motions.

    None if nothing is left out, or if one of the two does not load or step.
    """
    left_out = engine.left_out(scenario, method)
    if not left_out or engine.unsupported(scenario, method):
        return None
    timestep = timed_timestep(scenario)
    pruned, unpruned = interleaved(
        [
            partial(engine.open, scenario, method, timestep),
            partial(engine.open_with, scenario, method, timestep, left_in=left_out),
        ]
    )
    if not pruned or not unpruned:
        return None
    compared = _compared_steps(scenario)
    until, difference = _difference(scenario, engine, method, compared)
    return EffectsCost(
        Key(scenario.name, engine.name, method.name),
        left_out,
        _least(pruned),
        _least(unpruned),
        _ratio(unpruned, pruned),
        scenario.window.duration / compared,
        until,
        difference,
    )


def pass_costs(scenario: Scenario, engine: Engine, method: Method) -> PassCosts | None:
    """Time a method with each pass that it leaves out alone, and with all passes but that one.

    None where nothing is left out.
    """
    names = engine.left_out(scenario, method)
    if not names or engine.unsupported(scenario, method):
        return None
    timestep = timed_timestep(scenario)

    def opening(left_in: Sequence[str]) -> Callable[[], Session]:
        return partial(engine.open_with, scenario, method, timestep, left_in=left_in)

    others = [[other for other in names if other != name] for name in names]
    groups: list[Sequence[Sequence[str]]] = [
        CONTROLS * [()],
        CONTROLS * [names],
        [(name,) for name in names],
        others,
    ]
    timed = interleaved([opening(left_in) for group in groups for left_in in group])
    if not all(timed):
        return None
    seconds = iter(_least(stretches) for stretches in timed)
    bare, whole, alone, without = ([next(seconds) for _ in group] for group in groups)
    pruned, unpruned = median(bare), median(whole)
    return PassCosts(
        Key(scenario.name, engine.name, method.name),
        pruned,
        max(max(control) - min(control) for control in (bare, whole)) / pruned,
        tuple(
            PassCost(name, (added - pruned) / pruned, (unpruned - saved) / pruned)
            for name, added, saved in zip(names, alone, without, strict=True)
        ),
    )


def _compared_steps(scenario: Scenario) -> int:
    """Steps over the window, a whole number of times `COMPARED`."""
    turned = float(np.linalg.norm(scenario.start.omega_body)) * scenario.window.duration
    wanted = min(turned / COMPARED_TURN, MOST_STEPS)
    return COMPARED * max(1, math.ceil(wanted / COMPARED))


def _difference(
    scenario: Scenario, engine: Engine, method: Method, steps: int
) -> tuple[float, float]:
    """The time, s, up to which the two motions were compared, and the largest difference."""
    timestep = scenario.window.duration / steps
    left_out = engine.left_out(scenario, method)
    largest = 0.0
    with (
        engine.open(scenario, method, timestep) as pruned,
        engine.open_with(scenario, method, timestep, left_in=left_out) as unpruned,
    ):
        for sample in range(1, COMPARED + 1):
            try:
                states = [_stepped(session, steps // COMPARED) for session in (pruned, unpruned)]
            except EngineError as error:
                if error.cause in ENVIRONMENTAL:
                    raise
                return (sample - 1) * steps // COMPARED * timestep, largest
            largest = max(largest, float(np.abs(states[0] - states[1]).max()))
    return scenario.window.duration, largest


def _stepped(session: Session, steps: int) -> FloatArray:
    """All numbers of the state some steps on, (13,)."""
    session.advance(steps)
    session.check()
    return np.concatenate(list(vars(session.read_state()).values()))


def _least(stretches: Sequence[TimingSample]) -> float:
    return min(stretch.cpu for stretch in stretches)


def _ratio(over: Sequence[TimingSample], under: Sequence[TimingSample]) -> Ratio:
    ratios = [a.cpu / b.cpu for a, b in zip(over, under, strict=True)]
    low, middle, high = np.quantile(ratios, (0.25, 0.5, 0.75))
    return Ratio(float(middle), float(high - low))
