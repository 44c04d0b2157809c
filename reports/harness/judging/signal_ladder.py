"""Judges a ladder in one signal: whether it converges to the exact motion.

Verification as numerical analysts do it: the motion is extrapolated to dt → 0 with the order of
accuracy (L. F. Richardson, Phil. Trans. R. Soc. A 210 (1911) 307), and the limit's error is
compared with the sum of its own uncertainty (`best_window`) and those of reference, input and
round-off (ASME V&V 20-2009).
"""

import math
from dataclasses import dataclass

import numpy as np

from ...results.records import SignalVerdict
from ...results.verdict_words import RANKS, VerdictWord
from ..measuring.asymptotic import ASYMPTOTIC, CAUTIOUS, DISTINCT, ORDER_SLACK, WHOLE
from .best_window import SHARP, BestWindow, best_window
from .observed_order import ABOVE_UNCERTAINTY, FITTED_RUNGS, SETTLING_ORDER
from .sequences import SignalSequence

#: An order this far below the declared one, seen over clean rungs, is another order.
SHORTFALL = 0.5
#: Rungs over which such a shortfall, or errors or defects that grow, must be seen.
SHOWN_OVER = 4
#: Growth of errors from rung to rung, each, that is no scatter.
GROWTH = 2**0.5


@dataclass(frozen=True, eq=False)
class Judgement:
    """A ladder in one signal, and what it shows.

    Attributes
    ----------
    word, reason : the verdict and why, in words
    order : observed order of accuracy, signed; None where no errors show one
    limit_error : distance of the Richardson-extrapolated motion from the exact one; where that is
        another motion, both are those by the last sample that shows it
    tolerance : the largest that this distance may be: the sum of the limit's grid convergence index
        and the uncertainties of reference, input and round-off
    extrapolation_tolerance : the grid convergence index alone, which finer rungs would reduce
    needed_timestep : s, a timestep that would resolve an unresolved ladder; None if round-off
        prevents it
    """

    sequence: SignalSequence
    word: VerdictWord
    reason: str
    order: float | None = None
    limit_error: float | None = None
    tolerance: float | None = None
    extrapolation_tolerance: float = 0.0
    needed_timestep: float | None = None

    @property
    def converges(self) -> bool:
        """Whether its word says so."""
        return self.word == "converges"

    @property
    def severity(self) -> tuple[int, float, float]:
        """Sort key, worst last.

        Of two unresolved ones, the one that no timestep would resolve, or that needs the finer one;
        of two that no timestep would resolve, the one with the larger tolerance.
        """
        rank = RANKS[self.word]
        if self.word == "unresolved":
            return rank, -(self.needed_timestep or 0.0), self.tolerance or 0.0
        return rank, 0.0, (self.limit_error or 0.0) / (self.tolerance or math.inf)

    @property
    def numbers(self) -> tuple[float | None, float | None, float | None]:
        """Order, limit error and tolerance."""
        return self.order, self.limit_error, self.tolerance

    @property
    def record(self) -> SignalVerdict:
        """As it is stored."""
        name, declared = self.sequence.signal.name, self.sequence.declared_order
        return SignalVerdict(name, self.word, self.reason, declared, *self.numbers)


def judge_signal(sequence: SignalSequence) -> Judgement:
    """Judge a ladder of at least three rungs in one signal."""
    errors, rounding = sequence.errors, sequence.roundoff_bounds
    if errors.max() <= SHARP and (errors <= rounding + sequence.uncertainty).all():
        tolerance = float(rounding[-1] + sequence.uncertainty)
        words = sequence.signal.words
        reason = f"errors are at round-off throughout: {words(errors.max())}, bound "
        reason += words(tolerance)
        return Judgement(sequence, "converges", reason, None, float(errors[-1]), tolerance)
    window = best_window(sequence)
    if found := _elsewhere(window):
        return found
    word, reason, needed = _weigh(window)
    return Judgement(
        sequence,
        word,
        reason,
        window.order,
        window.limit_error,
        window.tolerance,
        window.extrapolation,
        needed,
    )


def _weigh(window: BestWindow) -> tuple[VerdictWord, str, float | None]:
    """Verdict, reason, and the timestep that would resolve the ladder, s."""
    sequence, words = window.sequence, window.sequence.signal.words
    limit = (
        f"Richardson-extrapolated error {words(max(window.limit_error, sequence.uncertainty))}, "
        f"tolerance {words(window.tolerance)}"
    )
    if growing := _growing(sequence):
        return "disagrees", growing, None
    if short := _shortfall(sequence):
        return "disagrees", f"{short}; {limit}", None
    if window.tolerance <= SHARP and window.limit_error <= window.tolerance:
        return "converges", f"{_order_words(window)}; {limit}", None
    return "unresolved", *_unresolved(window, limit)


def _elsewhere(window: BestWindow) -> Judgement | None:
    """The judgement on a limit that is wrong, as the last two limits must be; else None."""
    before, found = [None, None, *window.sequence.deviations][-2:]
    if before is None or found is None:
        return None
    words = window.sequence.signal.words
    reason = (
        f"settles on another motion, from t = {found.since:.3g} s on: by t = {found.by:.3g} s the "
        f"Richardson-extrapolated error is {words(found.error)}, tolerance {words(found.tolerance)}"
    )
    return Judgement(
        window.sequence,
        "disagrees",
        reason,
        window.order,
        found.error,
        found.tolerance,
        window.extrapolation,
    )


def _growing(sequence: SignalSequence) -> str:
    """The reason if errors grow towards the finest rungs, far above round-off; else empty."""
    errors = sequence.errors[-SHOWN_OVER:]
    noise_floor = sequence.roundoff_bounds[-1] + sequence.uncertainty
    grows = len(errors) == SHOWN_OVER and bool((errors[1:] >= GROWTH * errors[:-1]).all())
    if not grows or errors[0] > ASYMPTOTIC or errors[0] <= DISTINCT * noise_floor:
        return ""
    first, last = sequence.timesteps[-SHOWN_OVER], sequence.timesteps[-1]
    words = sequence.signal.words
    return (
        f"errors grow as the timestep shrinks: from {words(errors[0])} at {first:.1e} s "
        f"to {words(errors[-1])} at {last:.1e} s"
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


def _order_words(window: BestWindow) -> str:
    declared = window.sequence.declared_order
    if window.order is not None:
        above = " or better" if window.order > declared + ORDER_SLACK else ""
        # Without the sign of a zero.
        return f"order {round(window.order, 2) + 0.0:.2f}, declared {declared}{above}"
    if (window.sequence.errors >= ASYMPTOTIC).sum() > len(window.sequence) / 2:
        least = window.sequence.signal.words(window.sequence.errors.min())
        return f"errors of {least} and more are too large to show an order"
    return "too few errors above round-off to show an order"


def _unresolved(window: BestWindow, limit: str) -> tuple[str, float | None]:
    """Why it is unresolved, and the timestep that would resolve it, s, if there is one.

    Roundings of many steps are taken to add up as a random walk does, unless the ladder shows more.
    """
    sequence, words = window.sequence, window.sequence.signal.words
    if np.isinf(sequence.errors).any():
        return f"undefined: the exact {sequence.signal.quantity} is zero, that of runs is not", None
    least = int(np.argmin(sequence.errors))
    needed = _needed_timestep(window)
    a_step = float(sequence.roundoff_bounds[-1] * sequence.timesteps[-1]) / sequence.duration

    def rounding(timestep: float) -> float:
        return math.sqrt(sequence.duration / timestep) * a_step

    can_be_sharp = CAUTIOUS * rounding(needed) + sequence.uncertainty <= SHARP
    # A limit further off than that was not called wrong, as its samples may be damped away.
    is_open = window.extrapolation > window.noise_floor
    is_open |= window.limit_error > DISTINCT * window.tolerance
    if can_be_sharp and is_open and not _at_roundoff(sequence):
        steps = sequence.duration / needed
        return (
            f"not in the asymptotic range: {_order_words(window)}; {limit}; "
            f"a timestep of {needed:.1e} s would resolve it, {steps:.1e} steps",
            needed,
        )
    if window.tolerance <= SHARP:
        return (
            f"{limit}: another motion is {DISTINCT:g} tolerances off; no finer timestep would "
            f"decide: {words(window.noise_floor)} of the tolerance come from round-off and from "
            "the uncertainty of the exact motion, body and start",
            None,
        )
    return _no_better(sequence, a_step, rounding(float(sequence.timesteps[least]))), None


def _no_better(sequence: SignalSequence, a_step: float, all_steps: float) -> str:
    """The lowest error of a ladder that no finer timestep would resolve, and why.

    Parameters
    ----------
    a_step, all_steps : what the rounding of one step, and of all, moves the motion by the end
    """
    timesteps, errors = sequence.timesteps, sequence.errors
    least = int(np.argmin(errors))
    lowest, last = map(sequence.signal.words, (errors[least], errors[-1]))
    worse = f" and gets worse below it, {last} at {timesteps[-1]:.1e} s" if last != lowest else ""
    if sequence.uncertainty > SHARP:
        why = (
            "the uncertainty of the exact motion, and of body and start as the engine holds them, "
            f"has grown to {_of_motion(sequence, sequence.uncertainty)} by the end, and a verdict "
            f"needs {sequence.signal.words(SHARP)}"
        )
    else:
        why = (
            f"a step's rounding has grown to {_of_motion(sequence, a_step)} by the end, those of "
            f"all steps to {_of_motion(sequence, all_steps)}"
        )
    return (
        f"round-off × conditioning bounds the error from below: it comes down to {lowest} at a "
        f"timestep of {timesteps[least]:.1e} s{worse}; no finer one would resolve it: {why}"
    )


def _of_motion(sequence: SignalSequence, error: float) -> str:
    return sequence.signal.words(error) if error < WHOLE else "the size of the motion itself"


def _at_roundoff(sequence: SignalSequence) -> bool:
    """Whether errors no longer shrink, at a size that rounding at every step explains."""
    coarse, fine = sequence.errors[-2:]
    shrinks = coarse >= 2**SETTLING_ORDER * fine
    return bool(not shrinks and fine <= sequence.roundoff_bounds[-1] + sequence.uncertainty)


def _needed_timestep(window: BestWindow) -> float:
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
