"""Data of the first screen's table, for its script: the error of each method on each scene."""

from typing import Any

import numpy as np

from ....scenarios import SIGNALS
from ...results.records import Pair, Row
from ...results.verdict_words import LISTED, RANKS
from ..analysis.best_choice import BestChoice, best_choices, nothing_because
from ..analysis.report_data import MethodRuns, ReportData, SceneRuns
from ..analysis.timesteps import AT, as_shipped, leading, row_at, stock_timesteps
from ..analysis.wording import duration
from ..analysis.work_precision import cost
from ..links import method_anchor, scene_page
from .overview import GROUPS, group_of

#: Significant digits that are carried; cells show two, their details three.
DIGITS = 3
#: The signal whose errors are shown at first.
FIRST_SIGNAL = "attitude"


def heat_map(gathered: ReportData) -> dict[str, Any]:
    """Columns, and for each scene a cell a column and the best choices, the best of all first.

    A cell is None where a method was not tried. Its runs are by the names in `AT`, None where there
    is none. An error below the reference's uncertainty is given as that uncertainty with a minus
    sign.
    """
    steps = stock_timesteps(gathered)
    shipped = as_shipped(gathered)
    pairs = [*shipped, *(pair for pair in gathered.pairs if pair not in shipped)]
    first = leading(gathered.plain)
    columns = [
        {
            "engine": engine,
            "method": method,
            "label": _label((engine, method), shipped),
            "shipped": (engine, method) in shipped,
            "stock": duration(steps[engine]) if engine in steps else "",
            "leading": (engine, method) in first,
            "anchor": method_anchor(engine, method),
        }
        for engine, method in pairs
    ]
    scenes = []
    for scene in gathered.scenes:
        cells = [_cell(scene, scene.by_pair.get(pair), steps.get(pair[0])) for pair in pairs]
        best = [_best(scene, choice, steps) for choice in best_choices(scene)]
        why_none = "" if best else nothing_because(scene)
        scenes.append(_scene(scene) | {"cells": cells, "best": best, "none": why_none})
    verdicts = {
        kind.word: {
            "sign": kind.sign,
            "rank": RANKS[kind.word],
            "phrase": kind.phrases[0] if kind.needs_reason else "",
        }
        for kind in LISTED
    }
    signals = [{"name": s.name, "label": s.label, "unit": s.unit} for s in SIGNALS]
    return {
        "columns": columns,
        "scenes": scenes,
        "kinds": GROUPS,
        "verdicts": verdicts,
        "signals": signals,
    }


def _label(pair: Pair, shipped: list[Pair]) -> str:
    """Heading below the group's: a method's name, or the engine's if it is as shipped."""
    engine, method = pair
    if pair not in shipped:
        return method
    own = [other for other in shipped if other[0] == engine]
    return engine if own[0] == pair else f"{engine}, {method.removeprefix('default-')}"


def _scene(scene: SceneRuns) -> dict[str, Any]:
    scenario = scene.solved.scenario if scene.solved else None
    return {
        "name": scene.name,
        "title": scene.title,
        "page": scene_page(scene.name),
        "kind": group_of(scene),
        "hard": bool(scenario and scenario.hard),
        "tags": list(scenario.document.tags) if scenario else [],
    }


def _cell(scene: SceneRuns, runs: MethodRuns | None, stock: float | None) -> dict[str, Any] | None:
    if runs is None:
        return None
    rows = {at: row_at(runs, at, stock or 0.0) for at in AT}
    return {
        "verdict": runs.verdict.verdict if runs.verdict else "",
        "runs": {at: _run(scene, row) if row else None for at, row in rows.items()},
    }


def _run(scene: SceneRuns, row: Row) -> dict[str, Any]:
    if row.errors is None:
        return {
            "timestep": row.timestep,
            "outcome": row.outcome,
            "when": _rounded(row.stopped_at),
            "why": row.reason,
        }
    limits = scene.uncertainty(row)
    errors = {
        name: _rounded(-limits[name] if error <= limits[name] else error)
        for name, error in row.errors
    }
    return {"timestep": _rounded(row.timestep), "cost": _rounded(cost(row)), "errors": errors}


def _best(scene: SceneRuns, best: BestChoice, steps: dict[str, float]) -> dict[str, Any]:
    """A best choice, and how many times the default costs: its engine's own, or the first."""
    defaults = {
        runs.engine: cost(row)
        for runs in scene.methods
        if runs.verdict and runs.verdict.as_shipped
        if (row := row_at(runs, "stock", steps.get(runs.engine, 0.0))) is not None
    }
    engine = best.runs.engine
    default = defaults.get(engine, next(iter(defaults.values()), None))
    return {
        "label": best.runs.label,
        "engine": engine,
        "anchor": method_anchor(best.runs.engine, best.runs.method),
        "timestep": duration(best.timestep),
        "within": best.within,
        "default": engine if engine in defaults else next(iter(defaults), ""),
        "price": _rounded(best.cost / default) if best.cost and default else None,
        "run": _run(scene, best.row),
    }


def _rounded(value: float | None) -> float | None:
    """The number rounded to the digits carried; None for inf and NaN, which JSON lacks."""
    return float(f"{value:.{DIGITS}g}") if value is not None and np.isfinite(value) else None
