"""A map as tables: survival by turn a step, how runs ended, meaning of the lines."""

import math
from collections import Counter
from collections.abc import Iterable
from statistics import median

from ...results.records import Pair
from ...results.sweep_records import PointResult
from ..analysis.map_grid import Grid
from ..analysis.map_marks import is_coloured, marks
from ..analysis.wording import NOTHING, number
from ..figures.map_figure import legend_of_bounds
from ..tables import Cell, Table, figure, table

#: rad a step, limits of the columns: half decades around the turn that a method can resolve.
TURNS = (0.01, 0.03, 0.1, 0.3, 1.0, 3.0)
#: Outcomes of runs that were made.
RUN = ("ok", "diverged", "failed")


def survival_table(grid: Grid) -> Table:
    """Percentage of the runs that finished, by the angle that ω(0) turns the body in a step."""
    by_turn = {pair: _by_turn(grid, pair) for pair in grid.methods}
    shown = [k for k in range(len(TURNS) + 1) if any(by_turn[pair][k] for pair in by_turn)]
    headings = ("engine", "method", *(_range(k) for k in shown))
    rows = ([*_name(pair), *(_survived(by_turn[pair][k]) for k in shown)] for pair in grid.methods)
    return table(headings, rows)


def ends_table(points: Iterable[PointResult], pairs: Iterable[Pair]) -> Table:
    """How many runs of each method finished, and how many ended in each other way."""
    points = list(points)
    marks_by_end = marks(points)
    counts: dict[Pair, Counter[str]] = {pair: Counter() for pair in pairs}
    for point in points:
        pair = point.key.engine, point.key.method
        label = "finished" if is_coloured(point) else marks_by_end[point.outcome, point.cause].label
        for each in [pair] if point.key.engine else counts:
            counts[each][label] += 1
    labels = ["finished", *dict.fromkeys(mark.label for mark in marks_by_end.values())]
    return table(
        ("engine", "method", *labels),
        ([*_name(pair), *(_count(counts[pair][label]) for label in labels)] for pair in counts),
    )


def bounds_table(grid: Grid) -> Table:
    """Table of the lines: meaning, and source."""
    rows = ((Cell(b.label, "name"), b.meaning, b.source) for b in legend_of_bounds(grid))
    return table(("line", "what it says", "source"), rows)


def _name(pair: Pair) -> tuple[Cell, Cell]:
    engine, method = pair
    return Cell(engine, "name"), Cell(method, "name")


def _count(amount: int) -> Cell:
    return Cell(str(amount), "number" if amount else "number none")


def _by_turn(grid: Grid, pair: Pair) -> list[list[PointResult]]:
    by_turn: list[list[PointResult]] = [[] for _ in range(len(TURNS) + 1)]
    for node, point in grid.points[pair].items():
        if point.outcome in RUN and node in grid.numbers:
            turn = grid.numbers[node].turning * point.timestep
            by_turn[sum(turn > limit for limit in TURNS)].append(point)
    return by_turn


def _range(k: int) -> str:
    if k == 0:
        return f"up to {TURNS[0]:g} rad"
    if k == len(TURNS):
        return f"over {TURNS[-1]:g} rad"
    return f"{TURNS[k - 1]:g} to {TURNS[k]:g} rad"


def _survived(points: list[PointResult]) -> Cell:
    if not points:
        return figure(NOTHING)
    finished = [point for point in points if is_coloured(point)]
    errors = [
        max(point.errors.omega, point.reference_uncertainty)
        for point in finished
        if point.errors and not math.isnan(point.errors.omega)
    ]
    detail = f"median {number(median(errors))}" if errors else ""
    return Cell(percent(len(finished), len(points)), "number", detail)


def percent(part: int, whole: int) -> str:
    """`97 %`; 0 and 100 are printed only for none and all."""
    rounded = round(100 * part / whole)
    if part and not rounded:
        return "< 1 %"
    if part < whole and rounded == 100:
        return "> 99 %"
    return f"{rounded} %"
