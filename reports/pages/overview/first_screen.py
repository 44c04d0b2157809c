"""The report's first screen: how wrong defaults are, what to use instead, its cost, and why."""

import math
from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np

from ...results.cost_records import MethodCost
from ..analysis.finest_timesteps import Finest, finest_in_words, finest_timesteps
from ..analysis.questions import Usual, ask, at_stock
from ..analysis.report_data import ReportData
from ..analysis.wording import NOTHING, duration, plural, readable
from ..tables import Cell, figure, table
from .causes import no_gyroscopic_torque, why

#: A method is recommended instead of a default only if it can simulate at least this fraction of
#: the scenes that the most capable clean method of the same engine can simulate.
COVERING = 0.9
#: Factor by which the median error of a recommended method must be smaller than the default's.
MUCH_SMALLER = 2.0
#: Number of engines whose defaults are described one by one, those with the smallest errors.
LISTED = 2
#: Heading of the row for the timestep below which rounding makes errors grow.
FINEST = "finer than this makes it worse"
#: Headings of the rows of the table.
MEASURES = (
    "timestep",
    "1° off after",
    "error a turn",
    "largest error",
    "on the worst scene",
    FINEST,
    "CPU time of a step",
    "pruned",
)
#: Text for a default's own CPU time, relative to which all CPU times are given.
OWN_RATIO = "1"
#: Sentence on what the CPU times in the table are.
COST = (
    " CPU time: of a step, as a multiple of the default's, with quartiles if they differ; pruned: "
    "with everything switched off that the scenes do not call for."
)


def answer(gathered: ReportData, left_out: Collection[MethodCost] = ()) -> dict[str, Any] | None:
    """Return the contents of the first screen, made from the plain scenes alone, as a dictionary.

    `lead` says how large the errors of at most two engines as shipped are, and those of the methods
    that are recommended instead. `table` has a column for each of these engines and methods.
    `about` says what the numbers in the table are. `why` has the reasons for the errors. None is
    returned if no engine as shipped was run.

    Parameters
    ----------
    left_out : costs of steps of engines, made with passes that adapters otherwise leave out
    """
    plain = gathered.plain
    tried = at_stock(plain)
    # Only the first method as shipped of each engine: the others lack some of the defaults.
    first = {one.engine: one for one in reversed(tried) if one.shipped}
    shipped = sorted(first.values(), key=_size)
    if not shipped:
        return None
    clean = [one for one in tried if not one.shipped]
    listed, others = shipped[:LISTED], shipped[LISTED:]
    instead = {one.pair: better for one in listed if (better := _instead(one, clean))}
    harmless = {name for cost in left_out for name in cost.left_in}
    measured = {one.key.engine for scene in plain.scenes for one in scene.defaults}
    explained = [one for one in shipped if one in listed or one.engine in measured]
    reasons = [why(plain, one, harmless) for one in explained]
    finest = finest_timesteps(plain)
    in_table = {used.pair for one in listed for used in (one, instead.get(one.pair, one))}
    rounding = [f for pair, f in finest.items() if pair not in in_table or not f.timesteps]
    headings, columns = [""], [[Cell(measure, "name") for measure in MEASURES]]
    for one in listed:
        for used in filter(None, (one, instead.get(one.pair))):
            headings.append(f"{'' if used is one else 'use '}{used.label}")
            columns.append(_column(plain, used, one, left_out, finest.get(used.pair)))
    # A row without timings has only the default's own ratio, and is left out.
    lines = [
        line
        for line in zip(*columns, strict=True)
        if any(cell.text not in ("", OWN_RATIO) for cell in line[1:])
    ]
    scenes = plural(max(one.scenes for one in shipped), "scene")
    return {
        "lead": _lead(listed, list(instead.values())),
        "table": table(headings, lines),
        "about": f"Attitude at stock timesteps, medians of {scenes}; the error a turn is taken "
        "while the body moves." + (COST if lines[-1][0].text in MEASURES[-2:] else ""),
        "why": _sentences(
            [
                *_others(others),
                *filter(None, reasons),
                *no_gyroscopic_torque(plain),
                *finest_in_words(rounding),
            ]
        ),
    }


def _size(one: Usual) -> tuple[float, float]:
    """Return a sort key: the median attitude error, and then the largest."""
    return one.middle, one.largest


def _lead(shipped: Sequence[Usual], instead: Sequence[Usual]) -> str:
    """Return sentences with the median errors of defaults, and of methods recommended instead.

    Parameters
    ----------
    shipped : the runs of engines as shipped at stock timesteps
    instead : the runs of the methods that are recommended; no sentence is about them if empty
    """

    def sizes(these: Sequence[Usual]) -> str:
        return ", ".join(f"{one.label} {_median(one)}" for one in these)

    sentences = [
        "With defaults and stock timesteps the largest error of the attitude is, in the median: "
        + sizes(shipped)
    ]
    if instead:
        sentences.append(f"Use another method, at the same timestep: {sizes(instead)}")
    return _sentences(sentences)


def _median(one: Usual) -> str:
    """Return a method's median attitude error in words.

    If it is infinite, the words say on how many scenes the method's run has no errors.
    """
    if one.middle < math.inf:
        return _degrees(one.middle)
    return f"lost on {one.unfinished} of {plural(one.scenes, 'scene')}"


def _column(
    gathered: ReportData,
    one: Usual,
    default: Usual,
    left_out: Collection[MethodCost],
    finest: Finest | None,
) -> list[Cell]:
    """Return a method's column in the table: its errors, and the CPU time of its steps.

    The time is relative to that of the engine as shipped, and is given twice: with all that the
    engine does by default, as most users run it; and without what the scenes do not call for.

    Parameters
    ----------
    one, default : the runs of the method, and of the engine as shipped, at stock timesteps
    left_out : costs of steps of engines, made with passes that adapters otherwise leave out
    finest : what rounding does to the method; None if it does nothing
    """
    of_steps = "SELECT scene, seconds FROM usual WHERE engine = ? AND method = ?"
    base, pruned = (dict(ask(gathered, of_steps, *used.pair)) for used in (default, one))
    whole = {
        cost.key.scenario: cost.cost.seconds_per_step
        for cost in left_out
        if cost.difference is not None and cost.cost and cost.key.pair == one.pair
    }
    ratios = (OWN_RATIO, "") if one is default else (_price(whole, base), _price(pruned, base))
    turns = NOTHING
    if one.turns is not None:
        turns = f"{readable(one.turns)} turns" if one.turns < math.inf else "never"
    a_turn = NOTHING if one.a_turn is None else _degrees(one.a_turn)
    ended = {"blew up": one.blew_up, "failed": one.failed}
    worst = [one.worst_finished] if one.worst_finished else []
    worst += [f"{plural(count, 'run')} {how}" for how, count in ended.items() if count]
    largest = "∞" if one.largest_finished is None else _degrees(one.largest_finished)
    return [
        *map(figure, (duration(one.timestep), turns, a_turn, _median(one))),
        Cell(largest, "number", ", ".join(worst)),
        Cell(*_worse_below(finest)),
        *map(figure, ratios),
    ]


def _worse_below(finest: Finest | None) -> tuple[str, str, str]:
    """Return text, kind and detail of the cell that has the timestep below which errors grow.

    The detail is the bias of rounding in words. Text and detail are empty if errors do not grow.
    """
    if finest is None or not finest.timesteps:
        return "", "number", ""
    return finest.timestep_in_words, "number", finest.bias_in_words


def _others(shipped: Sequence[Usual]) -> list[str]:
    """Return sentences on the engines as shipped that have no column in the table.

    The sentences state the range of the engines' median errors, and which of the engines blow up or
    fail on most scenes.

    Parameters
    ----------
    shipped : the runs of these engines at stock timesteps, the smallest error first
    """
    ended = [one for one in shipped if one.middle < math.inf]
    unfinished = ", ".join(one.engine for one in shipped if one not in ended)
    sentences = []
    if ended:
        low, high = (_degrees(one.middle) for one in (ended[0], ended[-1]))
        names = ", ".join(one.engine for one in ended)
        ranged = low if low == high else f"{low} to {high}"
        sentences.append(f"The defaults of {names} are {ranged} off")
    if unfinished:
        sentences.append(f"Runs with the defaults of {unfinished} blow up or fail on most scenes")
    return sentences


def _instead(shipped: Usual, clean: Sequence[Usual]) -> Usual | None:
    """Return an engine's most accurate clean method; None if it is not much better than defaults.

    It is much better if its median attitude error is smaller by the factor `MUCH_SMALLER`. Methods
    that can simulate too few scenes (`COVERING`) are left out.

    Parameters
    ----------
    shipped : the runs of the engine as shipped
    clean : the runs of the clean methods of all engines
    """
    own = [one for one in clean if one.engine == shipped.engine]
    most = max((one.scenes for one in own), default=0)
    offered = [one for one in own if one.scenes >= COVERING * most]
    best = min(offered, key=_size, default=None)
    if best is None or _size(best) >= _size(shipped):
        return None
    return best if MUCH_SMALLER * best.middle <= shipped.middle else None


def _price(seconds: Mapping[str, float | None], base: Mapping[str, float | None]) -> str:
    """Return, as text, the median over scenes of the ratio of two times.

    The quartiles follow in brackets, unless both are the same text. The text is empty if no scene
    has both times.

    Parameters
    ----------
    seconds, base : by scene, the CPU time of a step, s, and the one by which it is divided; None if
        not timed
    """
    ratios = [dear / cheap for name, dear in seconds.items() if dear and (cheap := base.get(name))]
    if not ratios:
        return ""
    low, middle, high = (readable(float(q)) for q in np.percentile(ratios, [25, 50, 75]))
    return middle if low == high else f"{middle} ({low} to {high})"


def _degrees(error: float) -> str:
    """Return an error in degrees as text."""
    return f"{readable(error)}°"


def _sentences(parts: Sequence[str]) -> str:
    """Return sentences, given without their full stops, as one text."""
    return " ".join(f"{part}." for part in parts)
