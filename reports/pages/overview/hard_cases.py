"""Which methods survive the scenes tagged `hard`: a matrix, and one line for each method."""

from statistics import median

from ...results.records import Pair
from ..analysis.report_data import MethodRuns, ReportData, SceneRuns
from ..analysis.timesteps import survival
from ..analysis.wording import NOTHING, number
from ..tables import Cell, Table, figure, named, table
from .overview import VerdictMatrix, matrix_of

#: rad a step, at which methods are compared.
TURNS = (0.01, 0.1, 1.0)


def hard_scenes(gathered: ReportData) -> tuple[SceneRuns, ...]:
    """The scenes that are tagged as hard."""
    return tuple(scene for scene in gathered.scenes if scene.solved and scene.solved.scenario.hard)


def survivors(gathered: ReportData) -> VerdictMatrix:
    """Matrix of verdicts on hard scenes, with the largest surviving timestep in each cell."""
    return matrix_of(gathered, hard_scenes(gathered), _detail)


def survivors_table(gathered: ReportData) -> Table:
    """Table of how many hard scenes each method survives, and at which timestep."""
    headings = (
        "engine",
        "method",
        "hard scenes it was run on",
        "converges",
        "survives at its finest timestep",
        *(f"survives at {turn:g} rad a step" for turn in TURNS),
        "largest turn a step it survives, rad (median)",
    )
    scenes = hard_scenes(gathered)
    return table(headings, [_line(pair, scenes) for pair in gathered.pairs])


def _detail(scene: SceneRuns, runs: MethodRuns) -> str:
    if not runs.rows:
        return "no run fits"
    survived = survival(runs.rows, scene.fastest_rate)
    return str(survived) if survived else ""


def _line(pair: Pair, scenes: tuple[SceneRuns, ...]) -> list[Cell | str]:
    tried = [
        (runs, survival(runs.rows, scene.fastest_rate))
        for scene in scenes
        if (runs := scene.by_pair.get(pair))
    ]
    can = [(runs, survived) for runs, survived in tried if survived is not None]
    converging = [runs.verdict and runs.verdict.verdict == "converges" for runs, _ in can]
    turns = [survived.turn or 0.0 for _, survived in can]
    return [
        *named(pair),
        figure(str(len(can))),
        figure(str(sum(map(bool, converging)))),
        figure(str(sum(survived.timestep is not None for _, survived in can))),
        *(figure(str(sum(survived.reaches(turn) for _, survived in can))) for turn in TURNS),
        figure(number(median(turns)) if turns else NOTHING),
    ]
