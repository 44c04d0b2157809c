"""What is said of a run in one number: its errors, and what does not depend on its window."""

import math
from collections.abc import Callable
from dataclasses import dataclass

from ....scenarios import SIGNAL, SIGNALS, Signal
from ...results.records import Row

#: Degrees a rad.
DEGREES = SIGNAL["attitude"].shown


@dataclass(frozen=True)
class Measure:
    """A number of a run, as people read it.

    Attributes
    ----------
    of : the number; of a run that did not come to its end the worst there is; None if it has none
    more_is_better : whether the largest number is of the best run
    """

    name: str
    title: str
    of: Callable[[Row], float | None]
    more_is_better: bool = False


def _error_in(signal: Signal) -> Measure:
    def error(row: Row) -> float | None:
        if row.errors is None:
            return math.inf
        least = row.reference_uncertainty if signal.name == "omega" else 0.0
        return max(row.errors[signal.name], least) * signal.shown

    return Measure(signal.name, signal.error_title, error)


def _turns(row: Row) -> float | None:
    if row.turns is None:
        return None if row.errors else 0.0
    if row.turns_within_1deg is not None:
        return row.turns_within_1deg
    return math.inf if row.errors else row.turns


def _a_turn(row: Row) -> float | None:
    if row.errors is None:
        return math.inf
    return None if row.attitude_a_turn is None else row.attitude_a_turn * DEGREES


_OF_ERRORS = {signal.name: _error_in(signal) for signal in SIGNALS}
TURNS = Measure("turns_within_1deg", "turns until the attitude is 1° off", _turns, True)
A_TURN = Measure("attitude_a_turn", "attitude error a turn, °", _a_turn)
#: Those that are shown first, and the others.
FIRST = (_OF_ERRORS["attitude"], _OF_ERRORS["omega"], TURNS, A_TURN)
MEASURES = (*FIRST, *(measure for measure in _OF_ERRORS.values() if measure not in FIRST))
