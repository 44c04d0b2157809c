"""Judges a method on its ladder, signal by signal: whether it converges to the exact motion.

Verification as numerical analysts do it: the motion is extrapolated to dt → 0 with the order of
accuracy (L. F. Richardson, Phil. Trans. R. Soc. A 210 (1911) 307), the uncertainty of the limit is
its grid convergence index (P. J. Roache, Annu. Rev. Fluid Mech. 29 (1997) 123), and the limit's
error is compared with the sum of that and the uncertainties of reference, input and round-off (ASME
V&V 20-2009). Of many rungs the window with the smallest tolerance is used (L. Eça and M. Hoekstra,
J. Comput. Phys. 262 (2014) 104).
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...scenarios import FloatArray
from ..results.records import SignalVerdict, VerdictWord
from .observed_order import (
    ABOVE_UNCERTAINTY,
    ASYMPTOTIC,
    FITTED_RUNGS,
    ORDER_SLACK,
    SETTLING_ORDER,
    observed_order,
)
from .richardson import CAUTIOUS, SAFE, SignalSequence

#: A limit whose tolerance is larger than this, relative or in rad, is inconclusive.
SHARP = 1e-2
#: A limit is wrong if its distance from the exact motion is this many times its tolerance; between
#: one and this many times a finer rung has to decide.
DISTINCT = 4.0
#: An order this far below the declared one, seen over clean rungs, is another order.
SHORTFALL = 0.5
#: Rungs over which such a shortfall, or errors that grow, must be seen.
SHOWN_OVER = 4
#: Growth of errors from rung to rung, each, that is no scatter.
GROWTH = 2**0.5


@dataclass(frozen=True)
class Judgement:
    """What a ladder shows of one signal.

    Attributes
    ----------
    word, reason : the verdict and why, in words
    order : observed order of accuracy, signed; None where no errors show one
    limit_error : distance of the Richardson-extrapolated motion from the exact one
    tolerance : the largest that this distance may be: the sum of the limit's grid convergence index
        and the uncertainties of reference, input and round-off
    extrapolation_tolerance : the grid convergence index alone, which finer rungs would reduce
    needed_timestep : s, a timestep that would resolve an unresolved ladder; None if round-off
        prevents it
    """

    word: VerdictWord
    reason: str
    order: float | None = None
    limit_error: float | None = None
    tolerance: float | None = None
    extrapolation_tolerance: float = 0.0
    needed_timestep: float | None = None

    def of(self, sequence: SignalSequence) -> SignalVerdict:
        """The judgement as a record to store."""
        return SignalVerdict(
            sequence.signal,
            self.word,
            self.reason,
            sequence.declared_order,
            self.order,
            self.limit_error,
            self.tolerance,
        )


@dataclass(frozen=True, eq=False)
class _BestWindow:
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
        return self.extrapolation + self.noise_floor


def judge(sequence: SignalSequence) -> Judgement:
    """Judge a ladder of at least three rungs in one signal."""
    errors, rounding = sequence.errors, sequence.roundoff_bounds
    if errors.max() <= SHARP and (errors <= rounding + sequence.uncertainty).all():
        tolerance = float(rounding[-1] + sequence.uncertainty)
        reason = f"errors are at round-off throughout: {errors.max():.1e}, bound {tolerance:.1e}"
        return Judgement("converges", reason, None, float(errors[-1]), tolerance)
    window = _best_window(sequence)
    word, reason, needed = _weigh(window)
    return Judgement(
        word,
        reason,
        window.order,
        window.limit_error,
        window.tolerance,
        window.extrapolation,
        needed,
    )


def _best_window(sequence: SignalSequence) -> _BestWindow:
    """The window with the smallest tolerance."""
    extrapolation, is_clean = _convergence_indices(sequence)
    changes, bounds = sequence.limit_changes, sequence.roundoff_bounds[2:]
    # The bound adds all roundings in one direction. Where that is too large to judge by, they are
    # taken to add up as a random walk does. Rounding shows in the limit's change, and over clean
    # rungs it cannot be much larger than that.
    walks = CAUTIOUS * bounds / np.sqrt(sequence.duration / sequence.timesteps[2:])
    rounding = np.where(bounds > SHARP, np.minimum(bounds, walks), bounds)
    rounding = np.where(is_clean, np.minimum(rounding, CAUTIOUS * changes), rounding)
    noise_floor = rounding + sequence.uncertainty
    best = int(np.argmin(extrapolation + noise_floor))
    order = observed_order(
        sequence.timesteps, sequence.errors, sequence.roundoff_bounds, sequence.uncertainty
    )
    return _BestWindow(
        sequence,
        order,
        float(sequence.limit_errors[best]),
        float(extrapolation[best]),
        float(noise_floor[best]),
    )


def _convergence_indices(sequence: SignalSequence) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Grid convergence index of each limit, and whether its rungs shrink as they should.

    In the asymptotic range a limit's error shrinks by 2^(p+1) a rung at least, p the declared
    order, so that its last change is 2^(p+1) − 1 times the remaining error. Elsewhere the remaining
    error is taken to be the change itself, or the largest of the neighbouring changes if they show
    rounding.
    """
    changes, p = sequence.limit_changes, sequence.orders
    before = np.concatenate([[0.0], changes[:-1]])
    after = np.concatenate([changes[1:], [0.0]])
    with np.errstate(divide="ignore", invalid="ignore"):
        shrinking = np.log2(before / changes)
        seen = np.log2(sequence.differences[:-1] / sequence.differences[1:])
    # The next term is of order p + 1, or of p + 2 where the method is symmetric.
    is_clean = (shrinking >= p + 1 - 2 * ORDER_SLACK) & (shrinking <= p + 2 + 2 * ORDER_SLACK)
    is_clean &= np.abs(seen - p) <= ORDER_SLACK
    # A change may be small by accident, and an order above the declared one need not last.
    least = sequence.declared_order + 1
    held = np.maximum(changes, before / 2**least)
    clean_index = SAFE / (2 ** (least - 2 * ORDER_SLACK) - 1) * held
    stalls = np.maximum(after, np.where(changes > before / 2, before, 0.0)) > changes / 2
    around = np.where(stalls, np.maximum(before, after), np.maximum(before, after) / 4)
    index = np.where(is_clean, clean_index, CAUTIOUS * np.maximum(changes, around))
    return index, is_clean


def _weigh(window: _BestWindow) -> tuple[VerdictWord, str, float | None]:
    """Verdict, reason, and the timestep that would resolve the ladder, s."""
    sequence = window.sequence
    limit = (
        f"Richardson-extrapolated error {max(window.limit_error, sequence.uncertainty):.1e}, "
        f"tolerance {window.tolerance:.1e}"
    )
    if elsewhere := _elsewhere(sequence):
        return "disagrees", f"settles on another motion, {elsewhere}: {limit}", None
    if growing := _growing(sequence):
        return "disagrees", growing, None
    if short := _shortfall(sequence):
        return "disagrees", f"{short}; {limit}", None
    if window.tolerance <= SHARP and window.limit_error <= window.tolerance:
        return "converges", f"{_order_words(window)}; {limit}", None
    return "unresolved", *_unresolved(window, limit)


def _elsewhere(sequence: SignalSequence) -> str:
    """In words, from when on the limit is wrong; empty unless the last two limits both are."""
    if len(sequence.excess) < 2 or not (sequence.excess[-2:] > DISTINCT).all():
        return ""
    return f"from t = {sequence.since[-1]:.3g} s on"


def _growing(sequence: SignalSequence) -> str:
    """The reason if errors grow towards the finest rungs, far above round-off; else empty."""
    errors = sequence.errors[-SHOWN_OVER:]
    noise_floor = sequence.roundoff_bounds[-1] + sequence.uncertainty
    grows = len(errors) == SHOWN_OVER and bool((errors[1:] >= GROWTH * errors[:-1]).all())
    if not grows or errors[0] > ASYMPTOTIC or errors[0] <= DISTINCT * noise_floor:
        return ""
    first, last = sequence.timesteps[-SHOWN_OVER], sequence.timesteps[-1]
    return (
        f"errors grow as the timestep shrinks: from {errors[0]:.1e} at {first:.1e} s "
        f"to {errors[-1]:.1e} at {last:.1e} s"
    )


def _shortfall(sequence: SignalSequence) -> str:
    """The reason if clean rungs show a lower order than the declared one; else empty."""
    errors = sequence.errors
    noise_floor = sequence.roundoff_bounds + sequence.uncertainty
    usable = (errors < ASYMPTOTIC) & (errors > ABOVE_UNCERTAINTY * noise_floor)
    rungs = np.flatnonzero(usable)[-SHOWN_OVER:]
    if len(rungs) < SHOWN_OVER or rungs[-1] != len(errors) - 1:
        return ""
    seen = -np.diff(np.log2(errors[rungs]))
    is_clean = np.ptp(seen) <= ORDER_SLACK and seen.min() >= SETTLING_ORDER
    if not is_clean or seen.max() >= sequence.declared_order - SHORTFALL:
        return ""
    return (
        f"order {seen.mean():.2f} over {SHOWN_OVER} rungs, "
        f"though {sequence.declared_order} is declared"
    )


def _order_words(window: _BestWindow) -> str:
    declared = window.sequence.declared_order
    if window.order is not None:
        above = " or better" if window.order > declared + ORDER_SLACK else ""
        return f"order {window.order:.2f}, declared {declared}{above}"
    if (window.sequence.errors >= ASYMPTOTIC).sum() > len(window.sequence) / 2:
        return (
            f"errors of {window.sequence.errors.min():.1e} and more are too large to show an order"
        )
    return "too few errors above round-off to show an order"


def _unresolved(window: _BestWindow, limit: str) -> tuple[str, float | None]:
    """Why it is unresolved, and the timestep that would resolve it, s, if there is one.

    Roundings of many steps are taken to add up as a random walk does, unless the ladder shows more.
    """
    sequence = window.sequence
    finest, errors = float(sequence.timesteps[-1]), sequence.errors
    least = int(np.argmin(errors))
    needed = _needed_timestep(window)
    a_step = float(sequence.roundoff_bounds[-1]) * finest / sequence.duration

    def rounding(timestep: float) -> float:
        return math.sqrt(sequence.duration / timestep) * a_step

    can_be_sharp = CAUTIOUS * rounding(needed) + sequence.uncertainty <= SHARP
    if can_be_sharp and window.extrapolation > window.noise_floor and not _at_roundoff(sequence):
        steps = sequence.duration / needed
        return (
            f"not in the asymptotic range: {_order_words(window)}; {limit}; "
            f"a timestep of {needed:.1e} s would resolve it, {steps:.1e} steps",
            needed,
        )
    at = float(sequence.timesteps[least])
    is_last = least == len(errors) - 1
    worse = "" if is_last else f" and gets worse below it, {errors[-1]:.1e} at {finest:.1e} s"
    return (
        f"round-off × conditioning bounds the error from below: it comes down to "
        f"{errors[least]:.1e} at a timestep of {at:.1e} s{worse}; no finer one would resolve it: "
        f"a step's rounding moves the motion by {a_step:.1e}, all of them by {rounding(at):.1e}; "
        f"{limit}",
        None,
    )


def _at_roundoff(sequence: SignalSequence) -> bool:
    """Whether errors no longer shrink, at a size that rounding at every step explains."""
    coarse, fine = sequence.errors[-2:]
    shrinks = coarse >= 2**SETTLING_ORDER * fine
    return bool(not shrinks and fine <= sequence.roundoff_bounds[-1] + sequence.uncertainty)


def _needed_timestep(window: _BestWindow) -> float:
    """The timestep at which errors are asymptotic and the limit is sharp, by the declared order."""
    sequence, order = window.sequence, float(window.sequence.declared_order)
    by_error = (ASYMPTOTIC / max(float(sequence.errors[-1]), ASYMPTOTIC)) ** (1 / order)
    by_limit = (SHARP / max(window.extrapolation, SHARP)) ** (1 / (order + 1))
    # Three rungs are read, so the finest must lie below the point where the range begins.
    finest = float(sequence.timesteps[-1])
    by_ladder = finest * min(by_error, by_limit) / 2 ** (FITTED_RUNGS - 1)
    # At larger timesteps a method may have damped away the fastest motion.
    rate = sequence.rate
    in_range = 1 / (rate * (rate * sequence.duration) ** (1 / order)) if rate else finest
    return float(min(by_ladder, in_range / 2 ** (FITTED_RUNGS - 1)))
