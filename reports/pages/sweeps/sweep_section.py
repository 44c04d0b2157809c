"""Maps and ensembles in a report: their pages, and tables for the overview."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from jinja2 import Environment

from ...results.store import Results
from ...results.sweep_records import PointResult
from ..analysis.map_marks import is_coloured
from ..analysis.wording import NOTHING, count
from ..page_data import PageData
from ..tables import Cell, Table, figure, table
from ..written import ReportFolder
from .ensemble_pages import EnsemblePage, ensemble_pages
from .map_pages import MapPage, map_pages
from .map_tables import percent


@dataclass(frozen=True, eq=False)
class SweepSection:
    """Pages and tables of maps and ensembles; tables have no rows if there are none."""

    maps: tuple[MapPage, ...]
    ensembles: tuple[EnsemblePage, ...]
    maps_table: Table
    ensembles_table: Table


def sweep_section(results: Results) -> SweepSection:
    """Every map and ensemble of a result file that has any runs."""
    maps, ensembles = tuple(map_pages(results)), tuple(ensemble_pages(results))
    return SweepSection(
        maps,
        ensembles,
        _overview("map", maps, _with_runs(result.points for result in results.maps)),
        _overview("ensemble", ensembles, _with_runs(result.points for result in results.ensembles)),
    )


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
    for kind, pages in (("map", section.maps), ("ensemble", section.ensembles)):
        for page in pages:
            for ending in ("html", "md"):
                text = environment.get_template(f"{kind}.{ending}").render(
                    root="../",
                    page=page,
                    packed=PageData(),
                    has_scene=page.scene in solved_scenes,
                )
                written.write(f"{kind}s/{page.name}.{ending}", text)


def _with_runs(sweeps: Iterable[tuple[PointResult, ...]]) -> list[tuple[PointResult, ...]]:
    return [points for points in sweeps if any(point.key.engine for point in points)]


def _overview(
    kind: str,
    pages: Sequence[MapPage | EnsemblePage],
    points_of: Sequence[tuple[PointResult, ...]],
) -> Table:
    rows = (
        [
            Cell(page.title, "page", page.scene_title, page.link),
            Cell(page.command, "command"),
            *_counts(points),
        ]
        for page, points in zip(pages, points_of, strict=True)
    )
    return table((kind, "command", "runs", "finished"), rows)


def _counts(points: tuple[PointResult, ...]) -> list[Cell]:
    run = [point for point in points if point.outcome in ("ok", "diverged", "failed")]
    finished = sum(is_coloured(point) for point in run)
    return [figure(count(len(run))), figure(percent(finished, len(run)) if run else NOTHING)]
