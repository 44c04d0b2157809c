"""The report's sections on cost: the cost of accuracy, and the cost of what engines leave out."""

from collections.abc import Sequence

from ..results.cost_records import MethodCost
from ..results.records import Key, Pair
from .analysis.cost_to_reach import LEVELS, tallies
from .analysis.report_data import ReportData
from .analysis.wording import NOTHING, number, plural
from .analysis.work_precision import curves
from .tables import Cell, Table, figure, named, records, table

#: The error that each column of the table is about, by the column's heading.
TO_LEVEL = {f"to {number(level, 1).removeprefix('1×')}": level for level in LEVELS}


def median_table(gathered: ReportData) -> Table:
    """Return a table of what each method costs, CPU s a simulated s, to reach several errors of ω.

    It is the median over the scenes that the method can simulate. A second line in each cell has
    the number of scenes on which the method reaches the error. The table is empty if no run was
    timed.
    """
    every = [curves(scene, COMPARED) for scene in gathered.scenes if scene.solved]
    if not any(curve.seconds_per_step for curves_of_scene in every for curve in curves_of_scene):
        return records([])
    found = tallies(every)

    def cell(pair: Pair, level: float) -> Cell:
        reached, extrapolated, cost = found.get((*pair, level), (0, 0, None))
        by_extrapolation = f", {extrapolated} by extrapolation" if extrapolated else ""
        return Cell(number(cost), "number", f"{plural(reached, 'scene')}{by_extrapolation}")

    return records(
        named(pair) | {to: cell(pair, level) for to, level in TO_LEVEL.items()}
        for pair in gathered.pairs
    )


def left_out_section(costs: Sequence[MethodCost]) -> tuple[Table, str]:
    """Return a table of how much longer steps take with the passes that engines leave out.

    A pass is a part of a step, such as the search for contacts; adapters leave out those that a
    scene does not call for. Also returned is a sentence on how many motions are the same to the
    last bit with and without these passes.

    Parameters
    ----------
    costs : costs of steps; only those whose motions with and without the passes were compared are
        used
    """
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
    """Return a cell on an engine that makes all the passes that it otherwise leaves out.

    The first line says by how many percent its steps take longer. The second says how far its
    motion is from the one with these passes left out, or that the two are identical.
    """
    ratio = cost.cost.ratio if cost.cost else None
    more = f"{ratio.median - 1:+.0%} ± {ratio.spread:.0%}" if ratio else NOTHING
    same = "motion identical to the last bit"
    harm = f"motion off by {number(cost.difference)}" if cost.difference else same
    return Cell(more, "number", harm)


#: The signal in whose errors methods are compared over all scenes. Scenes' pages have all signals.
COMPARED = "omega"
