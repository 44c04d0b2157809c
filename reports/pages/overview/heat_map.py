"""The first page's table of errors of methods on scenes, as data for its script and as a table."""

from typing import Any

import numpy as np

from ....scenarios import EVERYWHERE, SIGNALS
from ...results.records import Pair, Row
from ...results.verdict_words import LISTED, RANKS, VERDICT
from ..analysis.best_choice import BestChoice, best_choice, best_choices, nothing_because
from ..analysis.questions import as_shipped, leading, own_timesteps
from ..analysis.report_data import MethodRuns, ReportData, SceneRuns
from ..analysis.timesteps import AT, row_at
from ..analysis.wording import NOTHING, duration, ended, limited_errors
from ..analysis.work_precision import cost
from ..tables import Cell, Table, figure, method_anchor, scene_page, table
from .overview import GROUPS, group_of


def stock_table(gathered: ReportData) -> Table:
    """Return a table of attitude errors at stock timesteps, degrees, with a row for each scene.

    Each method has a column, those as shipped first. A last column has the scene's best choice of
    method and timestep.
    """
    steps, shipped = own_timesteps(gathered), as_shipped(gathered)
    pairs = [*shipped, *(pair for pair in gathered.pairs if pair not in shipped)]
    headings = [
        f"{engine} {method}, {duration(steps[engine])}" if engine in steps else f"{engine} {method}"
        for engine, method in pairs
    ]
    rows = [
        [
            Cell(scene.name, "scene", link=scene_page(scene.name)),
            *(_stock_cell(scene, pair, steps.get(pair[0], 0.0)) for pair in pairs),
            Cell(_best_in_words(scene)),
        ]
        for scene in gathered.scenes
    ]
    return table(("scene", *headings, "cheapest run within 0.1°"), rows)


def _stock_cell(scene: SceneRuns, pair: tuple[str, str], stock: float) -> Cell:
    """Return a cell with a method's attitude error at its engine's stock timestep.

    Parameters
    ----------
    pair : engine and method
    stock : the stock timestep, s
    """
    runs = scene.by_pair.get(pair)
    if runs is None:
        return figure(NOTHING)
    row = row_at(runs, "stock", stock)
    word = runs.verdict.verdict if runs.verdict else None
    sign = f"{VERDICT[word].sign} " if word and word != "converges" else ""
    link = f"{scene_page(scene.name)}#{method_anchor(*pair)}"
    return Cell(f"{sign}{_attitude(scene, row) if row else NOTHING}", "number", link=link)


def _best_in_words(scene: SceneRuns) -> str:
    """Return a scene's best choice with its attitude error as text; `NOTHING` if there is none."""
    best = best_choice(scene)
    if best is None:
        return NOTHING
    within = "" if best.within else ", the most accurate there is"
    timestep = duration(best.timestep)
    return f"{best.runs.label} {timestep}: {_attitude(scene, best.row)}{within}"


def _attitude(scene: SceneRuns, row: Row) -> str:
    """Return a run's attitude error as text, in degrees; if it has none, how the run ended."""
    if row.errors is None:
        return ended(row) if row.made else "not run"
    return f"{limited_errors(row.errors, scene.uncertainty(row), ('attitude',))[0]}°"


#: Significant digits of numbers in the data. A cell shows two digits, and its details show three.
DIGITS = 3
#: The signal whose errors are shown at first.
FIRST_SIGNAL = "attitude"


def heat_map(gathered: ReportData) -> dict[str, Any]:
    """Return the data from which the page's script draws the table of errors.

    The entry `columns` has the methods. Each entry of `scenes` has a cell for each column, and the
    best choices, the best first. A cell is None if the method was not tried on the scene. Otherwise
    it has the runs at the engine's own stock timestep and at 1 ms, and the finest run that is `ok`
    (`AT`); each is None if there is no such run. An error that does not exceed the reference's
    uncertainty is given as that uncertainty with a minus sign.
    """
    steps = own_timesteps(gathered)
    shipped = as_shipped(gathered)
    pairs = [*shipped, *(pair for pair in gathered.pairs if pair not in shipped)]
    first = leading(gathered.plain)
    columns = [
        {
            "engine": engine,
            "method": method,
            "label": _label((engine, method), shipped),
            "shipped": (engine, method) in shipped,
            "stock": duration(steps[engine]),
            "leading": (engine, method) in first,
            "anchor": method_anchor(engine, method),
        }
        for engine, method in pairs
    ]
    scenes = []
    for scene in gathered.scenes:
        cells = [_cell(scene, scene.by_pair.get(pair), steps[pair[0]]) for pair in pairs]
        best = [_best(scene, choice, steps) for choice in best_choices(scene)]
        why_none = "" if best else nothing_because(scene)
        scenes.append(_scene(scene) | {"cells": cells, "best": best, "none": why_none})
    verdicts = {
        kind.word: {
            "sign": kind.sign,
            "rank": RANKS[kind.word],
            "needs_reason": kind.needs_reason,
        }
        for kind in LISTED
    }
    # If no scene could be solved, the script still needs a signal to show at first.
    present = {*EVERYWHERE, *(one.name for scene in gathered.scenes for one in scene.signals)}
    signals = [
        {"name": s.name, "label": s.label, "unit": s.unit} for s in SIGNALS if s.name in present
    ]
    return {
        "columns": columns,
        "scenes": scenes,
        "kinds": GROUPS,
        "verdicts": verdicts,
        "signals": signals,
    }


def _label(pair: Pair, shipped: list[Pair]) -> str:
    """Return the heading of a method's column: its name, or its engine's name if it is as shipped.

    If an engine has several methods as shipped, the heading of each but the first has the names of
    both engine and method.

    Parameters
    ----------
    pair : engine and method
    shipped : all methods as shipped, of all engines
    """
    engine, method = pair
    if pair not in shipped:
        return method
    own = [other for other in shipped if other[0] == engine]
    return engine if own[0] == pair else f"{engine}, {method.removeprefix('default-')}"


def _scene(scene: SceneRuns) -> dict[str, Any]:
    """Return the page's data about a scene, without its runs.

    They are its `name`, `title` and `tags`, the URL of its `page`, its `kind`, which is one of
    `GROUPS`, and whether it is `hard`.
    """
    scenario = scene.solved.scenario if scene.solved else None
    return {
        "name": scene.name,
        "title": scene.title,
        "page": scene_page(scene.name),
        "kind": group_of(scene),
        "hard": bool(scenario and scenario.hard),
        "tags": list(scenario.document.tags) if scenario else [],
    }


def _cell(scene: SceneRuns, runs: MethodRuns | None, stock: float) -> dict[str, Any] | None:
    """Return the page's data about a method on a scene; None if it was not tried.

    They are the word of the `verdict`, empty if there is none, and `runs`: by each of `AT`, what
    `_run` returns of that run, or None. `stock` is the stock timestep of the engine, s.
    """
    if runs is None:
        return None
    rows = {at: row_at(runs, at, stock) for at in AT}
    return {
        "verdict": runs.verdict.verdict if runs.verdict else "",
        "runs": {at: _run(scene, row) if row else None for at, row in rows.items()},
    }


def _run(scene: SceneRuns, row: Row) -> dict[str, Any]:
    """Return the page's data about a run: its errors, or how it ended if it has none.

    They are `timestep`, s, `cost`, CPU seconds a simulated second, and `errors` by signal; or, for
    a run without errors, `timestep`, `outcome`, `when` it ended, s, and `why`. An error up to the
    reference's uncertainty is given as minus the uncertainty.
    """
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
    """Return the page's data about a best choice, with its cost relative to a run as shipped.

    That run is by the same engine at its stock timestep. If there is none, it is by the first
    engine that has such a run. Its engine is the entry `default`, and the relative cost `price`,
    None if one of the two runs was not timed. `run` is what `_run` returns, and `within` says
    whether the errors are within `BOUNDS`; `label`, `engine`, `anchor` and `timestep` are texts.

    Parameters
    ----------
    best : the best choice of an engine on the scene
    steps : stock timestep of each engine, s
    """
    defaults = {
        runs.engine: cost(row)
        for runs in scene.methods
        if runs.verdict and runs.verdict.as_shipped
        if (row := row_at(runs, "stock", steps[runs.engine])) is not None
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
    """Return a number rounded to `DIGITS` digits; None for inf and NaN, which JSON lacks."""
    return float(f"{value:.{DIGITS}g}") if value is not None and np.isfinite(value) else None
