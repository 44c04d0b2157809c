"""What the report says about cost: on the first page, on each scene's, and in Markdown."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import plotly.graph_objects as go
import pytest
from made_up import METHODS, SECONDS_PER_STEP, WALL_SECONDS_PER_STEP, results
from markdown_text import markdown_tables
from page import Page, read_page
from plotted import coloured, values_of
from spincheck.reports.pages.analysis.cost_to_reach import LEVELS
from spincheck.reports.pages.analysis.report_data import report_data
from spincheck.reports.pages.analysis.wording import number
from spincheck.reports.pages.analysis.work_precision import curves, front
from spincheck.reports.pages.cost_section import PROFILED, cost_section
from spincheck.reports.pages.figures.ladder_figures import work_precision
from spincheck.scenarios import EVERYWHERE, SIGNAL

TOP = "made-up-top"
LABELS = [f"{method.engine} {method.method}" for method in METHODS]


@pytest.fixture(scope="module")
def first(folder: Path) -> Page:
    return read_page(folder / "index.html")


def columns_of_levels(tables: list[list[list[str]]]) -> list[list[list[str]]]:
    """The tables that end in a column for each level."""
    level_tables = [table for table in tables if table and len(table[0]) > len(LEVELS)]
    return [t for t in level_tables if all("to " in cell for cell in t[0][-len(LEVELS) :])]


def test_the_first_page_has_its_section(first: Page) -> None:
    assert "costs" in first.attribute("id")
    assert "#costs" in first.attribute("href")


def test_the_first_page_draws_its_profiles(first: Page) -> None:
    assert "profiles" in first.attribute("id")
    assert {Path(src).name for src in first.attribute("src")} == {
        "packed.js",
        "overview.js",
        "plotly.js",
        "figures.js",
    }


def test_every_method_can_be_switched_off(first: Page) -> None:
    assert set(first.attribute("data-method")) == set(LABELS)


def test_plotly_accepts_the_profiles() -> None:
    section = cost_section(report_data(results()))
    for part in section["profiles"].parts:
        go.Figure(coloured(part))
    traces = [trace for part in section["profiles"].parts for trace in part["data"]]
    assert len(traces) == len(PROFILED) * len(LABELS)


def test_what_was_not_timed_has_no_profiles() -> None:
    stored = results()
    rows = [replace(row, seconds_per_step=None) for row in stored.rows]
    assert cost_section(report_data(replace(stored, rows=rows)))["profiles"] is None


def test_the_first_page_has_reach_medians_and_ratios(first: Page, folder: Path) -> None:
    for tables in (first.tables(), markdown_tables(folder / "report.md")):
        assert len(columns_of_levels(tables)) == 3


def test_a_scene_has_a_table_an_error(folder: Path) -> None:
    page = read_page(folder / "scenes" / f"{TOP}.html")
    assert len(columns_of_levels(page.tables())) == len(EVERYWHERE)
    assert len(columns_of_levels(markdown_tables(folder / "scenes" / f"{TOP}.md"))) == len(
        EVERYWHERE
    )


def test_the_time_of_a_step_is_reported_in_cpu_time_and_on_the_wall(folder: Path) -> None:
    page = read_page(folder / "scenes" / f"{TOP}.html")
    expected = [number(1e6 * seconds) for seconds in (SECONDS_PER_STEP, WALL_SECONDS_PER_STEP)]
    for tables in (page.tables(), markdown_tables(folder / "scenes" / f"{TOP}.md")):
        headings, *rows = columns_of_levels(tables)[0]
        assert [cell.strip() for cell in headings[2:4]] == ["CPU a step, µs", "wall a step, µs"]
        (row,) = (row for row in rows if [cell.strip() for cell in row[:2]] == ["mujoco", "Euler"])
        assert [cell.replace("(", "+").partition("+")[0].strip() for cell in row[2:4]] == expected


@pytest.mark.parametrize(("part", "signal"), [*enumerate(EVERYWHERE)])
def test_the_front_is_drawn_behind_the_curves(part: int, signal: str) -> None:
    scene = next(scene for scene in report_data(results()).scenes if scene.name == TOP)
    traces = work_precision(scene)[part]["data"]
    assert [trace["name"] for trace in traces].index("Pareto front") == 0
    best = [point for _, point in front(curves(scene, signal))]
    errors = [point.error * SIGNAL[signal].shown for point in best]
    np.testing.assert_array_equal(values_of(traces[0]["x"]), np.float32([p.cost for p in best]))
    np.testing.assert_array_equal(values_of(traces[0]["y"]), np.float32(errors))
