"""Tables on effects and passes that a scene does not call for: cost, and change of the motion."""

from collections.abc import Sequence

from ...results.cost_records import EffectsCost, PassCosts
from ...results.records import Key
from ..analysis.wording import NOTHING, number
from ..tables import Cell, Table, figure, table

#: A pass is listed if its cost exceeds this many times the difference between equal sessions.
BEYOND_NOISE = 2.0


def effects_table(effects: Sequence[EffectsCost]) -> Table:
    """Table, scenes × engines, of how much more a step would cost with everything left in."""
    methods = sorted({cost.key.pair for cost in effects})
    cells = {cost.key: _cell(cost) for cost in effects}
    scenes = sorted({cost.key.scenario for cost in effects})
    return table(
        ["scene", *(f"{engine} {method}" for engine, method in methods)],
        [
            [scene, *(cells.get(Key(scene, *method), figure(NOTHING)) for method in methods)]
            for scene in scenes
        ],
    )


def harm_in_words(effects: Sequence[EffectsCost]) -> str:
    """The number of scenes on which leaving passes out changed the motion, in words."""
    same = sum(cost.difference == 0 for cost in effects)
    return f"{same} of {len(effects)} motions are identical to the last bit"


def passes_table(costs: PassCosts) -> Table:
    """Table of the cost of each pass, in percent of a pruned step."""
    least = BEYOND_NOISE * costs.noise

    def share(part: float) -> Cell:
        return figure(f"{part:+.0%}" if abs(part) > least else "noise")

    return table(
        ["left out", "a step with it alone left in", "saved by leaving it out of the defaults"],
        [[one.name, share(one.added), share(one.saved)] for one in costs.passes],
    )


def passes_tables(passes: Sequence[PassCosts]) -> list[tuple[str, Table]]:
    """A heading and a table for each engine."""
    return [(f"{p.key.label} on {p.key.scenario}", passes_table(p)) for p in passes]


def _cell(cost: EffectsCost) -> Cell:
    more = f"{cost.ratio.median - 1:+.0%} ± {cost.ratio.spread:.0%}"
    same = "motion identical to the last bit"
    harm = f"motion off by {number(cost.difference)}" if cost.difference else same
    return Cell(more, "number", harm)
