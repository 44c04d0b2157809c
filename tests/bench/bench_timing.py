"""CPU seconds of actions in turn, and ratios of them."""

from collections.abc import Callable, Sequence
from time import process_time

import numpy as np


def in_turn(rounds: int, actions: Sequence[Callable[[], object]]) -> np.ndarray:
    """CPU seconds of each, (rounds, actions), after one round that is not counted."""
    seconds = np.zeros((rounds + 1, len(actions)))
    for row in seconds:
        for k, action in enumerate(actions):
            start = process_time()
            action()
            row[k] = process_time() - start
    return seconds[1:]


def ratio(ratios: np.ndarray) -> tuple[float, float]:
    """Their median, and the distance of their quartiles."""
    low, middle, high = np.quantile(ratios, (0.25, 0.5, 0.75))
    return float(middle), float(high - low)
