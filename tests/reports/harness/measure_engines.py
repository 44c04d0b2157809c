"""Verdicts, survivors and the cost of accuracy of every engine: docs/measured/engine-verdicts.md.

Results are kept in build/engines.sqlite: what is there already is not run again, and Ctrl-C ends
the run with a page of what is there by then.
"""

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import groupby
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
from spincheck.reports.pages.analysis.report_data import MethodRuns, SceneRuns, report_data
from spincheck.reports.pages.analysis.timesteps import survival
from spincheck.reports.pages.analysis.work_precision import curve_of
from spincheck.reports.results.store import Store, open_store
from spincheck.reports.results.verdict_words import RANKS, VerdictWord

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
COLUMNS = ("engine", "method", "scenes", *RANKS, "error, °", "survives")
COSTS = tuple(f"cost, {math.degrees(level):.2g}°" for level in LEVELS)
HEAD = f"""# Which engines get tops right, and at what price

Scenes are counted by [verdict](../explanation/outcomes.md); the methods that converge on most
scenes come first. `default` is the engine as shipped. Ladders are short: where they do not decide,
single steps and replayed intervals do. Made by `make engine-verdicts`, with all engines
installed.

- *Error* and *survives*, with steps of up to {math.degrees(TURN):.2g}°: the median error of the
  attitude, and on how many scenes all such runs come to their end and are better than no motion.
- *Cost*: CPU time to keep the attitude within an error, as a multiple of MuJoCo RK4's on the same
  scene: the median, and in parentheses the number, of scenes on which both are known.
"""

Cell = tuple[SceneRuns, MethodRuns]


@dataclass(frozen=True)
class Standing:
    """What one method did on all the scenes of a table.

    Attributes
    ----------
    errors : of the attitude at `TURN`, rad, one a scene; infinite where the run did not end well
    ratios : at each of `LEVELS`, of its cost and the yardstick's, on the scenes of both
    """

    engine: str
    method: str
    verdicts: Counter[VerdictWord]
    survives: int
    errors: list[float]
    ratios: tuple[list[float], ...]

    @property
    def label(self) -> str:
        """As users type it."""
        return f"`{self.engine}` {self.method}"

    def share(self, verdict: VerdictWord) -> float:
        """Part of the scenes that the method can simulate."""
        simulated = self.verdicts.total() - self.verdicts["unsupported"]
        return self.verdicts[verdict] / max(1, simulated)

    @property
    def rank(self) -> tuple[float, ...]:
        """Sorts the methods that are right on most of what they can simulate to the front."""
        wrong = sum(self.share(verdict) for verdict in ("disagrees", "diverges", "failed"))
        cost = median(self.ratios[0]) if self.ratios[0] else math.inf
        return -self.share("converges"), wrong, cost

    def row(self, columns: Sequence[str]) -> str:
        """As a line of the table."""
        cells = {word: str(self.verdicts[word] or "") for word in RANKS} | {
            "engine": f"`{self.engine}`",
            "method": self.method,
            "scenes": str(self.verdicts.total()),
            "error, °": f"{math.degrees(median(self.errors)):.2g}" if self.errors else "–",
            "survives": str(self.survives),
        }
        for name, ratios in zip(COSTS, self.ratios, strict=True):
            cells[name] = f"{_two_digits(median(ratios))} ({len(ratios)})" if ratios else "–"
        return f"| {' | '.join(cells[column] for column in columns)} |"


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


def standings(scenes: Sequence[SceneRuns]) -> list[Standing]:
    """Of every method that has a verdict, best first."""
    cells = [(scene, runs) for scene in scenes for runs in scene.methods if runs.verdict]
    cells.sort(key=_name)
    costs = [_costs(scenes, level) for level in LEVELS]
    return sorted(
        (_standing(*name, list(group), costs) for name, group in groupby(cells, _name)),
        key=lambda standing: standing.rank,
    )


def in_short(ranked: Sequence[Standing]) -> str:
    """The two ends of the table."""
    right = ", ".join(one.label for one in ranked if one.share("converges") >= MOST)
    wrong = ", ".join(one.label for one in ranked if one.share("disagrees") > HALF)
    return (
        f"- **Right** on at least {MOST:.0%} of the scenes they can simulate: {right or 'none'}.\n"
        f"- **Wrong at any timestep**, on more than half: {wrong or 'none'}.\n"
    )


def table(scenes: Sequence[SceneRuns], columns: Sequence[str]) -> str:
    """The verdicts on some scenes, in short above it, and below it why a method failed on one."""
    lines = [f"| {' | '.join(columns)} |", f"|{'---|' * len(columns)}"]
    ranked = standings(scenes)
    lines += [standing.row(columns) for standing in ranked]
    return "\n".join([in_short(ranked), *lines, "", *failures(scenes)])


def failures(scenes: Sequence[SceneRuns]) -> Iterator[str]:
    """Every `failed`, with its reason."""
    for scene in scenes:
        for runs in scene.methods:
            if runs.verdict and runs.verdict.verdict == "failed":
                who = f"`{runs.engine}` {runs.method}"
                yield f"- {who} failed on {scene.name}: {runs.verdict.reason}"


def page(scenes: Sequence[SceneRuns]) -> str:
    """All of it as Markdown."""
    library = scenes_of((), quick=False)
    versions = ", ".join(f"{name} {engine.version}" for name, engine in engines().items())
    parts = [HEAD]
    for title, is_hard, columns in (("plain", False, COSTS), ("hard", True, ())):
        names = {scene.name for scene in library if scene.hard == is_hard}
        run = [scene for scene in scenes if scene.name in names]
        parts.append(f"## {len(run)} of the library's {len(names)} {title} scenes\n")
        parts.append(table(run, (*COLUMNS, *columns)) + "\n")
    parts.append(
        f"Ladders of up to {SHORT_STEPS} steps, of up to {QUICK_STEPS} where steps are timed: "
        f"{', '.join(TIMED)}.\n"
    )
    return "\n".join([*parts, f"Versions: {versions}.\n"])


def main() -> None:
    """Measure, and write the page."""
    STORE.parent.mkdir(exist_ok=True)
    with open_store(STORE, create=True) as store:
        with suppress(KeyboardInterrupt):
            measure(store)
        PAGE.write_text(page(report_data(store.read()).scenes), encoding="utf-8")


def _two_digits(number: float) -> str:
    """Without an exponent where it is large."""
    short = f"{number:.2g}"
    return f"{float(short):,.0f}" if number >= 100 else short


def _name(cell: Cell) -> tuple[str, str]:
    return cell[1].engine, cell[1].method


def _standing(
    engine: str, method: str, cells: list[Cell], costs: list[dict[tuple[str, str, str], float]]
) -> Standing:
    lives = [survival(runs.rows, scene.fastest_rate) for scene, runs in cells if scene.solved]
    ratios = tuple(
        [
            at_level[scene.name, engine, method] / at_level[scene.name, *YARDSTICK]
            for scene, _ in cells
            if {(scene.name, engine, method), (scene.name, *YARDSTICK)} <= at_level.keys()
        ]
        for at_level in costs
    )
    verdicts = Counter(runs.verdict.verdict for _, runs in cells if runs.verdict)
    survives = sum(life.reaches(TURN) for life in lives if life)
    errors = [error for scene, runs in cells if (error := _error(scene, runs)) is not None]
    return Standing(engine, method, verdicts, survives, errors, ratios)


def _error(scene: SceneRuns, runs: MethodRuns) -> float | None:
    """Of the attitude, rad, at the ladder's largest timestep of at most `TURN`."""
    if not scene.solved:
        return None
    fine = [row for row in runs.rows if row.made and not row.stock]
    fine = [row for row in fine if row.timestep * scene.fastest_rate <= TURN]
    run = max(fine, key=lambda row: row.timestep, default=None)
    if run is None or run.outcome == "unsupported":
        return None
    return run.errors.attitude if run.errors else math.inf


def _costs(scenes: Sequence[SceneRuns], level: float) -> dict[tuple[str, str, str], float]:
    """CPU seconds a simulated second by scene, engine and method, where it can be told."""
    priced = {
        (scene.name, runs.engine, runs.method): reach(curve_of(scene, runs, "attitude"), level).cost
        for scene in scenes
        if scene.name in TIMED
        for runs in scene.methods
    }
    return {name: cost for name, cost in priced.items() if cost is not None}


if __name__ == "__main__":
    main()
