"""Maps and ensembles in a report: their pages, and a table for the overview."""

from collections.abc import Iterable
from dataclasses import dataclass

from jinja2 import Environment

from ...results.store import Results
from ..analysis.map_marks import is_coloured
from ..analysis.wording import NOTHING, count
from ..page_data import PageData
from ..tables import Cell, Table, figure, table
from ..written import ReportFolder
from .map_tables import percent
from .sweep_pages import SweepPage, sweep_pages


@dataclass(frozen=True, eq=False)
class SweepSection:
    """Pages of maps and ensembles, and the table of them; it has no rows if there are none."""

    pages: tuple[SweepPage, ...]
    table: Table


def sweep_section(results: Results) -> SweepSection:
    """Every map and ensemble of a result file that has any runs."""
    pages = tuple(sweep_pages(results))
    return SweepSection(pages, table(("", "command", "runs", "finished"), map(_row, pages)))


def write_sweeps(
    environment: Environment, written: ReportFolder, section: SweepSection, scenes: Iterable[str]
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
    solved_scenes = set(scenes)
    for page in section.pages:
        for ending in ("html", "md"):
            text = environment.get_template(f"sweep.{ending}").render(
                root="../",
                page=page,
                packed=PageData(),
                has_scene=page.result.scenario.name in solved_scenes,
            )
            written.write(f"{page.kind}s/{page.name}.{ending}", text)


def _row(page: SweepPage) -> list[Cell]:
    run = [point for point in page.result.points if point.simulated]
    finished = sum(is_coloured(point) for point in run)
    return [
        Cell(page.title, "page", page.result.scenario.title, page.link),
        Cell(page.command, "command"),
        figure(count(len(run))),
        figure(percent(finished, len(run)) if run else NOTHING),
    ]
