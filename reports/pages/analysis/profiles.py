"""How each method does over all scenes at one error: performance profiles, reach, medians.

A profile gives the fraction of scenes that a method solves at no more than τ times the cost of the
cheapest method there (Dolan & Moré, Math. Program. 91 (2002) 201, eqs. 2.1 and 2.2). A scene that a
method does not reach counts as one of infinite cost.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median, median_high

from ...results.records import Pair
from .cost_to_reach import Reach, cheapest, order_ratio, reach
from .work_precision import Curve

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


@dataclass(frozen=True)
class OrderRatio:
    """How many times more the cheapest first-order method costs than the cheapest of order four.

    Over the scenes where both reach the error; None where there are none.
    """

    scenes: int
    median: float | None
    largest: float | None


def profile(scenes: Sequence[SceneCurves], signal: str, level: float) -> Profile:
    """Profiles of every method that was tried on any of the scenes."""
    ratios: dict[Pair, list[float]] = {_pair(curve): [] for curves in scenes for curve in curves}
    for curves in scenes:
        best = cheapest(curves, level)
        if best is None or not best[1].cost:
            continue
        for curve in curves:
            cost = reach(curve, level).cost
            if cost is not None:
                ratios[_pair(curve)].append(cost / best[1].cost)
    ordered = {pair: tuple(sorted(of_pair)) for pair, of_pair in ratios.items()}
    return Profile(signal, level, len(scenes), ordered)


def tally(scenes: Sequence[SceneCurves], pair: Pair, level: float) -> Tally:
    """The number of scenes on which a method reaches an error, and what that costs it."""
    reached: list[Reach] = []
    for curves in scenes:
        reached += [reach(curve, level) for curve in curves if _pair(curve) == pair]
    extrapolated = sum(one.word == "extrapolated" for one in reached)
    costs = [one.cost or math.inf for one in reached if one.word != "unsupported"]
    within = sum(cost < math.inf for cost in costs)
    # Of two middle ones the greater: no mean with infinity.
    return Tally(within, extrapolated, median_high(costs) if costs else None)


def order_ratios(scenes: Sequence[SceneCurves], level: float) -> OrderRatio:
    """The ratio of the cheapest of the two orders, scene by scene."""
    ratios = [ratio for curves in scenes if (ratio := order_ratio(curves, level)) is not None]
    return OrderRatio(
        len(ratios),
        median(ratios) if ratios else None,
        max(ratios, default=None),
    )


def _pair(curve: Curve) -> Pair:
    return curve.engine, curve.method
