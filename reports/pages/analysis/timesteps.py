"""A method's runs at the timesteps that people use, and the largest timestep that it survives.

A run survives if it comes to its end and is better than no motion (`Row.survived`).
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import takewhile
from statistics import median_high
from typing import Literal

from ...harness.stock import COMMON_TIMESTEP
from ...results.records import Pair, Row
from .report_data import MethodRuns, ReportData
from .wording import NOTHING, number


@dataclass(frozen=True)
class Survival:
    """The largest timestep that a method survives.

    Attributes
    ----------
    timestep : s, the largest below which every run survived; None if the finest did not
    turn : rad a step at that timestep where the motion is fastest; None if the finest did not
    at_least : whether all runs survived, so that a larger timestep may too
    """

    timestep: float | None
    turn: float | None
    at_least: bool

    def reaches(self, turn: float) -> bool:
        """Whether the method survives steps of so many rad, or all that the scene has room for."""
        return self.turn is not None and (self.at_least or self.turn >= turn)

    def __str__(self) -> str:
        if self.timestep is None or self.turn is None:
            return "unstable at every timestep tested"
        bound = "≥ " if self.at_least else ""
        return f"{bound}{number(self.timestep)} s, {number(self.turn)} rad"


def survival(rows: Iterable[Row], fastest_rate: float | None) -> Survival | None:
    """The largest timestep that a method survives on a scene; None if it was not run there.

    Parameters
    ----------
    fastest_rate : the scene's, rad/s; None where it could not be solved, and nothing was run
    """
    tried = sorted((row for row in rows if row.timestep and row.made), key=lambda row: row.timestep)
    if fastest_rate is None or all(row.outcome == "unsupported" for row in tried):
        return None
    survived = list(takewhile(lambda row: row.survived, tried))
    if not survived:
        return Survival(None, None, at_least=False)
    largest = survived[-1].timestep
    return Survival(largest, largest * fastest_rate, at_least=len(survived) == len(tried))


def in_words(survived: Survival | None) -> tuple[str, str]:
    """The timestep, s, and the turn, rad a step, for two columns of a table."""
    if survived is None:
        return NOTHING, NOTHING
    if survived.timestep is None:
        return "at none tested", NOTHING
    bound = "≥ " if survived.at_least else ""
    return f"{bound}{number(survived.timestep)}", f"{bound}{number(survived.turn)}"


#: The engine's own stock timestep, the one that all engines share, and the finest that ended well.
At = Literal["stock", "common", "finest"]
AT: tuple[At, ...] = ("stock", "common", "finest")


def stock_timesteps(gathered: ReportData) -> dict[str, float]:
    """The timestep of each engine, s, that its users get unasked; 1 ms where it has none."""
    by_engine: dict[str, set[float]] = {}
    for scene in gathered.scenes:
        for runs in scene.methods:
            steps = {row.timestep for row in runs.rows if row.stock}
            by_engine.setdefault(runs.engine, set()).update(steps)
    return {
        engine: next(iter(steps - {COMMON_TIMESTEP}), COMMON_TIMESTEP)
        for engine, steps in by_engine.items()
    }


def row_at(runs: MethodRuns, at: At, stock_timestep: float) -> Row | None:
    """The run of a method at one of these timesteps; None where there is none."""
    if at == "finest":
        return next((row for row in reversed(runs.rows) if row.outcome == "ok"), None)
    timestep = stock_timestep if at == "stock" else COMMON_TIMESTEP
    return next((row for row in runs.rows if row.stock and row.timestep == timestep), None)


def as_shipped(gathered: ReportData) -> list[Pair]:
    """Engines with all their defaults."""
    shipped = {
        runs.pair
        for scene in gathered.scenes
        for runs in scene.methods
        if runs.declared and runs.declared.as_shipped
    }
    return [pair for pair in gathered.pairs if pair in shipped]


def made_at(gathered: ReportData, pair: Pair, timestep: float) -> dict[str, Row]:
    """A method's runs at a stock timestep, s, by scene, of those that were made."""
    return {
        scene.name: row
        for scene in gathered.scenes
        if (runs := scene.by_pair.get(pair))
        and (row := row_at(runs, "stock", timestep)) is not None
        and row.simulated
    }


def attitudes_at(gathered: ReportData, pair: Pair, timestep: float) -> dict[str, float]:
    """Their attitude errors in rad; infinite where one did not end ok."""
    rows = made_at(gathered, pair, timestep)
    return {name: row.errors.attitude if row.errors else math.inf for name, row in rows.items()}


def leading(gathered: ReportData) -> list[Pair]:
    """Each engine's first method as shipped, and the most accurate, in median, of the others."""
    steps, shipped = stock_timesteps(gathered), as_shipped(gathered)
    first = {engine: (engine, method) for engine, method in reversed(shipped)}
    middles = {
        pair: (-len(errors), median_high(errors.values()))
        for pair in gathered.pairs
        if pair not in shipped
        if (errors := attitudes_at(gathered, pair, steps.get(pair[0], COMMON_TIMESTEP)))
    }
    best: dict[str, Pair] = {}
    for pair in sorted(middles, key=lambda one: middles[one]):
        best.setdefault(pair[0], pair)
    return [*first.values(), *best.values()]
