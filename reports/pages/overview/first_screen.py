"""The report's answer: how wrong the defaults are, what to use, what it costs, and why."""

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from statistics import median, median_high
from typing import Any

import numpy as np

from ...results.cost_records import MethodCost
from ...results.records import Pair, Row
from ..analysis.measures import A_TURN, TURNS, Measure
from ..analysis.report_data import ReportData
from ..analysis.timesteps import as_shipped, made_at, stock_timesteps
from ..analysis.wording import NOTHING, duration, plural, readable
from ..tables import Cell, figure, table
from .causes import no_gyroscopic_torque, why

#: A method is recommended instead of a default if it can simulate this fraction of the scenes.
COVERING = 0.9
#: A method is recommended if its median error is smaller by this factor.
MUCH_SMALLER = 2.0
#: Number of engines whose defaults are described one by one, smallest errors first.
LISTED = 2
#: What stands in the table, line by line.
MEASURES = (
    "timestep",
    "1° off after",
    "error a turn",
    "off at the end",
    "at worst",
    "CPU time of a step",
    "pruned",
)
#: CPU time of the default as a multiple of its own.
OWN_RATIO = "1"
#: What is said of CPU times where there are any.
COST = (
    " CPU time: of a step, as a multiple of the default's, with quartiles; pruned: with everything "
    "switched off that the scenes do not call for."
)


@dataclass(frozen=True, eq=False)
class _AtStock:
    """One method's runs at its engine's stock timestep, by scene, as far as they were made."""

    pair: Pair
    timestep: float
    rows: dict[str, Row]

    @property
    def attitudes(self) -> dict[str, float]:
        """The error in degrees by scene; infinite where the run did not end ok."""
        return {
            name: math.degrees(row.errors.attitude) if row.errors else math.inf
            for name, row in self.rows.items()
        }

    @property
    def size(self) -> tuple[float, float]:
        """Median and worst error; of two middle ones the larger, as errors may be infinite."""
        errors = self.attitudes.values()
        return median_high(errors), max(errors)

    @property
    def median(self) -> str:
        """The median error in words."""
        if self.size[0] < math.inf:
            return _degrees(self.size[0])
        return f"lost on {self._unfinished} of {plural(len(self.rows), 'scene')}"

    @property
    def worst(self) -> Cell:
        """The largest error with its scene, and how many runs blew up or failed."""
        ended = {name: error for name, error in self.attitudes.items() if error < math.inf}
        largest = max(ended, key=lambda name: ended[name], default="")
        details = [largest] if ended else []
        for outcome, words in (("diverged", "blew up"), ("failed", "failed")):
            if count := sum(row.outcome == outcome for row in self.rows.values()):
                details.append(f"{plural(count, 'run')} {words}")
        return Cell(_degrees(ended[largest]) if ended else "∞", "number", ", ".join(details))

    @property
    def _unfinished(self) -> int:
        return sum(math.isinf(error) for error in self.attitudes.values())

    @property
    def turns(self) -> str:
        """The median of the turns until the attitude is off by 1°; it is independent of windows."""
        within = self._values(TURNS)
        if not within:
            return NOTHING
        turns = median_high(within)
        return f"{readable(turns)} turns" if turns < math.inf else "never"

    @property
    def a_turn(self) -> str:
        """The median of the error that a turn adds, likewise."""
        added = [value for value in self._values(A_TURN) if value < math.inf]
        return _degrees(median(added)) if added else NOTHING

    def _values(self, measure: Measure) -> list[float]:
        return [v for row in self.rows.values() if (v := measure.of(row)) is not None]


def answer(gathered: ReportData, left_out: Collection[MethodCost] = ()) -> dict[str, Any] | None:
    """The answer, from the plain scenes alone; None where no default was run.

    `lead` has the size of the defaults' errors, and of the methods' that are recommended instead;
    `table` a column for each of them, `about` what its numbers are; `why` the errors' reasons.

    Parameters
    ----------
    left_out : the cost of what changes no motion, and so is no reason for a wrong one
    """
    plain = gathered.plain
    steps = stock_timesteps(plain)
    tried = [
        _AtStock(pair, dt, made_at(plain, pair, dt))
        for pair in plain.pairs
        if (dt := steps.get(pair[0]))
    ]
    there = {one.pair: one for one in tried if one.rows}
    # The first of each engine: further methods as shipped lack some of the defaults.
    first = {pair[0]: there[pair] for pair in reversed(as_shipped(plain)) if pair in there}
    shipped = sorted(first.values(), key=lambda one: one.size)
    clean = [one for pair, one in there.items() if pair not in as_shipped(plain)]
    if not shipped:
        return None
    listed, others = shipped[:LISTED], shipped[LISTED:]
    instead = {one.pair: better for one in listed if (better := _instead(one, clean))}
    harmless = {name for cost in left_out for name in cost.left_in}
    measured = {one.key.engine for scene in plain.scenes for one in scene.defaults}
    explained = [one for one in shipped if one in listed or one.pair[0] in measured]
    reasons = [why(one.pair, one.rows, plain.scenes, harmless) for one in explained]
    headings, columns = [""], [[Cell(measure, "name") for measure in MEASURES]]
    for one in listed:
        for used in filter(None, (one, instead.get(one.pair))):
            headings.append(f"{'' if used is one else 'use '}{' '.join(used.pair)}")
            columns.append(_column(used, one, left_out))
    # Without times a line has the default's own ratio alone.
    lines = [
        line
        for line in zip(*columns, strict=True)
        if any(cell.text not in ("", OWN_RATIO) for cell in line[1:])
    ]
    scenes = plural(max(len(one.rows) for one in shipped), "scene")
    return {
        "lead": _lead(listed, list(instead.values())),
        "table": table(headings, lines),
        "about": f"Attitude at stock timesteps, medians of {scenes}; the error a turn is taken "
        "while the body moves." + (COST if lines[-1][0].text in MEASURES[-2:] else ""),
        "why": _sentences([*_others(others), *filter(None, reasons), *no_gyroscopic_torque(plain)]),
    }


def _lead(shipped: Sequence[_AtStock], instead: Sequence[_AtStock]) -> str:
    """The median errors of defaults, and of what is recommended, in two sentences."""

    def sizes(these: Sequence[_AtStock]) -> str:
        return ", ".join(f"{' '.join(one.pair)} {one.median}" for one in these)

    sentences = [f"With defaults and stock timesteps the attitude ends off by: {sizes(shipped)}"]
    if instead:
        sentences.append(f"Use another method, at the same timestep: {sizes(instead)}")
    return _sentences(sentences)


def _column(one: _AtStock, default: _AtStock, left_out: Collection[MethodCost]) -> list[Cell]:
    """The measures of a method: its errors, and the CPU time of its steps beside the default's.

    As most readers take it, with everything else as shipped, and with what is left besides where
    nothing runs that the scene does not call for.
    """
    base = {name: row.seconds_per_step for name, row in default.rows.items()}
    pruned = {name: row.seconds_per_step for name, row in one.rows.items()}
    whole = {
        cost.key.scenario: cost.cost.seconds_per_step
        for cost in left_out
        if cost.difference is not None and cost.cost and cost.key.pair == one.pair
    }
    ratios = (OWN_RATIO, "") if one is default else (_price(whole, base), _price(pruned, base))
    return [
        *map(figure, (duration(one.timestep), one.turns, one.a_turn, one.median)),
        one.worst,
        *map(figure, ratios),
    ]


def _others(shipped: Sequence[_AtStock]) -> list[str]:
    """The other defaults in short: the range of their medians, and which mostly blow up."""
    ended = [one for one in shipped if one.size[0] < math.inf]
    unfinished = [one.pair[0] for one in shipped if one not in ended]
    sentences = []
    if ended:
        low, high = (_degrees(one.size[0]) for one in (ended[0], ended[-1]))
        names = ", ".join(one.pair[0] for one in ended)
        ranged = low if low == high else f"{low} to {high}"
        sentences.append(f"The defaults of {names} are {ranged} off")
    if unfinished:
        sentences.append(
            f"Runs with the defaults of {', '.join(unfinished)} blow up or fail on most scenes"
        )
    return sentences


def _instead(shipped: _AtStock, clean: Sequence[_AtStock]) -> _AtStock | None:
    """The most accurate method of the same engine, if its median error is much smaller."""
    own = [one for one in clean if one.pair[0] == shipped.pair[0]]
    most = max((len(one.rows) for one in own), default=0)
    offered = [one for one in own if len(one.rows) >= COVERING * most]
    best = min(offered, key=lambda one: one.size, default=None)
    if best is None or best.size >= shipped.size:
        return None
    return best if MUCH_SMALLER * best.size[0] <= shipped.size[0] else None


def _price(seconds: Mapping[str, float | None], base: Mapping[str, float | None]) -> str:
    """The median ratio of the times of a step by scene, and its quartiles; empty without any."""
    ratios = [dear / cheap for name, dear in seconds.items() if dear and (cheap := base.get(name))]
    if not ratios:
        return ""
    low, middle, high = (readable(float(q)) for q in np.percentile(ratios, [25, 50, 75]))
    return f"{middle} ({low} to {high})"


def _degrees(error: float) -> str:
    return f"{readable(error)}°"


def _sentences(parts: Sequence[str]) -> str:
    return " ".join(f"{part}." for part in parts)
