"""Verdicts, survivors and the cost of accuracy of every engine: docs/measured/engine-verdicts.md.

Results are kept in build/engines.sqlite: what is there already is not run again, and Ctrl-C ends
the run with a page of what is there by then.
"""

import math
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from statistics import median

from spincheck.engines import engines
from spincheck.reports.cli.choosing import choose
from spincheck.reports.cli.run.running import scenes_of
from spincheck.reports.harness.executors import LocalWorkers
from spincheck.reports.harness.ladder import QUICK_STEPS
from spincheck.reports.harness.plan import plan
from spincheck.reports.harness.study import run_study
from spincheck.reports.pages.analysis.cost_to_reach import reach
from spincheck.reports.pages.analysis.questions import ask
from spincheck.reports.pages.analysis.report_data import ReportData, report_data
from spincheck.reports.pages.analysis.work_precision import curve_of
from spincheck.reports.results.records import Pair
from spincheck.reports.results.store import Store, open_store
from spincheck.reports.results.verdict_words import RANKS

ROOT = Path(__file__).parents[3]
STORE = ROOT / "build" / "engines.sqlite"
PAGE = ROOT / "docs/measured/engine-verdicts.md"
#: Free, thrown, held, slowed and driven bodies: steps are timed, and ladders longer, on these.
TIMED = (
    "tennis-racket",
    "hammer",
    "fast-top",
    "lopsided-body",
    "book-with-drag",
    "motor-driven-top",
)
#: Steps that the ladders of all other scenes go up to.
SHORT_STEPS = 1 << 11
#: Every so-many-th scene is run first, then their neighbours.
STRIDE = 8
#: CPU seconds that a run may take.
TIME_LIMIT = 60.0
#: rad a step at which a method survives or does not.
TURN = 0.1
#: Parts of the scenes by which the ends of the table are named.
MOST, HALF = 0.8, 0.5
#: Errors of attitude, rad, whose cost is compared, with MuJoCo's RK4.
LEVELS = (1e-2, 1e-4)
YARDSTICK = ("mujoco", "RK4")
COSTS = tuple(f"cost, {math.degrees(level):.2g}°" for level in LEVELS)
HEAD = f"""# Which engines get tops right, and at what price

Scenes are counted by [verdict](../explanation/outcomes.md); the methods that converge on most
scenes come first. `default` is the engine as shipped. Ladders are short: where they do not decide,
single steps and replayed intervals do. Made by `make engine-verdicts`, with all engines
installed.

- *Error*: the median of the attitude's at the timestep that users of the engine get who set none.
- *Survives*: on how many scenes all runs with steps of up to {math.degrees(TURN):.2g}° come to
  their end and are better than no motion.
- *Cost*: CPU time to keep the attitude within an error, as a multiple of MuJoCo RK4's on the same
  scene: the median, and in parentheses the number, of scenes on which both are known.
"""
COUNTED = ", ".join(f"sum(verdict = '{word}')" for word in RANKS)
STANDINGS = f"""
    WITH off AS (SELECT engine, method, hard, median(attitude) AS error
        FROM usual JOIN tried USING (scene, engine, method) GROUP BY 1, 2, 3)
    SELECT engine, method, error, {COUNTED}, count(*) FILTER (WHERE at_least OR turn >= {TURN})
    FROM tried LEFT JOIN off USING (engine, method, hard)
    WHERE hard = ? AND verdict IS NOT NULL GROUP BY 1, 2"""
FAILED = """
    SELECT engine, method, scene FROM tried WHERE hard = ? AND verdict = 'failed'"""


def measure(store: Store) -> None:
    """Run what is missing, two processes at once."""
    library = scenes_of((), quick=False)
    timed = [scene for scene in library if scene.name in TIMED]
    # A run that is stopped leaves a sample of all kinds of motion.
    others = [scene for k in range(STRIDE) for scene in library[k::STRIDE] if scene not in timed]
    chosen = choose(["all"], [], [], time_limit=TIME_LIMIT)
    with LocalWorkers(2, TIME_LIMIT) as executor:
        for scenes, choice in (
            (timed, replace(chosen, max_steps=QUICK_STEPS)),
            (others, replace(chosen, max_steps=SHORT_STEPS, timed=False)),
        ):
            left = plan(scenes, choice, store)
            run_study(left, choice, store, executor, lambda words: print(words, flush=True))


def table(gathered: ReportData, hard: bool) -> Iterator[str]:
    """The verdicts on plain or hard scenes, in short above them, and below what failed."""
    costs = [] if hard else [_ratios(gathered, level) for level in LEVELS]
    ranked, ends = [], {"Right": [], "Wrong": []}
    for engine, method, error, *counts, survives in ask(gathered, STANDINGS, hard):
        words = dict(zip(RANKS, counts, strict=True))
        simulated = max(1, sum(counts) - words["unsupported"])
        right, wrong = words["converges"] / simulated, words["disagrees"] / simulated
        ratios = [of_level.get((engine, method), []) for of_level in costs]
        cells = [f"`{engine}`", method, str(sum(counts)), *(str(n or "") for n in counts)]
        cells += ["–" if error is None else f"{math.degrees(error):.2g}", str(survives)]
        cells += [f"{_two_digits(median(of))} ({len(of)})" if of else "–" for of in ratios]
        # Of what is right on as many, the cheapest first.
        cost = median(ratios[0]) if ratios and ratios[0] else math.inf
        ranked.append(((-right, wrong, cost), cells))
        if right >= MOST or wrong > HALF:
            ends["Right" if right >= MOST else "Wrong"].append(f"`{engine}` {method}")
    yield f"- **Right** on at least {MOST:.0%} of the scenes they can simulate: " + (
        f"{', '.join(ends['Right']) or 'none'}.\n- **Wrong at any timestep**, on more than half: "
        f"{', '.join(ends['Wrong']) or 'none'}.\n"
    )
    columns = ["engine", "method", "scenes", *RANKS, "error, °", "survives", *COSTS[: len(costs)]]
    lines = [columns, ["---"] * len(columns), *(cells for _, cells in sorted(ranked))]
    yield from (f"| {' | '.join(line)} |" for line in lines)
    yield ""
    for engine, method, scene in ask(gathered, FAILED, hard):
        yield f"- `{engine}` {method} failed on {scene}"


def page(gathered: ReportData) -> str:
    """All of it as Markdown."""
    library = scenes_of((), quick=False)
    versions = ", ".join(f"{name} {engine.version}" for name, engine in engines().items())
    parts = [HEAD]
    for title, hard in (("plain", False), ("hard", True)):
        count = sum(scene.hard == hard for scene in library)
        ((run,),) = ask(gathered, "SELECT count(DISTINCT scene) FROM tried WHERE hard = ?", hard)
        parts += [f"## {run} of the library's {count} {title} scenes\n", *table(gathered, hard), ""]
    parts.append(
        f"Ladders of up to {SHORT_STEPS} steps, of up to {QUICK_STEPS} where steps are timed: "
        f"{', '.join(TIMED)}.\n\nVersions: {versions}.\n"
    )
    return "\n".join(parts)


def main() -> None:
    """Measure, and write the page."""
    STORE.parent.mkdir(exist_ok=True)
    with open_store(STORE, create=True) as store:
        with suppress(KeyboardInterrupt):
            measure(store)
        PAGE.write_text(page(report_data(store.read())), encoding="utf-8")


def _two_digits(number: float) -> str:
    """Without an exponent where it is large."""
    short = f"{number:.2g}"
    return f"{float(short):,.0f}" if number >= 100 else short


def _ratios(gathered: ReportData, level: float) -> dict[Pair, list[float]]:
    """Of each method's cost and the yardstick's, on the scenes that are timed and have both."""
    ratios: dict[Pair, list[float]] = {}
    for scene in gathered.scenes:
        costs = {
            runs.pair: reach(curve_of(scene, runs, "attitude"), level).cost
            for runs in (scene.methods if scene.name in TIMED else ())
        }
        for pair, cost in costs.items():
            if cost is not None and (own := costs.get(YARDSTICK)):
                ratios.setdefault(pair, []).append(cost / own)
    return ratios


if __name__ == "__main__":
    main()
