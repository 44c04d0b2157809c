"""The cost at which a method stays within an error, on a scene and over all scenes.

The cost is interpolated between two runs, or extrapolated below the finest run. If it is neither,
there is a reason why the error is out of reach. docs/explanation/cost.md has the rules and their
constants.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

from ...results.verdict_words import VerdictWord
from .in_memory import Tables
from .observed_order import SETTLING_ORDER
from .work_precision import Curve, CurvePoint, slope

#: Errors at which methods are compared, relative (attitude: rad), from useful to excellent.
LEVELS = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
#: The curves of all methods on one scene, in the errors of one signal.
SceneCurves = Sequence[Curve]

#: By engine, method and level of error: the number of scenes on which the method reaches the level,
#: the number of those on which that is known by extrapolation only, and the median cost, CPU
#: seconds for a simulated second. The median is over the scenes that the method can simulate; on a
#: scene on which the method does not reach the level, its cost counts as infinite.
Tallies = dict[tuple[str, str, float], tuple[int, int, float | None]]


def tallies(scenes: Sequence[SceneCurves], levels: Sequence[float] = LEVELS) -> Tallies:
    """Return on how many scenes each method reaches each level of error, and at which cost.

    Parameters
    ----------
    scenes : the curves of all methods on each scene, in the errors of one signal
    levels : the errors to reach, relative, or in rad if the signal is the attitude

    Returns
    -------
    By engine, method and level: the number of scenes on which the level is reached, the number of
    those on which that is known by extrapolation only, and the median cost, CPU seconds for a
    simulated second. The median is over the scenes that the method can simulate, and None if it can
    simulate none; the cost is infinite on scenes on which the level is not reached.
    """
    lines = (
        (*curve.pair, level, reached.word, reached.cost)
        for curves in scenes
        for curve in curves
        for level in levels
        for reached in [reach(curve, level)]
    )
    question = """SELECT engine, method, level, count(seconds), sum(word = 'extrapolated'),
        median_high(coalesce(seconds, 9e999)) FILTER (WHERE word <> 'unsupported')
        FROM cost GROUP BY 1, 2, 3"""
    found = Tables({"cost (engine, method, level, word, seconds)": lines}).ask(question)
    return {(engine, method, level): tuple(counts) for engine, method, level, *counts in found}


#: Words for how the cost of an error is known: "measured" between two runs, "at most" the cost of
#: the coarsest run, "extrapolated" below the finest run.
How = Literal["measured", "at most", "extrapolated"]
#: Words for why an error is out of reach.
Barrier = Literal[
    "round-off",
    "reference limit",
    "undefined",
    "no order",
    "not timed",
    "no verdict",
    VerdictWord,
]


@dataclass(frozen=True)
class Reach:
    """The timestep and cost that a method needs to stay within an error.

    Attributes
    ----------
    level : the error
    word : how the cost is known, or why the error is out of reach
    reason : the same in a sentence
    timestep : s; None if the error is out of reach
    cost : CPU seconds for a simulated second; None if the error is out of reach
    floor : the error that rounding may cause; None unless the timestep is extrapolated or rounding
        keeps the error out of reach
    """

    level: float
    word: How | Barrier
    reason: str
    timestep: float | None = None
    cost: float | None = None
    floor: float | None = None


def reach(curve: Curve, level: float) -> Reach:
    """Return the timestep and cost with which a method stays within an error, or why it cannot.

    Runs count if they and all finer ones ended `ok` (`curve.stable`). If the coarsest of these is
    within the error, its timestep is returned. Otherwise the timestep is interpolated between two
    runs, or extrapolated below the finest run. For
    interpolation, the error is assumed to grow from that of the finer run as Δtᵖ, where p is the
    steeper of the slopes on either side of that run. The timestep is then rather too short than
    too long.

    Parameters
    ----------
    level : the error, in the unit of the curve's errors
    """
    if curve.points and level < curve.uncertainty:
        reason = f"the reference itself is known to {curve.uncertainty:.1e}"
        return Reach(level, "reference limit", reason)
    k = _first_within(curve, level)
    if k is None:
        return _below_the_ladder(curve, level)
    fine = curve.stable[k]
    if k == 0:
        reason = "the coarsest stable run is within it; a coarser one may be"
        return _priced(curve, level, "at most", reason, fine.timestep)
    coarse = curve.stable[k - 1]
    finer = [p for p in curve.stable[k + 1 : k + 2] if p.error > curve.floor(p.timestep)]
    steepest = max([slope(coarse, fine), *(slope(fine, point) for point in finer)])
    timestep = fine.timestep * (level / fine.error) ** (1 / steepest)
    reason = f"between timesteps of {coarse.timestep:.3g} s and {fine.timestep:.3g} s"
    return _priced(curve, level, "measured", reason, timestep)


def _first_within(curve: Curve, level: float) -> int | None:
    """Return the index, in `curve.stable`, of the coarsest run whose error is at most `level`.

    `curve.stable` has the runs that ended `ok`, as did all finer ones, from coarse to fine. The
    errors of all finer runs must be at most `level`, too, unless rounding explains the excess:
    rounding adds more to finer runs. None is returned if there is no such run.
    """
    errors = [point.error for point in curve.stable]
    finest = curve.least.timestep if curve.least else 0.0
    exceeding = [
        k
        for k, point in enumerate(curve.stable)
        if point.error > max(level, curve.floor(point.timestep)) and point.timestep >= finest
    ]
    start = exceeding[-1] + 1 if exceeding else 0
    return next((k for k in range(start, len(errors)) if errors[k] <= level), None)


def _below_finest(curve: Curve, level: float, order: float) -> float:
    """Return the timestep, s, at which a method reaches an error that is below those of all runs.

    It is extrapolated from the finest run whose error is larger than rounding explains.

    Parameters
    ----------
    level : the error, in the unit of the curve's errors
    order : order with which errors are assumed to shrink
    """
    finest = above_round_off(curve)[-1]
    return float(finest.timestep * (level / finest.error) ** (1 / order))


def above_round_off(curve: Curve) -> list[CurvePoint]:
    """Return the runs whose errors are larger than rounding alone explains.

    Only runs count that ended `ok`, as did all finer ones (`curve.stable`).
    """
    return [point for point in curve.stable if point.error > curve.floor(point.timestep)]


def _below_the_ladder(curve: Curve, level: float) -> Reach:
    """Return the timestep and cost for an error below those of all runs, by the observed order.

    They are None if the method does not converge or was not timed, if `curve.stable` is empty, if
    errors are relative to an exact value of zero or show no order, or if rounding keeps the error
    `level` out of reach.
    """
    if curve.verdict != "converges":
        return Reach(level, curve.verdict or "no verdict", curve.reason)
    if not curve.stable:
        return Reach(level, "unresolved", "the finest run did not end well")
    if any(math.isinf(point.error) for point in curve.stable):
        return Reach(level, "undefined", "the error is relative to an exact value of zero")
    if not above_round_off(curve):
        least = min(curve.stable, key=lambda point: point.error)
        reason = f"errors are at round-off, {least.error:.1e} at the least"
        return Reach(level, "round-off", reason, floor=curve.floor(least.timestep))
    if best := curve.least:
        reason = (
            f"{best.error:.1e} at {best.timestep:.3g} s is the least: shorter timesteps make "
            "errors grow, as rounding does"
        )
        return Reach(level, "round-off", reason, floor=best.error)
    order = curve.observed_order
    if order is None or order < SETTLING_ORDER:
        return Reach(level, "no order", "no run is within it, and the errors show no order")
    # The slope tends to a whole number as dt → 0. The smaller of both is used, as it may do so from
    # above.
    timestep = _below_finest(curve, level, min(order, max(1, round(order))))
    floor = curve.floor(timestep)
    if floor >= level:
        reason = f"at the timestep it takes, {timestep:.1e} s, rounding alone may cause {floor:.1e}"
        return Reach(level, "round-off", reason, floor=floor)
    reason = (
        f"below the finest run, by the order found, {order:.2f}; rounding may cause {floor:.1e}"
    )
    return replace(_priced(curve, level, "extrapolated", reason, timestep), floor=floor)


def _priced(curve: Curve, level: float, how: How, reason: str, timestep: float) -> Reach:
    """Return a timestep and its cost as a `Reach`; "not timed", without both, if steps were not.

    Parameters
    ----------
    curve : the method's errors, with the CPU time of its steps
    level : the error that the method stays within, in the unit of the curve's errors
    how, reason : how timestep and cost are known, in a word and in a sentence
    timestep : s
    """
    if curve.seconds_per_step is None:
        return Reach(level, "not timed", f"a timestep of {timestep:.3g} s, its steps not timed")
    return Reach(level, how, reason, timestep, curve.seconds_per_step / timestep)
