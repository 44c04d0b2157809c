"""Maps and ensembles in a report: a page each, and the overview's table of them."""

import shlex
from collections import Counter
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

from jinja2 import Environment

from ....engines import Method
from ....scenarios.vary import TIMESTEP, Axis
from ...results.records import Pair
from ...results.results import Results
from ...results.sweep_records import Ensemble, Map, SweepResult
from ..analysis.map_grid import Grid, axis_title
from ..analysis.measures import ATTITUDE, FIRST, MEASURES, OMEGA, Members, is_coloured, members_of
from ..analysis.trace_style import TraceStyle, trace_styles
from ..analysis.wording import NOTHING, count
from ..figures.distribution import distribution
from ..figures.figures import Titled
from ..figures.map_figure import map_figure
from ..markdown import as_markdown
from ..page_data import PageData
from ..tables import Captioned, Cell, Table, figure, sweep_page, table
from ..templating import ReportFolder
from .map_tables import (
    bounds_table,
    ends_table,
    medians_table,
    percent,
    quantile_table,
    survival_table,
    worst_table,
)

#: Digits of a number in a command: those that were typed, and none that rounding added.
TYPED_DIGITS = 12
#: Of a run without a timestep, by the kind of sweep.
CHOSEN = {
    "map": "Timesteps are chosen run by run, so that the body turns equally far in a step.",
    "ensemble": "Every engine takes its stock timestep.",
}
ABOUT = {
    "map": "at every pair of the values of two numbers. Every point is compared with the exact "
    "motion of its own scene.",
    "ensemble": "with its start and its body scattered at random. Every member is compared with "
    "its own exact motion.",
}
CELLS = (
    "Every cell is one run against the exact motion of its own scene. Colour: the largest error of "
    "ω, relative; signs on the bare page: runs that did not finish, or were not made. Lines are "
    "drawn by theory, from the scene at t = 0 alone, and explained below."
)
CURVES = (
    "Percentage of the members whose largest error is at most so much. Further left is "
    "better; a curve that does not come to 100 % ends at the percentage that finished."
)
SURVIVAL = (
    "Percentage of runs that finished, by the angle that the body turns in a step at the start, "
    "‖ω(0)‖ dt. A run that finished may still be wrong."
)
UNFINISHED = "From the best member to the worst; a run that did not finish has the worst value."
WORST_FIRST = "Those that did not finish first, then by the error of ω."


@dataclass(frozen=True, eq=False)
class SweepPage:
    """Everything that the HTML page and the Markdown file of a sweep show.

    Attributes
    ----------
    name : unique in a report; `link` leads to it from the overview
    figure : None where no run finished
    shown : labels and styles of the methods in the figure, where they can be switched
    """

    result: SweepResult
    name: str
    title: str
    command: str
    timestep: str
    figure: Titled | None
    shown: tuple[tuple[str, TraceStyle], ...]
    tables: tuple[Captioned, ...]

    @property
    def kind(self) -> str:
        """The word for such a sweep: map or ensemble."""
        return self.result.sweep.kind

    @property
    def link(self) -> str:
        """The page, relative to the report's folder."""
        return sweep_page(self.kind, self.name)

    @property
    def about(self) -> str:
        """What is varied, in words."""
        return ABOUT[self.kind]


def sweep_pages(results: Results) -> list[SweepPage]:
    """A page for each sweep that has any points."""
    return [_page(name, result, results) for name, result in numbered(results)]


def numbered(results: Results) -> Iterator[tuple[str, SweepResult]]:
    """The sweeps that have any points, with names unique by kind: scene and number."""
    numbers: Counter[tuple[str, str]] = Counter()
    for result in results.sweeps:
        if result.points:
            scene = result.scenario.name
            numbers[result.sweep.kind, scene] += 1
            yield f"{scene}-{numbers[result.sweep.kind, scene]}", result


def methods_of(result: SweepResult, results: Results) -> dict[Pair, Method | None]:
    """Those that were run, engines by name, their methods as the adapter lists them."""
    listed = {pair: rank for rank, pair in enumerate(results.methods)}
    pairs = {point.pair for point in result.points}
    ordered = sorted(pairs, key=lambda p: (p[0], listed.get(p, len(listed)), p[1]))
    return {pair: results.methods.get(pair) for pair in ordered}


def _page(name: str, result: SweepResult, results: Results) -> SweepPage:
    methods, sweep = methods_of(result, results), result.sweep
    drawn: tuple[Titled | None, tuple[tuple[str, TraceStyle], ...]]
    if isinstance(sweep, Map):
        title = f"{sweep.scenario}: {sweep.axes[0].path} × {sweep.axes[1].path}"
        grid = Grid(result, methods, results.stock_timesteps)
        across, up = (axis_title(axis) for axis in grid.axes)
        shown = Titled(f"map-{name}", f"{up} against {across}", CELLS, [map_figure(grid)])
        drawn, tables = (shown, ()), _map_tables(grid)
    else:
        title = f"{count(sweep.members)} members like {sweep.scenario}, seed {sweep.seed}"
        members = members_of(result.points, methods)
        ends = ends_table(result.points, methods)
        drawn, tables = _distributions(name, members), _ensemble_tables(sweep, members, ends)
    command = shlex.join([*_words(sweep), *_method_options(methods, results)])
    return SweepPage(result, name, title, command, _timestep_in_words(sweep), *drawn, tables)


def _map_tables(grid: Grid) -> tuple[Captioned, ...]:
    lines = bounds_table(grid)
    ends = ends_table(grid.result.points, grid.methods)
    return (
        *([Captioned("What the lines say", "", lines)] if lines.rows else []),
        Captioned("What survives", SURVIVAL, survival_table(grid)),
        *(
            Captioned(f"Median: {one.title}", UNFINISHED, medians_table(grid, one), folded=True)
            for one in FIRST
        ),
        Captioned("How runs ended", "", ends),
    )


def _distributions(
    name: str,
    members: Sequence[Members],
) -> tuple[Titled | None, tuple[tuple[str, TraceStyle], ...]]:
    """The figure of an ensemble, if there is anything to draw, and its methods."""
    styles = trace_styles([one.pair for one in members])
    compared = [one for one in members if (one.errors(OMEGA) > 0).any()]
    if not compared:
        return None, ()
    parts = [distribution(compared, styles, measure) for measure in (ATTITUDE, OMEGA)]
    shown = tuple((" ".join(one.pair), styles[one.pair]) for one in compared)
    figure = Titled(f"errors-{name}", "How errors are distributed", CURVES, parts)
    return figure, shown


def _ensemble_tables(
    ensemble: Ensemble, members: Sequence[Members], ends: Table
) -> tuple[Captioned, ...]:
    worst = worst_table(ensemble, [one for one in members if one.points])
    return (
        Captioned("How members ended", "", ends),
        *(
            Captioned(one.title, UNFINISHED, quantile_table(members, one), one not in FIRST)
            for one in MEASURES
            if one in FIRST or any(of_method.errors(one).size for of_method in members)
        ),
        Captioned("The worst members", WORST_FIRST, worst),
    )


def _words(sweep: Map | Ensemble) -> list[str]:
    """The shell command that makes a sweep, without its methods."""
    if isinstance(sweep, Map):
        words = ["spincheck", "run", sweep.scenario]
        for axis in sweep.axes:
            words += ["--vary", vary_option(axis)]
    else:
        words = ["spincheck", "run", sweep.scenario, "--ensemble", str(sweep.members)]
        words += ["--seed", str(sweep.seed)]
    return words if sweep.timestep is None else [*words, "--timestep", _typed(sweep.timestep)]


def vary_option(axis: Axis) -> str:
    """An axis as `PATH=LO:HI:COUNT[:log]`."""
    low, high = _typed(axis.values[0]), _typed(axis.values[-1])
    spacing = ":log" if axis.logarithmic else ""
    return f"{axis.path}={low}:{high}:{len(axis.values)}{spacing}"


def _typed(value: float) -> str:
    """A number as in a command."""
    return f"{value:.{TYPED_DIGITS}g}"


def _method_options(pairs: dict[Pair, Method | None], results: Results) -> list[str]:
    """The words of a command that name engines, and methods if not all of these were run."""
    names = dict.fromkeys(engine for engine, _ in pairs)
    words = [word for name in names for word in ("--engine", name)]
    if set(pairs) >= {pair for pair in results.methods if pair[0] in names}:
        return words
    methods = dict.fromkeys(method for _, method in pairs)
    return words + [word for name in methods for word in ("--method", name)]


def _timestep_in_words(sweep: Map | Ensemble) -> str:
    """Which timestep the runs take, where it is not an axis."""
    if TIMESTEP in sweep.names:
        return ""
    if sweep.timestep is None:
        return CHOSEN[sweep.kind]
    return f"Every run takes steps of {sweep.timestep:g} s."


def sweeps_table(pages: Sequence[SweepPage]) -> Table:
    """The overview's table of maps and ensembles; it has no rows if there are none."""
    return table(("", "command", "runs", "finished"), map(_row, pages))


def write_sweeps(
    environment: Environment,
    written: ReportFolder,
    pages: Sequence[SweepPage],
    scenes: Collection[str],
) -> None:
    """Write maps/ and ensembles/, each page as .html and .md.

    Parameters
    ----------
    scenes : names of those that have a page

    Raises
    ------
    OSError
        If the folder cannot be written.
    """
    template = environment.get_template("sweep.html")
    for page in pages:
        html = template.render(
            root="../",
            page=page,
            packed=(packed := PageData()),
            has_scene=page.result.scenario.name in scenes,
        )
        written.write(f"{page.kind}s/{page.name}.html", html)
        written.write(f"{page.kind}s/{page.name}.md", as_markdown(html, packed.items))


def _row(page: SweepPage) -> list[Cell]:
    run = [point for point in page.result.points if point.simulated]
    finished = sum(is_coloured(point) for point in run)
    return [
        Cell(page.title, "page", page.result.scenario.title, page.link),
        Cell(page.command, "command"),
        figure(count(len(run))),
        figure(percent(finished, len(run)) if run else NOTHING),
    ]
