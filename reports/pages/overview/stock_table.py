"""The first screen as Markdown: attitude errors at stock timesteps, and the best choice."""

import math

from ...results.records import Row
from ...results.verdict_words import VERDICT
from ..analysis.best_choice import best_choice
from ..analysis.report_data import ReportData, SceneRuns
from ..analysis.timesteps import as_shipped, row_at, stock_timesteps
from ..analysis.wording import NOTHING, duration, limited
from ..links import scene_page
from ..tables import Cell, Table, figure, table


def stock_table(gathered: ReportData) -> Table:
    """One line for each scene: attitude errors of all methods in degrees, as shipped first."""
    steps, shipped = stock_timesteps(gathered), as_shipped(gathered)
    pairs = [*shipped, *(pair for pair in gathered.pairs if pair not in shipped)]
    headings = [
        f"{engine} {method}, {duration(steps[engine])}" if engine in steps else f"{engine} {method}"
        for engine, method in pairs
    ]
    rows = [
        [
            Cell(scene.name, "scene", link=scene_page(scene.name)),
            *(_cell(scene, pair, steps.get(pair[0], 0.0)) for pair in pairs),
            Cell(_best(scene)),
        ]
        for scene in gathered.scenes
    ]
    return table(("scene", *headings, "cheapest run within 0.1°"), rows)


def _cell(scene: SceneRuns, pair: tuple[str, str], stock: float) -> Cell:
    runs = scene.by_pair.get(pair)
    if runs is None:
        return figure(NOTHING)
    row = row_at(runs, "stock", stock)
    word = runs.verdict.verdict if runs.verdict else None
    sign = f"{VERDICT[word].sign} " if word and word != "converges" else ""
    return figure(f"{sign}{_attitude(scene, row) if row else NOTHING}")


def _best(scene: SceneRuns) -> str:
    best = best_choice(scene)
    if best is None:
        return NOTHING
    within = "" if best.within else ", the most accurate there is"
    timestep = duration(best.timestep)
    return f"{best.runs.label} {timestep}: {_attitude(scene, best.row)}{within}"


def _attitude(scene: SceneRuns, row: Row) -> str:
    """The attitude error in degrees, at least the uncertainty; without one, how the run ended."""
    if row.errors is None:
        when = f" at {duration(row.stopped_at)}" if row.stopped_at else ""
        return f"{row.outcome}{when}" if row.made else "not run"
    limit = math.degrees(scene.uncertainty(row).attitude)
    return f"{limited(math.degrees(row.errors.attitude), limit)}°"
