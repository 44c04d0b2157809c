"""Of a ladder's rungs, the window whose Richardson-extrapolated limit is known best.

The uncertainty of a limit is its grid convergence index (P. J. Roache, Annu. Rev. Fluid Mech. 29
(1997) 123); of many rungs the window with the smallest tolerance is used (L. Eça and M. Hoekstra,
J. Comput. Phys. 262 (2014) 104).
"""

from dataclasses import dataclass

import numpy as np

from ....scenarios import FloatArray
from ..measuring.asymptotic import CAUTIOUS, ORDER_SLACK
from .observed_order import observed_order
from .sequences import SignalSequence

#: Safety factor of the grid convergence index of rungs that shrink as they should (Roache).
SAFE = 1.25
#: A limit whose tolerance is larger than this, relative or in rad, is inconclusive.
SHARP = 1e-2


@dataclass(frozen=True, eq=False)
class BestWindow:
    """The window of a sequence with the smallest tolerance.

    Attributes
    ----------
    order : observed
    limit_error : of its Richardson limit
    extrapolation : grid convergence index of that limit
    noise_floor : what rounding, reference and input may add to the error
    """

    sequence: SignalSequence
    order: float | None
    limit_error: float
    extrapolation: float
    noise_floor: float

    @property
    def tolerance(self) -> float:
        """The largest that the limit's error may be."""
        return self.extrapolation + self.noise_floor


def best_window(sequence: SignalSequence) -> BestWindow:
    """The window with the smallest tolerance."""
    extrapolation, bounds = _convergence_indices(sequence), sequence.roundoff_bounds[2:]
    # The bound adds all roundings in one direction. Where that is too large to judge by, they are
    # taken to add up as a random walk does.
    walks = CAUTIOUS * bounds / np.sqrt(sequence.duration / sequence.timesteps[2:])
    rounding = np.where(bounds > SHARP, walks, np.inf)
    rounding = np.minimum(sequence.rounding, rounding)
    noise_floor = rounding + sequence.uncertainty
    best = int(np.argmin(extrapolation + noise_floor))
    order = observed_order(
        sequence.timesteps, sequence.errors, sequence.roundoff_bounds, sequence.uncertainty
    )
    return BestWindow(
        sequence,
        order,
        float(sequence.limit_errors[best]),
        float(extrapolation[best]),
        float(noise_floor[best]),
    )


def _convergence_indices(sequence: SignalSequence) -> FloatArray:
    """Grid convergence index of each limit.

    In the asymptotic range a limit's error shrinks by 2^(p+1) a rung at least, p the declared
    order, so that its last change is 2^(p+1) − 1 times the remaining error. Elsewhere the remaining
    error is taken to be the change itself, or the largest of the neighbouring changes if they show
    rounding.
    """
    changes = sequence.limit_changes
    before = np.concatenate([[0.0], changes[:-1]])
    after = np.concatenate([changes[1:], [0.0]])
    # A change may be small by accident, and an order above the declared one need not last.
    least = sequence.declared_order + 1
    bounded = np.maximum(changes, before / 2**least)
    clean_index = SAFE / (2 ** (least - 2 * ORDER_SLACK) - 1) * bounded
    stalls = np.maximum(after, np.where(changes > before / 2, before, 0.0)) > changes / 2
    around = np.where(stalls, np.maximum(before, after), np.maximum(before, after) / 4)
    unclean_index = CAUTIOUS * np.maximum(changes, around)
    return np.asarray(np.where(sequence.is_clean, clean_index, unclean_index))
