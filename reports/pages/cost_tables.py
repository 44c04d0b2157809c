"""Tables of the cost of accuracy: on a scene by method and error, and over all scenes."""

from collections.abc import Sequence

from ..results.records import Pair
from .analysis.cost_to_reach import LEVELS, Reach, reach
from .analysis.profiles import SceneCurves, order_ratios, tally
from .analysis.report_data import MethodRuns, ReportData, SceneRuns
from .analysis.wording import NOTHING, number
from .analysis.work_precision import curve_of
from .tables import Cell, Table, figure, table

#: Microseconds in a second.
MICROSECONDS = 1e6
#: Signs before a cost that is not interpolated between two runs.
MARKS = {"measured": "", "at most": "≤ ", "extrapolated": "≈ "}


def reach_table(scene: SceneRuns, signal: str) -> Table:
    """Table of CPU seconds a simulated second that each method needs to stay within each error.

    Second lines, shown in HTML only: the timestep, or the error that rounding may cause at it.
    """
    counts = [_instructions(runs) for runs in scene.methods]
    counted = ("instructions a step",) if any(counts) else ()
    step = ("CPU a step, µs", "wall a step, µs", *counted)
    rows = []
    for runs, count in zip(scene.methods, counts, strict=True):
        curve = curve_of(scene, runs, signal)
        costs = [*_step_costs(runs), *(figure(count or NOTHING) for _ in counted)]
        cells = [_reach_cell(reach(curve, level)) for level in LEVELS]
        rows.append([*_named(runs.pair), *costs, *cells])
    return table(("engine", "method", *step, *_level_headings()), rows)


def reached_table(gathered: ReportData, scenes: Sequence[SceneCurves]) -> Table:
    """Table of the number of scenes on which each method reaches each error."""
    rows = []
    for pair in gathered.pairs:
        tallies = [tally(scenes, pair, level) for level in LEVELS]
        rows.append([*_named(pair), *(figure(f"{t.reached} ({t.extrapolated})") for t in tallies)])
    return table(("engine", "method", *_level_headings()), rows)


def median_table(gathered: ReportData, scenes: Sequence[SceneCurves]) -> Table:
    """Table of the median cost of each error, over the scenes that a method can simulate."""
    rows = []
    for pair in gathered.pairs:
        costs = [tally(scenes, pair, level).median_cost for level in LEVELS]
        rows.append([*_named(pair), *(figure(number(cost)) for cost in costs)])
    return table(("engine", "method", *_level_headings()), rows)


def ratio_table(scenes: Sequence[SceneCurves]) -> Table:
    """Table of the cost of the cheapest first-order method over that of the cheapest of order 4."""
    ratios = [order_ratios(scenes, level) for level in LEVELS]
    rows: list[list[Cell | str]] = [
        ["scenes where both reach it", *(figure(str(ratio.scenes)) for ratio in ratios)],
        ["median ratio", *(figure(number(ratio.median)) for ratio in ratios)],
        ["largest ratio", *(figure(number(ratio.largest)) for ratio in ratios)],
    ]
    return table(("first order over fourth", *_level_headings()), rows)


def _level_headings() -> list[str]:
    return [f"to {number(level, 1).removeprefix('1×')}" for level in LEVELS]


def _reach_cell(reached: Reach) -> Cell:
    floor = f"floor {number(reached.floor, 1)}" if reached.floor is not None else ""
    if reached.cost is None:
        return Cell(reached.word, "number none", floor)
    kind = "number extrapolated" if reached.word == "extrapolated" else "number"
    parts = [f"{number(reached.timestep)} s", floor]
    text = f"{MARKS[reached.word]}{number(reached.cost)}"
    return Cell(text, kind, "\n".join(part for part in parts if part))


def _step_costs(runs: MethodRuns) -> tuple[Cell, Cell]:
    """Cells of the times a step: least CPU time, spread over the repeats, least wall time."""
    timed = [row for row in runs.rows if row.seconds_per_step is not None]
    if not timed:
        return figure(NOTHING), figure(NOTHING)
    row = timed[-1]
    spread = _microseconds(row.seconds_spread)
    above = f"+ {spread}" if row.seconds_spread is not None else ""
    cpu = Cell(_microseconds(row.seconds_per_step), "number", above)
    return cpu, figure(_microseconds(row.wall_seconds_per_step))


def _instructions(runs: MethodRuns) -> str:
    """The instructions of a step; empty if they were not counted."""
    counts = (row.instructions_per_step for row in runs.rows if row.instructions_per_step)
    return next((f"{count:,.1f}" for count in counts), "")


def _microseconds(seconds: float | None) -> str:
    return number(None if seconds is None else MICROSECONDS * seconds)


def _named(pair: Pair) -> tuple[Cell, Cell]:
    return Cell(pair[0], "name"), Cell(pair[1], "name")
