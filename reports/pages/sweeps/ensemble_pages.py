"""The page of an ensemble: definition, command, distributions of errors, tables."""

import shlex
from dataclasses import dataclass

from ....scenarios import SIGNAL
from ...results.store import Results
from ...results.sweep_records import Ensemble, EnsembleResult
from ..analysis.ensemble_numbers import members_of
from ..analysis.trace_style import TraceStyle, trace_styles
from ..analysis.wording import count
from ..figures.ensemble_figure import distribution
from ..figures.figures import Titled
from ..links import ensemble_page
from ..tables import Table
from .ensemble_tables import quantile_tables, worst_table
from .map_tables import ends_table
from .sweep_pages import method_options, methods_of, numbered, timestep_in_words, timestep_option

AT_STOCK = "Every engine takes its stock timestep."
CAPTION = (
    "Percentage of the members whose largest error is at most so much. Further left is "
    "better; a curve that does not come to 100 % ends at the percentage that finished."
)

#: The signals whose errors are drawn.
DRAWN = ("attitude", "omega")


@dataclass(frozen=True, eq=False)
class EnsemblePage:
    """Everything that the HTML page and the Markdown file of an ensemble show.

    Attributes
    ----------
    name : unique in a report; `link` leads to it from the overview
    figure : None where no member finished
    shown : labels and styles of the methods in the figure
    """

    name: str
    link: str
    title: str
    scene: str
    scene_title: str
    command: str
    timestep: str
    figure: Titled | None
    shown: tuple[tuple[str, TraceStyle], ...]
    ends: Table
    quantiles: list[tuple[str, Table]]
    worst: Table


def ensemble_pages(results: Results) -> list[EnsemblePage]:
    """A page for each ensemble that has any members."""
    return [_page(name, result, results) for name, result in numbered(results.ensembles)]


def command(ensemble: Ensemble, methods: list[str]) -> str:
    """The shell command that makes this ensemble, with the options that name its methods."""
    words = ["spincheck", "run", ensemble.scenario, "--ensemble", str(ensemble.members)]
    words += ["--seed", str(ensemble.seed), *timestep_option(ensemble.timestep)]
    return shlex.join([*words, *methods])


def _page(name: str, result: EnsembleResult, results: Results) -> EnsemblePage:
    ensemble = result.sweep
    pairs = list(methods_of(result.points, results))
    members = members_of(result.points, pairs)
    drawn = trace_styles(pairs)
    compared = [of_method for of_method in members if (of_method.errors("omega") > 0).any()]
    drawing = None
    if compared:
        figures = [distribution(compared, drawn, SIGNAL[name]) for name in DRAWN]
        drawing = Titled("errors", "How errors are distributed", CAPTION, figures[0], (figures[1],))
    title = f"{count(ensemble.members)} members like {ensemble.scenario}, seed {ensemble.seed}"
    return EnsemblePage(
        name=name,
        link=ensemble_page(name),
        title=title,
        scene=ensemble.scenario,
        scene_title=result.scenario.title,
        command=command(ensemble, method_options(pairs, results)),
        timestep=timestep_in_words(ensemble.timestep, otherwise=AT_STOCK),
        figure=drawing,
        shown=tuple((" ".join(of_method.pair), drawn[of_method.pair]) for of_method in compared),
        ends=ends_table(result.points, pairs),
        quantiles=quantile_tables(members),
        worst=worst_table(ensemble, [m for m in members if m.points]),
    )
