"""What the report says about cost: on the first page, on each scene's, and in Markdown."""

from pathlib import Path

import numpy as np
import pytest
from markdown_text import markdown_tables
from page import Page, read_page
from plotted import values_of
from spincheck.reports.pages.analysis.cost_to_reach import LEVELS
from spincheck.reports.pages.analysis.report_data import SceneRuns
from spincheck.reports.pages.analysis.work_precision import curves, front
from spincheck.reports.pages.figures.ladder_figures import work_precision
from spincheck.scenarios import EVERYWHERE, SIGNAL

TOP = "made-up-top"


@pytest.fixture(scope="module")
def first(folder: Path) -> Page:
    return read_page(folder / "index.html")


def columns_of_levels(tables: list[list[list[str]]]) -> list[list[list[str]]]:
    """The tables that end in a column for each level."""
    level_tables = [table for table in tables if table and len(table[0]) > len(LEVELS)]
    return [t for t in level_tables if all("to " in cell for cell in t[0][-len(LEVELS) :])]


def test_the_first_page_has_its_section_and_without_figures_no_plotly(first: Page) -> None:
    assert "costs" in first.attribute("id")
    assert "#costs" in first.attribute("href")
    scripts = {"packed.js", "overview.js", "figures.js"}
    assert {Path(src).name for src in first.attribute("src")} == scripts


def test_the_first_page_has_a_table_of_costs(first: Page, folder: Path) -> None:
    for tables in (first.tables(), markdown_tables(folder / "report.md")):
        assert len(columns_of_levels(tables)) == 1


@pytest.mark.parametrize(("part", "signal"), [*enumerate(EVERYWHERE)])
def test_the_front_is_drawn_behind_the_curves(top: SceneRuns, part: int, signal: str) -> None:
    first, *others = work_precision(top)[part]["data"]
    assert first["name"] == "Pareto front" not in [trace["name"] for trace in others]
    best = [point for _, point in front(curves(top, signal))]
    errors = [point.error * SIGNAL[signal].shown for point in best]
    np.testing.assert_array_equal(values_of(first["x"]), np.float32([p.cost for p in best]))
    np.testing.assert_array_equal(values_of(first["y"]), np.float32(errors))
