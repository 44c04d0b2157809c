"""Verdicts, survivors and the cost of accuracy of every engine there is; docs/engine-verdicts.md.

Results are kept in build/engines.sqlite: what is there already is not run again.
"""

import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from itertools import groupby
from pathlib import Path
from statistics import median

from spincheck.engines import engines
from spincheck.reports.cli.choosing import choose
from spincheck.reports.cli.running import scenes_of
from spincheck.reports.harness.choice import QUICK_STEPS
from spincheck.reports.harness.executors import LocalWorkers
from spincheck.reports.harness.plan import plan
from spincheck.reports.harness.study import run_study
from spincheck.reports.pages.analysis.cost_to_reach import reach
from spincheck.reports.pages.analysis.report_data import ReportData, report_data
from spincheck.reports.pages.analysis.survival import survival
from spincheck.reports.pages.analysis.work_precision import curve_of
from spincheck.reports.results.records import Key
from spincheck.reports.results.store import open_store

ROOT = Path(__file__).parents[3]
STORE = ROOT / "build" / "engines.sqlite"
PAGE = ROOT / "docs" / "engine-verdicts.md"
#: Of each kind of the library, the effects and traps that engines differ in.
SCENES = (
    "tennis-racket",
    "book-short-axis",
    "fast-top",
    "lopsided-body",
    "hammer",
    "book-with-drag",
    "motor-driven-top",
    "stuck-thruster",
    "separatrix-within-1e-3",
    "gyroscope-at-24000-rpm",
)
#: rad a step at which a method survives or does not.
TURN = 0.1
#: Errors of attitude, rad, whose cost is compared, with MuJoCo's RK4.
LEVELS = (1e-2, 1e-4)
YARDSTICK = ("mujoco", "RK4")
VERDICTS = ("converges", "unresolved", "disagrees", "diverges", "failed", "unsupported")
COLUMNS = (
    "engine",
    "method",
    *VERDICTS,
    "survives",
    *(f"cost, {level:g} rad" for level in LEVELS),
)
HEAD = f"""# Verdicts, survivors and cost, engine by engine

Made by `make engine-verdicts` from every engine that was there: {len(SCENES)} scenes, ladders of up
to {QUICK_STEPS} steps. *Survives*: on how many scenes every run of at most {TURN:g} rad a step
comes to its end and is better than no motion. *Cost*: CPU time to keep the attitude within
{LEVELS[0]:g} and {LEVELS[1]:g} rad, as a multiple of MuJoCo RK4's on the same scene, median; behind
it on how many scenes it could be told. What a ladder of this length cannot decide is `unresolved`.

Scenes: {", ".join(SCENES)}.

| {" | ".join(COLUMNS)} |
|{"---|" * len(COLUMNS)}
"""


def measured() -> ReportData:
    """Run what is missing; two processes at once."""
    STORE.parent.mkdir(exist_ok=True)
    scenarios = scenes_of(SCENES, quick=False)
    choice = replace(choose([], [], []), max_steps=QUICK_STEPS)
    with open_store(STORE, create=True) as store:
        to_run = plan(scenarios, choice, store)
        with LocalWorkers(2) as executor:
            run_study(to_run, choice, store, executor, lambda words: print(words, flush=True))
        return report_data(store.read())


def costs(gathered: ReportData) -> dict[tuple[Key, float], float]:
    """CPU seconds a simulated second of each method, scene and level that it can be told of."""
    cost_at = {}
    for scene in gathered.scenes:
        for runs in scene.methods:
            for level in LEVELS:
                cost = reach(curve_of(scene, runs, "attitude"), level).cost
                if cost is not None:
                    cost_at[Key(scene.name, runs.engine, runs.method), level] = cost
    return cost_at


def rows(gathered: ReportData) -> Iterator[str]:
    """A line of the table for each method."""
    cost_of = costs(gathered)
    runs_of = [(scene, runs) for scene in gathered.scenes for runs in scene.methods]
    runs_of.sort(key=lambda pair: (pair[1].engine, pair[1].method))
    for (engine, method), group in groupby(runs_of, lambda pair: (pair[1].engine, pair[1].method)):
        pairs = list(group)
        verdicts = Counter(runs.verdict.verdict for _, runs in pairs if runs.verdict)
        lives = [survival(runs.rows, scene.fastest_rate) for scene, runs in pairs]
        survives = sum(life.reaches(TURN) for life in lives if life)
        columns = [str(verdicts[name] or "") for name in VERDICTS]
        columns.append(f"{survives} of {sum(life is not None for life in lives)}")
        for level in LEVELS:
            ratios = [
                cost_of[Key(scene.name, engine, method), level] / yardstick
                for scene, _ in pairs
                if (yardstick := cost_of.get((Key(scene.name, *YARDSTICK), level)))
                and (Key(scene.name, engine, method), level) in cost_of
            ]
            columns.append(f"{median(ratios):.2g} ({len(ratios)})" if ratios else "–")
        yield f"| `{engine}` | {method} | {' | '.join(columns)} |"


def main() -> None:
    """Measure, and write the page."""
    gathered = measured()
    versions = ", ".join(f"{name} {engine.version}" for name, engine in engines().items())
    text = HEAD + "\n".join(rows(gathered)) + f"\n\nVersions: {versions}.\n"
    PAGE.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())
