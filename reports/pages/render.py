"""Writes the report: an overview and a page for each scene, both also as Markdown."""

import base64
import zlib
from pathlib import Path
from typing import Any

from jinja2 import Environment

from ...engines.checks import read_back
from ...engines.models.mjcf import mjcf
from ...engines.models.urdf import urdf
from ...reference import solution
from ...scenarios import EFFECTS, Scenario
from ..harness.comparison import rows
from ..harness.costs import step_cost
from ..harness.executors import worker_slot
from ..harness.judging import ladder_end
from ..harness.measuring import intervals, noise, places
from ..harness.timesteps import ladder
from ..results import evidence
from ..results.results import Results
from .analysis import observed_order
from .analysis.report_data import ReportData, SceneRuns, report_data
from .cost_section import left_out_section, median_table
from .figures.figures import figures
from .markdown import as_markdown
from .overview import overview
from .overview.first_screen import answer
from .overview.heat_map import FIRST_SIGNAL, heat_map, stock_table
from .overview.spread import spread
from .page_data import PageData
from .scene import scene_tables
from .scene.default_tables import default_tables
from .scene.motion_data import motion_data
from .scene.scene_answer import gains_shown_at_first, scene_answer, shown_at_first
from .tables import table
from .templating import ReportFolder, templates, write_assets

#: What the text of the protocol quotes, by name: the formulas of rates, and modules, for their
#: constants.
RULES: dict[str, Any] = {
    "rates": " and ".join(e.rate_formula for e in EFFECTS.values() if e.rate_formula),
} | {
    module.__name__.rpartition(".")[2]: module
    for module in (
        *(evidence, ladder, ladder_end, noise, observed_order, places, read_back, rows),
        *(intervals, solution, step_cost, worker_slot),
    )
}
#: Name of the file with Plotly's script, compressed, which `figures.js` unpacks.
PLOTLY = "plotly.js"
#: Spincheck's own style sheets and scripts, which are not compressed.
ASSETS = (
    "style.css",
    "scene.css",
    "packed.js",
    "figures.js",
    "overview.js",
    "motion.js",
    "player.js",
)
#: Timestep, s, and integrator in the MJCF file that a page shows. The files that were run differ
#: from it only in these.
SHOWN_TIMESTEP, SHOWN_INTEGRATOR = 0.002, "RK4"


def render(results: Results, folder: Path) -> Path:
    """Write a report into a folder; return the path of its first page, index.html.

    The report also has report.md, assets/ and a page for each scene. The same results give the same
    files, byte for byte. Files of an earlier report are removed.

    Raises
    ------
    OSError
        If the folder cannot be written.
    """
    gathered = report_data(results)
    environment = templates()
    protocol = environment.get_template("protocol.md").render(**RULES)
    written = ReportFolder(folder)
    write_assets(written, *ASSETS)
    _write_plotly(written)
    left_out = left_out_section(results.costs)
    shared = {**_overview(gathered, results), "gathered": gathered, "left_out": left_out}
    shared["protocol"] = protocol
    shared["hard"] = _hard_cases(gathered, environment)
    packed = PageData()
    html = environment.get_template("index.html").render(root="", packed=packed, **shared)
    index = written.write("index.html", html)
    written.write("report.md", as_markdown(html, packed.items))
    _write_scenes(environment, written, gathered.scenes)
    written.finish()
    return index


def _write_scenes(
    environment: Environment,
    written: ReportFolder,
    scenes: tuple[SceneRuns, ...],
) -> None:
    """Write the pages of all scenes, as HTML and Markdown, and their model files.

    `environment` is Jinja's, with the templates of the pages.
    """
    page = environment.get_template("scene.html")
    for k, scene in enumerate(scenes):
        content, packed = _scene(scene), PageData()
        around = {
            "previous": scenes[k - 1] if k else None,
            "following": scenes[k + 1] if k + 1 < len(scenes) else None,
        }
        drawn = {
            "packed": packed,
            "figures": figures(scene),
            "motions": motion_data(scene),
            "shown_at_first": shown_at_first(scene),
            "gains_shown_at_first": gains_shown_at_first(scene),
            "methods_drawn": [(runs.label, runs.style) for runs in scene.methods if runs.drawn],
        }
        html = page.render(root="../", **drawn, **content, **around)
        written.write(f"scenes/{scene.name}.html", html)
        written.write(f"scenes/{scene.name}.md", as_markdown(html, packed.items))
        for name, model in content.get("models", {}).items():
            written.write(f"scenes/{name}", model)


def _overview(gathered: ReportData, results: Results) -> dict[str, Any]:
    """Return what the first page shows, by the names that its template uses.

    It shows the answer on the first screen, spread, heat map, tables of errors, methods and costs,
    verdicts with their reasons, and the environment.
    """
    plain = gathered.plain
    return {
        "answer": answer(gathered, results.costs),
        "spread": spread(results),
        "heat": heat_map(gathered),
        "first_signal": FIRST_SIGNAL,
        "stock": stock_table(gathered),
        "headline": overview.headline(gathered),
        "at_stock": overview.at_stock(plain),
        "methods": overview.methods_table(plain),
        "costs": median_table(plain),
        # Failures on hard scenes are listed, too; other complaints are on plain scenes alone.
        "complaints": [
            overview.complaints(gathered, lambda kind: kind.fails),
            overview.complaints(plain, lambda kind: kind.is_unproven),
            overview.complaints(plain, lambda kind: kind.word == "unsupported"),
        ],
        "shipped": overview.complaints(plain, lambda kind: kind.needs_reason, as_shipped=True),
        "environment": table(("", "value"), gathered.environment.items()),
    }


def _hard_cases(gathered: ReportData, environment: Environment) -> dict[str, Any]:
    """Return what the first page shows about hard scenes.

    The entries are `scenes`, a `text`, and `methods`, a table of the scenes that methods survive.
    `environment` is Jinja's, with the template of the text.
    """
    scenes = overview.hard_scenes(gathered)
    are = "scene is" if len(scenes) == 1 else "scenes are"
    count = f"{len(scenes)} {are}"
    return {
        "scenes": scenes,
        "text": environment.get_template("hard.md").render(count=count, **RULES),
        "methods": overview.survivors_table(gathered),
    }


def _scene(scene: SceneRuns) -> dict[str, Any]:
    """Return what a scene's page shows, by the names that its templates use.

    They are the scene, the answer at the top, and tables. Those of the exact motion and of effects
    are left out if the scene could not be solved.
    """
    content: dict[str, Any] = {
        "scene": scene,
        "answer": scene_answer(scene),
        "verdicts": scene_tables.verdict_table(scene),
        "signals": scene_tables.signals_table(scene),
        "runs": scene_tables.runs_tables(scene),
        "printed": scene_tables.printed(scene),
    }
    if scene.solved is not None:
        content |= {
            "effects": scene_tables.effects_table(scene.solved.scenario),
            "exact_motion": scene_tables.exact_motion_table(scene.solved),
            "facts": scene_tables.facts_table(scene.solved),
            "drifts": scene_tables.drifts_table(scene),
            "published": scene_tables.published_table(scene.solved.scenario),
            "models": _models(scene.solved.scenario),
            "defaults": default_tables(scene),
        }
    return content


def _models(scenario: Scenario) -> dict[str, str]:
    """Return the texts of a scene's MJCF and URDF models, by the names of their files."""
    return {
        f"{scenario.name}.xml": mjcf(scenario, SHOWN_TIMESTEP, SHOWN_INTEGRATOR),
        f"{scenario.name}.urdf": urdf(scenario),
    }


def _write_plotly(written: ReportFolder) -> None:
    """Write Plotly's script, compressed, into the folder of a report."""
    from plotly.offline import get_plotlyjs

    packed = base64.b64encode(zlib.compress(get_plotlyjs().encode("utf-8"), 9)).decode("ascii")
    written.write(f"assets/{PLOTLY}", f'const packedPlotly = "{packed}";\n')
