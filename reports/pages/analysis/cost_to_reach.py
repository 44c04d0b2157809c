"""The cost for a method to stay within an error, on a scene and over all scenes.

It is interpolated between two runs, or extrapolated below the finest; else there is a reason why it
cannot be reached. The rules and their constants are in docs/explanation/cost.md. A performance
profile gives the fraction of scenes that a method solves at no more than τ times the cost of the
cheapest method there (Dolan & Moré, Math. Program. 91 (2002) 201, eqs. 2.1 and 2.2); a scene that
it does not reach counts as one of infinite cost.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from statistics import median_high
from typing import Literal

from ...results.records import Pair
from ...results.verdict_words import VerdictWord
from .observed_order import SETTLING_ORDER
from .work_precision import Curve, CurvePoint, slope

#: One scene's curves, in one error, one a method.
SceneCurves = Sequence[Curve]


@dataclass(frozen=True)
class Profile:
    """Performance profiles of all methods at one error.

    Attributes
    ----------
    scenes : number of all scenes, reached or not
    ratios : by method, ascending: its cost over the cheapest, on each scene that it reaches
    """

    signal: str
    level: float
    scenes: int
    ratios: dict[Pair, tuple[float, ...]]

    def fraction(self, pair: Pair, factor: float) -> float:
        """Fraction of the scenes that a method solves within a factor of the cheapest."""
        within = sum(ratio <= factor for ratio in self.ratios[pair])
        return within / self.scenes if self.scenes else 0.0


@dataclass(frozen=True)
class Tally:
    """Results of one method at one error, over all scenes.

    Attributes
    ----------
    reached, extrapolated : scenes within reach, and those of them known by extrapolation only
    median_cost : CPU seconds a simulated second, over the scenes that it can simulate, infinite
        where out of reach; None without any such scene
    """

    reached: int
    extrapolated: int
    median_cost: float | None


def profile(scenes: Sequence[SceneCurves], signal: str, level: float) -> Profile:
    """Profiles of every method that was tried on any of the scenes."""
    ratios: dict[Pair, list[float]] = {curve.pair: [] for curves in scenes for curve in curves}
    for curves in scenes:
        best = cheapest(curves, level)
        if best is None or not best[1].cost:
            continue
        for curve in curves:
            cost = reach(curve, level).cost
            if cost is not None:
                ratios[curve.pair].append(cost / best[1].cost)
    ordered = {pair: tuple(sorted(of_pair)) for pair, of_pair in ratios.items()}
    return Profile(signal, level, len(scenes), ordered)


def tally(scenes: Sequence[SceneCurves], pair: Pair, level: float) -> Tally:
    """The number of scenes on which a method reaches an error, and what that costs it."""
    reached: list[Reach] = []
    for curves in scenes:
        reached += [reach(curve, level) for curve in curves if curve.pair == pair]
    extrapolated = sum(one.word == "extrapolated" for one in reached)
    costs = [one.cost or math.inf for one in reached if one.word != "unsupported"]
    within = sum(cost < math.inf for cost in costs)
    # Of two middle ones the greater: no mean with infinity.
    return Tally(within, extrapolated, median_high(costs) if costs else None)


def order_ratios(scenes: Sequence[SceneCurves], level: float) -> list[float]:
    """The ratio of the cheapest of the two orders, of each scene where both reach the error."""
    return [ratio for curves in scenes if (ratio := order_ratio(curves, level)) is not None]


#: Errors at which methods are compared, relative (attitude: rad): useful to excellent.
LEVELS = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)

#: How the cost of a level is known: between two runs, at the coarsest run, below the finest.
How = Literal["measured", "at most", "extrapolated"]
#: Why a level is out of reach.
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
    word : how its cost is known, or why it is out of reach
    reason : the same in a sentence
    timestep : s, and `cost`, CPU seconds a simulated second; None where out of reach
    floor : the error that rounding may cause at that timestep; None if runs are within the error
    """

    level: float
    word: How | Barrier
    reason: str
    timestep: float | None = None
    cost: float | None = None
    floor: float | None = None


def reach(curve: Curve, level: float) -> Reach:
    """The timestep and cost to stay within an error: interpolated, extrapolated, or why not.

    The interpolated timestep is on the safe side: between two runs the error is taken to be that of
    the finer one times (dt ratio)^p, p being the steeper of the slopes on either side of it.
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
    """Index of the coarsest stable run within an error that no finer run exceeds.

    A finer run may exceed it if rounding explains that: then only a coarser one can help.
    """
    errors = [point.error for point in curve.stable]
    exceeding = [
        k
        for k, point in enumerate(curve.stable)
        if point.error > max(level, curve.floor(point.timestep))
    ]
    start = exceeding[-1] + 1 if exceeding else 0
    return next((k for k in range(start, len(errors)) if errors[k] <= level), None)


def _below_finest(curve: Curve, level: float, order: float) -> float:
    """The timestep of an error below all runs, extrapolated from the finest above round-off."""
    finest = above_round_off(curve)[-1]
    return float(finest.timestep * (level / finest.error) ** (1 / order))


def above_round_off(curve: Curve) -> list[CurvePoint]:
    """The stable runs whose errors are larger than rounding explains."""
    return [point for point in curve.stable if point.error > curve.floor(point.timestep)]


def cheapest(tried: Sequence[Curve], level: float) -> tuple[Curve, Reach] | None:
    """The method that reaches an error at the least cost, and how; None if none does."""
    reached = [
        (curve, reached_level)
        for curve in tried
        if (reached_level := reach(curve, level)).cost is not None
    ]
    return min(reached, key=lambda pair: pair[1].cost or 0.0, default=None)


def order_ratio(tried: Sequence[Curve], level: float) -> float | None:
    """How many times more the cheapest method of first order costs than that of fourth.

    None if either is out of reach.
    """
    costs = []
    for order in (1, 4):
        best = cheapest([curve for curve in tried if curve.declared == order], level)
        costs.append(best[1].cost if best else None)
    return costs[0] / costs[1] if costs[0] and costs[1] else None


def _below_the_ladder(curve: Curve, level: float) -> Reach:
    """Extrapolate by the observed order, unless there is none or rounding prevents it."""
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
    order = curve.observed_order
    if order is None or order < SETTLING_ORDER:
        return Reach(level, "no order", "no run is within it, and the errors show no order")
    # The slope tends to a whole number as dt → 0; if from above, that number is the smaller.
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
    if curve.seconds_per_step is None:
        return Reach(level, "not timed", f"a timestep of {timestep:.3g} s, its steps not timed")
    return Reach(level, how, reason, timestep, curve.seconds_per_step / timestep)
