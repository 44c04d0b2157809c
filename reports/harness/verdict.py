"""Judges a method on its ladder: does it go to the truth as its timestep goes to zero."""

from dataclasses import dataclass

import numpy as np

from ...scenarios import FloatArray
from ..results.records import VerdictWord
from .richardson import RichardsonSequence

#: The order found must reach the order declared to within this.
ORDER_SLACK = 0.25
#: An order is read off errors at least this many times the reference's own uncertainty.
ABOVE_UNCERTAINTY = 100.0
#: Larger errors are not in the asymptotic range: on the unit sphere of directions they saturate.
ASYMPTOTIC = 0.1
#: Rungs an order is fitted to: the finest usable ones.
FITTED_RUNGS = 3
#: A limit known no better than this says nothing, relative (ω) or in rad (attitude).
SHARP = 1e-2
#: A limit is another one if it is this many times further from the truth than it is known to be;
#: up to there a finer rung has to tell: it halves what the limit is known to, at the least.
DISTINCT = 4.0
#: Differences between rungs must at least shrink like dt to this power for a ladder to settle.
SETTLING_ORDER = 0.5


@dataclass(frozen=True)
class Judgement:
    """What a ladder shows of one signal.

    Attributes
    ----------
    word, reason : the verdict and why, in words
    order : signed order of accuracy found, None where errors are at round-off
    limit_error : distance of the motion extrapolated to dt → 0 from the truth
    limit_estimate : how well that limit is known, from the ladder alone
    needed_timestep : s, what would resolve the ladder, where it is unresolved
    """

    word: VerdictWord
    reason: str
    order: float | None = None
    limit_error: float | None = None
    limit_estimate: float | None = None
    needed_timestep: float | None = None


def judge(ladder: RichardsonSequence) -> Judgement:
    """Judge a ladder of at least three rungs in one signal."""
    errors, roundoff_bounds = np.array(ladder.errors), np.array(ladder.roundoff_bounds)
    uncertainty = ladder.uncertainty
    if errors.max() <= SHARP and (errors <= roundoff_bounds + uncertainty).all():
        return Judgement("converges", "errors are at round-off throughout")
    limit_increments = np.array(ladder.limit_increments)
    best = _finest_above_round_off(limit_increments, roundoff_bounds[2:])
    estimate = _estimate(limit_increments, best, ladder.declared_order)
    off = ladder.limit_distances[best + 1]
    given = uncertainty + float(roundoff_bounds[best + 2])
    allowance = estimate + given
    return _weigh(
        _Found(
            ladder,
            fitted_order(np.array(ladder.timesteps), errors, roundoff_bounds, uncertainty),
            estimate,
            given,
            limit_error=float(off.max()),
            allowance=allowance,
            settles=_settles(limit_increments, roundoff_bounds[2:]),
            since=float(ladder.truth.t[np.argmax(off > allowance)]),
        )
    )


@dataclass(frozen=True, eq=False)
class _Found:
    ladder: RichardsonSequence
    order: float | None
    estimate: float
    given: float
    limit_error: float
    allowance: float
    settles: bool
    since: float


def _weigh(found: _Found) -> Judgement:
    """Turn what was found into a verdict."""
    at_limit = found.limit_error <= found.allowance
    declared = found.ladder.declared_order
    in_order = found.order is None or found.order >= declared - ORDER_SLACK
    sharp = found.estimate <= SHARP and found.given <= SHARP
    numbers = (found.order, found.limit_error, found.estimate)
    limit = (
        f"the limit dt → 0 is {max(found.limit_error, found.ladder.uncertainty):.1e} off, "
        f"which may be {found.allowance:.1e}"
    )
    if sharp and at_limit and in_order:
        return Judgement("converges", f"{_order_words(found)}; {limit}", *numbers)
    elsewhere = found.limit_error > DISTINCT * found.allowance
    if sharp and elsewhere and found.settles:
        return Judgement(
            "disagrees", f"settles elsewhere, from t = {found.since:.3g} s on: {limit}", *numbers
        )
    if found.given > SHARP:
        reason = f"rounding and the reference's own uncertainty alone may cause {found.given:.1e}"
        return Judgement("unresolved", f"{reason}: no timestep would tell; {limit}", *numbers)
    needed = _needed_timestep(found)
    steps = float(found.ladder.truth.t[-1]) / needed
    reason = (
        f"not in its asymptotic range: {_order_words(found)}, {limit}; "
        f"a timestep of {needed:.1e} s would tell, {steps:.1e} steps"
    )
    return Judgement("unresolved", reason, *numbers, needed)


def _order_words(found: _Found) -> str:
    if found.order is None:
        return "too few errors above round-off to read an order"
    declared = found.ladder.declared_order
    above = " or better" if found.order > declared + ORDER_SLACK else ""
    return f"order {found.order:.2f}, declared {declared}{above}"


def _settles(limit_increments: FloatArray, roundoff_bounds: FloatArray) -> bool:
    """Whether the extrapolated limits move less and less, down to the finest or to rounding."""
    if limit_increments[-1] <= roundoff_bounds[-1]:
        return True
    return len(limit_increments) > 1 and bool(
        limit_increments[-1] <= limit_increments[-2] * 2**-SETTLING_ORDER
    )


def _finest_above_round_off(limit_increments: FloatArray, roundoff_bounds: FloatArray) -> int:
    """Index of the last limit that moved by more than rounding; beyond it there is only noise."""
    above = np.flatnonzero(limit_increments > roundoff_bounds)
    return int(above[-1]) if len(above) else int(np.argmin(limit_increments))


def _estimate(limit_increments: FloatArray, best: int, order: int) -> float:
    """How well the limit is known: by how much it moved last.

    The move overestimates the error in the asymptotic range, where it shrinks by 2^(p+1) a rung;
    the move before, shrunk so, keeps one that is small by accident from being believed.
    """
    before = limit_increments[best - 1] / 2 ** (order + 1) if best else 0.0
    return float(max(limit_increments[best], before))


def fitted_order(
    timesteps: FloatArray, errors: FloatArray, roundoff_bounds: FloatArray, uncertainty: float
) -> float | None:
    """Signed least-squares slope of log error against log dt over the finest usable rungs.

    Usable are errors in the asymptotic range and above round-off and the reference's uncertainty;
    of fewer than two there is no slope. All arrays are (n,), coarse to fine.
    """
    usable = (
        (errors > ABOVE_UNCERTAINTY * uncertainty)
        & (errors > roundoff_bounds)
        & (errors < ASYMPTOTIC)
    )
    finest = np.flatnonzero(usable)[-FITTED_RUNGS:]
    if len(finest) < 2:
        return None
    return float(np.polyfit(np.log(timesteps[finest]), np.log(errors[finest]), 1)[0])


def _needed_timestep(found: _Found) -> float:
    """The timestep at which errors are asymptotic and the limit is sharp, by the declared order."""
    ladder, order = found.ladder, found.ladder.declared_order
    by_error = (ASYMPTOTIC / max(ladder.errors[-1], ASYMPTOTIC)) ** (1 / order)
    by_limit = (SHARP / max(found.estimate, SHARP)) ** (1 / (order + 1))
    # Three rungs are read, so the finest must lie below the point where the range begins.
    return float(ladder.timesteps[-1] * min(by_error, by_limit) / 2 ** (FITTED_RUNGS - 1))
