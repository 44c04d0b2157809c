"""Finds what runs of a scene cannot test: effects without influence, times after the horizon."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from ....reference import ExactMotion, IntegrationError, solve
from ....scenarios import Errors, Scenario, Signal, errors_between, signals_of
from ....scenarios.effects import Effect
from ....scenarios.scenario import with_tables


def powerless(scenario: Scenario) -> Iterator[str]:
    """Yield a sentence for each effect that can be left out without a change of any signal.

    A change counts if it exceeds twice the uncertainty of the exact motion. Constraints are not
    tested, and neither is an effect if the motion without it cannot be found. There is one more
    sentence if the exact motion is known only in the first part of the window.

    Raises
    ------
    IntegrationError
        If the exact motion cannot be found, or not beyond the first sample.
    """
    present = [effect for effect in scenario.acting if effect.constraint is None]
    if not present:
        return
    solution = solve(scenario, scenario.times)
    solution.require_more_than_the_start()
    exact = solution.trajectory
    if too_long := solution.ends_before(scenario.window.duration):
        yield f"{scenario.name}: {too_long}"
    for effect in present:
        try:
            without_it = _without(scenario, effect)
            other = ExactMotion(without_it).outline(exact.t)
        except IntegrationError:
            continue
        until = min(len(other.t), len(exact.t))
        kept = exact.until(until)
        # Without its rotors a scene has no spins that could be compared.
        without = replace(other.until(until), spins=np.zeros_like(kept.spins))
        moved = errors_between(scenario, without, kept)
        if _is_within_uncertainty(moved, solution.uncertainty, signals_of(without_it)):
            yield (
                f"{scenario.name}: cannot tell whether there is {effect.table}: without it no "
                f"signal changes by more than the reference's uncertainty"
            )


def _without(scenario: Scenario, effect: Effect) -> Scenario:
    """Return the scene with one effect left out."""
    if effect.is_part:
        return with_tables(scenario, **{effect.table: None})
    return with_tables(scenario, effects=scenario.effects.model_copy(update={effect.table: None}))


def _is_within_uncertainty(moved: Errors, uncertainty: Errors, signals: Iterable[Signal]) -> bool:
    """Whether no signal changes by more than twice its uncertainty.

    Parameters
    ----------
    moved : the change of each signal
    uncertainty : the uncertainty of the exact motion
    signals : the signals that are compared
    """
    return all(moved[signal.name] <= 2 * uncertainty[signal.name] for signal in signals)
