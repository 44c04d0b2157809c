"""What the commands `view` and `plot` do."""

from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from ....reference import solve
from ....scenarios import Scenario, did_you_mean
from ....scenarios.regular_files import replacing
from ...pages.analysis.report_data import Compared, SceneRuns, report_data
from ...pages.figures.figures import figures
from ...pages.figures.plot import Figure
from ...pages.figures.signal_figures import with_runs
from ...pages.render import render
from ...results.results import Results, SceneResult
from ..choosing import Where
from ..named_scenes import one_scene
from ..run import running
from ..stopping import saying
from ..terminal import NOT_RUN, Complaint, written

#: What can be drawn: the figure of a scene's page, and which of its parts; all of them if None.
WHAT: dict[str, tuple[str, int | None]] = {
    "theta": ("tilt", None),
    "omega": ("omega", None),
    "polhode": ("polhode", 0),
    "herpolhode": ("polhode", 1),
    "axis": ("axis", None),
    "potential": ("potential", None),
    "gains": ("gains", None),
    "convergence": ("convergence", None),
    "work-precision": ("cost", None),
}
#: Of files that are written.
ENDINGS = (".svg", ".png", ".pdf")
#: Figures that show runs only, and not the exact motion.
OF_RUNS = ("gains", "convergence", "work-precision")


def view(scene: str, jobs: int, out: Path) -> Path:
    """Run a scene down short ladders and at stock timesteps, untimed; returns its page."""
    if out.exists() and not out.is_dir():
        raise Complaint(f"'--out' must be a folder, got the file '{out}'")
    with saying("nothing is kept"), TemporaryDirectory() as folder:
        stored = Path(folder) / "view.sqlite"
        results = running.run([scene], [], [], [], Where(jobs), stored, quick=True)
    render(results, out)
    name = next(iter(results.scenes), one_scene(scene).name)
    return out / "scenes" / f"{name}.html"


def plot(
    scene: str,
    what: str,
    out: Path,
    results: Path,
    engine_names: Sequence[str],
    methods: Sequence[str],
) -> None:
    """Write one figure of a scene as a file."""
    if what not in WHAT:
        raise Complaint(
            f"'--what' must be one of {', '.join(WHAT)}, got '{what}'{did_you_mean(what, WHAT)}"
        )
    if out.suffix.lower() not in ENDINGS:
        raise Complaint(f"'--out' must end with {', '.join(ENDINGS)}, got '{out}'")
    scenario = one_scene(scene)
    scene_runs = _scene_runs(scenario, results)
    if what in OF_RUNS and not any(runs.rows for runs in scene_runs.methods):
        raise Complaint(
            f"{results}: has no runs of {scenario.name}; 'spincheck run {scene}' makes them"
        )
    chosen = _chosen(scene_runs, engine_names, methods)
    if not chosen and (engine_names or methods):
        there = ", ".join({run.runs.label: None for run in scene_runs.compared}) or "none"
        raise Complaint(
            f"{results}: has no motion of {scenario.name} by {' '.join([*engine_names, *methods])} "
            f"to draw, those that it has: {there}; 'spincheck run {scene}' makes them"
        )
    parts = _parts(scene_runs, what, chosen)
    try:
        from ...pages.figures.picture import write_picture
    except ImportError:
        raise Complaint("needs matplotlib; 'pip install spincheck[plot]'", NOT_RUN) from None
    with written(out), replacing(out) as new:
        write_picture(parts, scene_runs.title, new)


def _scene_runs(scenario: Scenario, results: Path) -> SceneRuns:
    """The scene with its runs in a result file; without runs if there is no file."""
    stored = running.read(results) if results.exists() else None
    if stored is not None and scenario.name in stored.scenes:
        scene = stored.scenes[scenario.name]
        if scene.scenario.digest == scenario.digest:
            gathered = report_data(stored).scenes
            return next(one for one in gathered if one.name == scenario.name)
    exact = SceneResult(scenario, solve(scenario, scenario.times))
    (alone,) = report_data(Results({}, {scenario.name: exact}, [], [])).scenes
    return alone


def _chosen(
    scene: SceneRuns, engine_names: Sequence[str], methods: Sequence[str]
) -> tuple[Compared, ...]:
    """The runs of what was named, each at its engine's stock timestep; none if nothing was."""
    first = {run.runs.label: run for run in reversed(scene.compared)}
    engines, by = ({name.lower() for name in names} for names in (engine_names, methods))
    return tuple(
        run
        for run in reversed(first.values())
        if (engines or by)
        and (not engines or run.runs.engine.lower() in engines)
        and (not by or run.runs.method.lower() in by)
    )


def _parts(scene: SceneRuns, what: str, runs: tuple[Compared, ...]) -> list[Figure]:
    name, part = WHAT[what]
    drawn = {titled.name: titled for section in figures(scene).values() for titled in section}
    if name not in drawn:
        there = ", ".join(word for word, (figure, _) in WHAT.items() if figure in drawn)
        raise Complaint(f"{scene.name}: has no figure '{what}', but {there}")
    parts = drawn[name].parts if part is None else drawn[name].parts[part : part + 1]
    return [with_runs(figure, scene, runs) for figure in parts]
