"""Maps and ensembles in a report: pages, tables, commands that make them again."""

import math
import shlex
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import plotly.graph_objects as go
import pytest
from made_up import results
from made_up_sweeps import (
    METHODS,
    MISCHIEF,
    UNCERTAINTY,
    UPRIGHT,
    ensemble_result,
    map_result,
    scene,
    swept,
)
from markdown_text import markdown_tables, outside_code
from page import Page, read_page, unsound
from planted import HeunSession, planted
from plotted import coloured, values_of
from spincheck.reports.harness.choice import Choice
from spincheck.reports.harness.varied.sweep import plan_sweep
from spincheck.reports.pages.analysis.measures import A_TURN, ATTITUDE, OMEGA, TURNS, members_of
from spincheck.reports.pages.analysis.wording import NOTHING, readable
from spincheck.reports.pages.figures.figures import Titled
from spincheck.reports.pages.overview.spread import spread
from spincheck.reports.pages.render import render
from spincheck.reports.pages.sweeps.map_tables import percent
from spincheck.reports.pages.sweeps.sweep_pages import (
    SweepPage,
    methods_of,
    sweep_pages,
    vary_option,
)
from spincheck.reports.pages.tables import Table
from spincheck.reports.results.results import Results
from spincheck.reports.results.store import open_store
from spincheck.reports.results.sweep_records import Ensemble
from spincheck.scenarios import FloatArray
from spincheck.scenarios.vary import parse_axis

pytestmark = pytest.mark.slow

EULER, RK4, MULTIBODY = METHODS


def by_heading(table: Table, row: int) -> dict[str, str]:
    """The texts of a row."""
    return dict(zip(table.headings, (cell.text for cell in table.rows[row]), strict=True))


def curve_of(figure: Titled, name: str) -> tuple[FloatArray, FloatArray]:
    """The points of a distribution's line."""
    curve = next(t for t in figure.parts[0]["data"] if t["name"] == name)
    return values_of(curve["x"]), values_of(curve["y"])


def of_ensemble(stored: Results) -> SweepPage:
    """The page of the one ensemble."""
    (page,) = (page for page in sweep_pages(stored) if page.kind == "ensemble")
    return page


def titled(page: SweepPage, heading: str) -> Table:
    """The table below a heading."""
    (part,) = (part for part in page.tables if part.label == heading)
    return part.table


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("swept")
    render(swept(), folder)
    return folder


@pytest.fixture(scope="module")
def pages(folder: Path) -> dict[str, Page]:
    return {str(p.relative_to(folder)): read_page(p) for p in sorted(folder.rglob("*.html"))}


def test_there_is_a_page_a_map_and_an_ensemble_and_the_overview_leads_to_each(
    pages: dict[str, Page], folder: Path
) -> None:
    assert set(pages) == {
        "index.html",
        "maps/disc-1.html",
        "maps/disc-2.html",
        "maps/upright-1.html",
        "ensembles/disc-1.html",
    }
    assert set(pages) - {"index.html"} <= set(pages["index.html"].attribute("href"))
    assert unsound(folder) == {}


def test_nothing_of_the_writer_s_or_an_engine_s_own_making_is_markup(
    pages: dict[str, Page], folder: Path
) -> None:
    for page in pages.values():
        assert not [e for e in page.all("script") if "alert" in e.text and not e.attributes]
        assert MISCHIEF not in page.path.read_text(encoding="utf-8")
    for path in folder.rglob("*.md"):
        assert "<script" not in outside_code(path)


def test_a_file_without_sweeps_shows_nothing_of_them(tmp_path: Path) -> None:
    render(Results({}, {}, [], []), tmp_path)
    assert 'id="maps"' not in (tmp_path / "index.html").read_text(encoding="utf-8")
    assert "maps" not in (tmp_path / "report.md").read_text(encoding="utf-8")
    assert not (tmp_path / "maps").exists()


def test_a_file_of_sweeps_alone_shows_figures_and_no_empty_tables(
    folder: Path, pages: dict[str, Page]
) -> None:
    first = (folder / "index.html").read_text(encoding="utf-8")
    drawn = [one.figure for one in sweep_pages(swept()) if one.figure]
    assert first.count('class="plot"') == sum(len(figure.parts) for figure in drawn)
    assert "assets/plotly.js" in first
    assert pages["index.html"].tables()
    assert all(len(table) > 1 for page in pages.values() for table in page.tables())
    # Headings, dashes and at least one row.
    for path in folder.rglob("*.md"):
        assert all(len(table) > 2 for table in markdown_tables(path)), path


def test_a_sweep_keeps_what_adapters_declare(tmp_path: Path) -> None:
    """Or a report would know no order and no clamp, and draw no lines for them."""
    definition = Ensemble("disc", 1, seed=7, timestep=0.01)
    engine = planted(HeunSession)
    with open_store(tmp_path / "results.sqlite", create=True) as store:
        plan_sweep(definition, scene(), Choice((engine,), timed=False), store)
        declared = store.read().methods
    assert declared == {(engine.name, method.name): method for method in engine.methods}


def test_the_command_makes_the_same_axes_again_at_the_same_timestep() -> None:
    page, first = sweep_pages(swept())[0], swept().sweeps[0]
    words = shlex.split(page.command)
    assert words[:3] == ["spincheck", "run", "disc"]
    axes = tuple(parse_axis(words[k + 1]) for k, word in enumerate(words) if word == "--vary")
    assert axes == first.sweep.axes
    for text in ("body.mass=0.1:0.3:7", "body.mass=1e-3:2.5e7:20:log"):
        assert parse_axis(vary_option(parse_axis(text))) == parse_axis(text)
    fixed = replace(first, sweep=replace(first.sweep, timestep=0.0025))
    assert " --timestep 0.0025 " in sweep_pages(replace(swept(), sweeps=[fixed]))[0].command


def test_the_command_names_the_engines_that_were_run_and_methods_unless_all_were() -> None:
    page, known = sweep_pages(swept())[0], swept().methods
    assert page.command.endswith(" --engine mujoco --engine pybullet")
    more = known | {("mujoco", "another"): next(iter(known.values()))}
    (with_methods, *_) = sweep_pages(replace(swept(), methods=more))
    run = dict.fromkeys(method for _, method in methods_of(swept().sweeps[0], swept()))
    options = [word for method in run for word in ("--method", method)]
    assert with_methods.command.endswith(shlex.join(options))


def test_survival_is_counted_by_the_turn_a_step(folder: Path) -> None:
    """Euler diverges beyond a turn of 1, so all below survive and none above."""
    table = titled(sweep_pages(swept())[0], "What survives")
    row = by_heading(table, 0)
    assert (row["method"], row["0.3 to 1 rad"], row["over 3 rad"]) == ("Euler", "100 %", "0 %")
    assert by_heading(table, 1)["over 3 rad"] == "100 %"
    tables = markdown_tables(folder / "maps" / "disc-1.md")
    assert any("0.3 to 1 rad" in [cell.strip() for cell in table[0]] for table in tables)


def test_none_and_all_are_said_of_none_and_all_only() -> None:
    words = {0: "0 %", 1: "< 1 %", 333: "33 %", 999: "> 99 %", 1000: "100 %"}
    assert {part: percent(part, 1000) for part in words} == words


def test_quantiles_are_errors_of_members_and_what_did_not_finish_is_worse_than_any() -> None:
    """Errors 0.01 to 0.20: the 10th, the 19th and the 20th; of 20 p99 would be the largest.

    Of PyBullet's, members 0, 2, … 18 did finish: the tenth of twenty is off by 0.19.
    """
    euler, multibody = members_of(ensemble_result(20).points, [EULER, MULTIBODY])
    assert euler.quantiles(OMEGA) == (0.10, 0.19, None, 0.20)
    degrees = [math.degrees(2 * error) for error in (0.10, 0.19, 0.20)]
    assert euler.quantiles(ATTITUDE) == (*degrees[:2], None, degrees[2])
    assert len(multibody.points) == 20
    assert multibody.quantiles(OMEGA) == (0.19, math.inf, None, math.inf)


def at_stock() -> Results:
    """The ensemble at stock timesteps, its Euler as shipped."""
    stored = swept()
    *_, ensemble = stored.sweeps
    ensembles = [replace(ensemble, sweep=replace(ensemble.sweep, timestep=None))]
    shipped = replace(stored.methods["mujoco", "Euler"], as_shipped=True)
    methods = stored.methods | {("mujoco", "Euler"): shipped}
    return replace(stored, sweeps=ensembles, methods=methods)


def kinds_of(stored: Results) -> list[dict[str, Any]]:
    """The distributions of the first screen."""
    shown = spread(stored)
    assert shown is not None
    kinds: list[dict[str, Any]] = shown["kinds"]
    return kinds


def test_the_first_screen_has_the_default_and_the_best_of_each_engine() -> None:
    (of_kind,) = kinds_of(at_stock())
    assert (of_kind["kind"], of_kind["members"]) == ("free symmetric", "10")
    assert of_kind["scenes"] == [("disc", "ensembles/disc-1.html")]
    rows = [[cell.text for cell in row] for row in of_kind["table"].rows]
    assert [row[0] for row in rows] == [f"{' '.join(pair)}, 10 ms" for pair in METHODS]
    assert of_kind["table"].headings[1:] == ("p50", "p95", "p99", "largest")
    # Of ten members these would be the largest.
    assert all(row[2:4] == [NOTHING, NOTHING] for row in rows)
    median = math.degrees(2 * 0.05)
    assert rows[0][1] == readable(median)
    assert rows[2][-1] == "∞"
    errors, _ = curve_of(of_kind["figure"], "mujoco Euler")
    np.testing.assert_allclose(errors[5], median, rtol=1e-6)
    assert spread(swept()) is None


def test_ensembles_of_a_kind_are_one_distribution_without_doubled_members() -> None:
    """Ten members of one scene, twice in the file, and twenty of another."""
    stored = at_stock()
    (disc,) = stored.sweeps
    plate = replace(ensemble_result(20, "plate"), sweep=Ensemble("plate", 20, 7, None))
    (of_kind,) = kinds_of(replace(stored, sweeps=[disc, disc, plate]))
    assert of_kind["members"] == "30"
    median = math.degrees(2 * 0.08)  # Of 0.01 to 0.10 and 0.01 to 0.20, the fifteenth.
    assert of_kind["table"].rows[0][1].text == readable(median)


def test_kinds_of_motion_have_a_distribution_each() -> None:
    stored = at_stock()
    heavy = replace(stored.sweeps[0], scenario=scene(UPRIGHT, "upright"))
    kinds = kinds_of(replace(stored, sweeps=[heavy, *stored.sweeps]))
    assert [one["kind"] for one in kinds] == ["free symmetric", "heavy symmetric"]


def test_turns_until_a_degree_are_few_and_the_error_a_turn_is_large_for_the_worst() -> None:
    """Of Euler's, 12 turns through 1 to 10; RK4 never; PyBullet's odd ones as far as they went."""
    page = of_ensemble(swept())
    euler, rk4, multibody = ([c.text for c in row[4:]] for row in titled(page, TURNS.title).rows)
    assert [float(text) for text in (euler[0], euler[3])] == pytest.approx([12 / 5, 1.2], rel=0.01)
    assert rk4 == ["∞", NOTHING, NOTHING, "∞"]
    assert float(multibody[3]) == 0.1
    euler, _, multibody = ([c.text for c in row[4:]] for row in titled(page, A_TURN.title).rows)
    assert float(euler[3]) == pytest.approx(math.degrees(0.1 / 12), rel=0.01)
    assert multibody[3] == "∞"


def test_a_map_has_the_medians_of_the_same_measures() -> None:
    """Euler's runs of a turn of 0.3 to 1 rad are off by their timesteps."""
    table = titled(sweep_pages(swept())[0], f"Median: {ATTITUDE.title}")
    row = by_heading(table, 0)
    axes, turns = swept().sweeps[0].sweep.axes, (0.3, 1.0)
    within = sorted(
        step
        for spin in axes[0].values
        for step in axes[1].values
        if turns[0] < math.hypot(0.1, spin) * step <= turns[1]
    )
    median = within[len(within) // 2]
    assert float(row["0.3 to 1 rad"]) == pytest.approx(math.degrees(2 * median), rel=0.01)
    assert row["over 3 rad"] == "∞"


def test_no_error_is_reported_below_the_reference() -> None:
    points = ensemble_result().points
    sure = tuple(replace(point, reference_uncertainty=0.5) for point in points)
    assert members_of(sure, [RK4])[0].errors(OMEGA).min() == 0.5
    assert members_of(points, [RK4])[0].errors(OMEGA).min() > UNCERTAINTY


def test_the_worst_are_those_that_did_not_finish_the_earliest_first(pages: dict[str, Page]) -> None:
    (of_method,) = members_of(ensemble_result().points, [MULTIBODY])
    assert [point.varied["member"] for point in of_method.worst(7)] == [9, 7, 5, 3, 1, 8, 6]
    worst = pages["ensembles/disc-1.html"].tables()[-1]
    assert worst[1][:3] == ["mujoco", "Euler", "9"]
    # With the command that writes it.
    words = shlex.split(worst[1][-1])
    assert words[0] == "spincheck"
    assert {"disc", "9", "7"} <= set(words)


def test_the_distribution_rises_at_every_error_and_ends_at_what_finished() -> None:
    figure = of_ensemble(swept()).figure
    assert figure is not None
    go.Figure(coloured(figure.parts[0]))
    errors, shares = curve_of(figure, "mujoco Euler")
    np.testing.assert_allclose(shares, np.arange(0, 101, 10), rtol=1e-6)
    np.testing.assert_allclose(errors[1:], np.degrees(2 * np.arange(1, 11) / 100), rtol=1e-6)
    assert curve_of(figure, "pybullet multibody")[1][-1] == 50.0


def test_an_ensemble_of_which_none_finished_has_tables_and_no_figure() -> None:
    ensemble, ended = ensemble_result(), {"outcome": "failed", "cause": "crash", "errors": None}
    crashed = tuple(replace(point, **ended) for point in ensemble.points)
    page = of_ensemble(replace(swept(), sweeps=[replace(ensemble, points=crashed)]))
    assert page.figure is None
    shown = titled(page, ATTITUDE.title)
    assert {cell.text for row in shown.rows for cell in row} >= {"0 %", "∞"}


def test_the_scene_is_linked_only_where_it_has_a_page(tmp_path: Path) -> None:
    stored = results()
    name = "made-up-brick"
    of_brick = map_result(name=name)
    render(replace(stored, sweeps=[of_brick, *swept().sweeps], methods=METHODS), tmp_path)
    assert f"../scenes/{name}.html" in read_page(tmp_path / f"maps/{name}-1.html").attribute("href")
    assert "../scenes/disc.html" not in read_page(tmp_path / "maps/disc-1.html").attribute("href")
