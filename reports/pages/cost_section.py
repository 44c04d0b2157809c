"""The report's sections on cost: the cost of accuracy, and the cost of what engines leave out."""

from collections.abc import Sequence

from ..results.cost_records import MethodCost
from ..results.records import Key, Pair
from .analysis.cost_to_reach import LEVELS, Reach, reach, tallies
from .analysis.report_data import MethodRuns, ReportData, SceneRuns
from .analysis.wording import NOTHING, number, plural
from .analysis.work_precision import curve_of, curves
from .tables import Cell, Table, figure, named, records, table

#: Number of microseconds in a second.
MICROSECONDS = 1e6
#: The errors of the columns, by the columns' headings.
TO_LEVEL = {f"to {number(level, 1).removeprefix('1×')}": level for level in LEVELS}
#: Signs before a cost that is not interpolated between two runs.
MARKS = {"measured": "", "at most": "≤ ", "extrapolated": "≈ "}


def reach_table(scene: SceneRuns, signal: str) -> Table:
    """Return a table of CPU seconds for a simulated second that methods need within each error.

    Cells have a second line, in HTML only: the timestep, or the error that rounding may cause
    there.
    """
    rows = []
    for runs in scene.methods:
        curve = curve_of(scene, runs, signal)
        cells = {to: _reach_cell(reach(curve, level)) for to, level in TO_LEVEL.items()}
        rows.append(named(runs.pair) | _step_costs(runs) | cells)
    return records(rows)


def median_table(gathered: ReportData) -> Table:
    """Return a table of the median cost of each error over the scenes that a method can simulate.

    Cells have a second line: the number of scenes on which the method reaches the error.
    """
    found = tallies([curves(scene, COMPARED) for scene in gathered.scenes if scene.solved])

    def cell(pair: Pair, level: float) -> Cell:
        reached, extrapolated, cost = found.get((*pair, level), (0, 0, None))
        by_extrapolation = f", {extrapolated} by extrapolation" if extrapolated else ""
        return Cell(number(cost), "number", f"{plural(reached, 'scene')}{by_extrapolation}")

    return records(
        named(pair) | {to: cell(pair, level) for to, level in TO_LEVEL.items()}
        for pair in gathered.pairs
    )


def _reach_cell(reached: Reach) -> Cell:
    floor = f"floor {number(reached.floor, 1)}" if reached.floor is not None else ""
    if reached.cost is None:
        return Cell(reached.word, "number none", floor)
    kind = "number extrapolated" if reached.word == "extrapolated" else "number"
    parts = [f"{number(reached.timestep)} s", floor]
    text = f"{MARKS[reached.word]}{number(reached.cost)}"
    return Cell(text, kind, "\n".join(part for part in parts if part))


def _step_costs(runs: MethodRuns) -> dict[str, Cell]:
    """Return cells of times of a step: least CPU time, spread over repeats, least wall time."""
    timed = [row for row in runs.rows if row.seconds_per_step is not None]
    cpu = wall = figure(NOTHING)
    if timed:
        row = timed[-1]
        above = f"+ {_microseconds(row.seconds_spread)}" if row.seconds_spread is not None else ""
        cpu = Cell(_microseconds(row.seconds_per_step), "number", above)
        wall = figure(_microseconds(row.wall_seconds_per_step))
    return {"CPU a step, µs": cpu, "wall a step, µs": wall}


def _microseconds(seconds: float | None) -> str:
    return number(None if seconds is None else MICROSECONDS * seconds)


def left_out_section(costs: Sequence[MethodCost]) -> tuple[Table, str]:
    """Return a table of steps' cost with nothing left out, and whether motions change."""
    whole = [cost for cost in costs if cost.difference is not None]
    methods = sorted({cost.key.pair for cost in whole})
    cells = {cost.key: _whole_cell(cost) for cost in whole}
    scenes = sorted({cost.key.scenario for cost in whole})
    every = table(
        ["scene", *(f"{engine} {method}" for engine, method in methods)],
        [
            [scene, *(cells.get(Key(scene, *method), figure(NOTHING)) for method in methods)]
            for scene in scenes
        ],
    )
    same = sum(cost.difference == 0 for cost in whole)
    return every, f"{same} of {len(whole)} motions are identical to the last bit"


def _whole_cell(cost: MethodCost) -> Cell:
    ratio = cost.cost.ratio if cost.cost else None
    more = f"{ratio.median - 1:+.0%} ± {ratio.spread:.0%}" if ratio else NOTHING
    same = "motion identical to the last bit"
    harm = f"motion off by {number(cost.difference)}" if cost.difference else same
    return Cell(more, "number", harm)


#: The signal whose errors compare methods over all scenes; every scene's page has all signals.
COMPARED = "omega"
#: Explanation of the costs in the tables.
LEGEND = (
    "CPU seconds of native stepping that one simulated second takes. No mark: interpolated "
    "between two runs. ≤: the ladder's coarsest run is within it already. ≈: extrapolated below "
    "the finest run by the order found, where rounding leaves room. A word: why it is out of reach."
)


def scene_costs(scene: SceneRuns) -> list[tuple[str, Table]]:
    """Return a table for the errors of each signal, with the signal's name."""
    return [(str(signal), reach_table(scene, signal.name)) for signal in scene.signals]
