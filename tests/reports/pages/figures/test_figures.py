"""The figures: complete, valid, never claiming too much, alike on every page."""

import json
import math
import re
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import plotly.graph_objects as go
import pytest
from case_loops import each_case
from contrast import contrast
from made_up import METHODS, STOCK, TIMESTEPS, UNCERTAINTY, at_stock, evidence, results
from plotted import coloured, values_of
from spincheck.reference import facts, solve
from spincheck.reports.pages.analysis.report_data import SceneRuns, report_data
from spincheck.reports.pages.analysis.trace_style import COLOURS, DASHES, SYMBOLS, trace_styles
from spincheck.reports.pages.analysis.work_precision import curves, front
from spincheck.reports.pages.figures import ladder_figures
from spincheck.reports.pages.figures.drawn_body import MOST as MOST_DENSE
from spincheck.reports.pages.figures.drawn_body import axis_body, dense_motion
from spincheck.reports.pages.figures.figures import Titled, figures
from spincheck.reports.pages.figures.gain_figures import is_off
from spincheck.reports.pages.figures.ladder_figures import cost, work_precision
from spincheck.reports.pages.figures.plot import (
    MOST_SAMPLES,
    Figure,
    Trace,
    claimed,
    error_range,
    thinned,
)
from spincheck.reports.pages.page_data import PageData
from spincheck.reports.pages.scene.motion_data import motion_data
from spincheck.reports.pages.templating import source
from spincheck.reports.results.records import Key, Row
from spincheck.scenarios import EVERYWHERE, SIGNAL, FloatArray

pytestmark = pytest.mark.slow

TOP, BRICK, UNSOLVED = "made-up-top", "made-up-brick", "unsolved"
#: WCAG 2.1, 1.4.11: contrast of what must be seen in a figure.
GRAPHICS = 3.0
LADDER = ("convergence", "cost")
KEY = Key(TOP, "engine", "method")


def scene(name: str, samples: int = 101) -> SceneRuns:
    return {scene.name: scene for scene in report_data(at_stock(results(samples))).scenes}[name]


def drawn(of: SceneRuns) -> dict[str, Titled]:
    return {titled.name: titled for section in figures(of).values() for titled in section}


@pytest.fixture(scope="module")
def top() -> dict[str, Titled]:
    return drawn(scene(TOP))


@pytest.fixture(scope="module")
def brick() -> dict[str, Titled]:
    return drawn(scene(BRICK))


def test_a_scene_has_the_figures_of_its_kind(
    top: dict[str, Titled], brick: dict[str, Titled]
) -> None:
    motion, ladder = ["tilt", "omega", "defect"], ["gains", "convergence", "cost"]
    assert list(top) == [*motion, *ladder, "axis", "polhode", "potential"]
    assert list(brick) == [*motion, *ladder, "polhode"]
    assert drawn(scene(UNSOLVED)) == {}


def test_plotly_accepts_every_figure(top: dict[str, Titled], brick: dict[str, Titled]) -> None:
    for titled in [*top.values(), *brick.values()]:
        for part in titled.parts:
            go.Figure(coloured(part))
    with pytest.raises(ValueError, match="xaxes"):
        go.Figure(coloured(top["tilt"].parts[0] | {"layout": {"xaxes": {}}}))


def test_no_figure_shows_an_error_below_the_reference(
    top: dict[str, Titled], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert list(_errors_too_small(top)) == []
    monkeypatch.setattr(ladder_figures, "_claimed", lambda _, rows, __: np.full(len(rows), 1e-16))
    assert {titled for titled, _ in _errors_too_small(drawn(scene(TOP)))} == set(LADDER)


@pytest.mark.parametrize("figure", LADDER)
def test_every_method_that_ran_is_in_every_figure(top: dict[str, Titled], figure: str) -> None:
    ran = {f"{m.engine} {m.method}" for m in METHODS if m.verdict != "unsupported"}
    for part in top[figure].parts:
        traced = {trace.get("legendgroup") for trace in part["data"]}
        # What failed was not timed.
        assert ran - traced == (set() if figure == "convergence" else {"elsewhere fancy<i>"})


def test_gains_that_leave_what_longer_steps_predict_have_rings(top: dict[str, Titled]) -> None:
    """Those of the one method with a wrong limit, from where it shows; bands are of all methods."""
    stepped = {f"{m.engine} {m.method}" for m in METHODS if evidence(KEY, m).steps}
    parts = top["gains"].parts
    assert [part["layout"]["annotations"][0]["text"] for part in parts] == [
        "<b>Attitude</b>",
        "<b>Angular momentum</b>",
    ]
    for part in parts:
        assert {t["legendgroup"] for t in part["data"] if "fill" in t} == stepped
        rings = [t for t in part["data"] if t.get("marker", {}).get("symbol") == "circle-open"]
        assert {t["legendgroup"] for t in rings} == {"mujoco-urdf RK4"}
    curve = evidence(KEY, METHODS[2]).steps.curves[0]
    assert list(is_off(curve)[-3:]) == [True] * 3
    assert not is_off(replace(curve, gains=curve.predicted)).any()


def test_a_line_of_gains_is_those_that_were_measured(top: dict[str, Titled]) -> None:
    gains = evidence(KEY, METHODS[0]).steps.curves[0].gains
    euler = traces(top["gains"].parts[0], "mujoco Euler")
    (line,) = (t for t in euler if "markers" in t["mode"])
    np.testing.assert_array_equal(values_of(line["x"]), np.float32(TIMESTEPS))
    np.testing.assert_array_equal(values_of(line["y"]), np.float32(gains))


def test_no_line_has_more_samples_than_a_page_carries_and_each_has_both_ends() -> None:
    for titled in drawn(scene(TOP, samples=2001)).values():
        for part in titled.parts:
            for trace in part["data"]:
                assert len(values_of(trace["x"])) <= MOST_DENSE
    indices = thinned(2001)
    assert (len(indices), indices[0], indices[-1]) == (MOST_SAMPLES, 0, 2000)


def test_convergence_shows_the_error_of_every_finished_run(top: dict[str, Titled]) -> None:
    of_euler = traces(top["convergence"].parts[0], "mujoco Euler")
    euler = next(trace for trace in of_euler if trace["xaxis"] == "x")
    rows = [row for row in results().rows if _label(row.key) == "mujoco Euler" and row.errors]
    wanted = [row.errors.omega for row in rows if row.key.scenario == TOP and row.errors]
    np.testing.assert_array_equal(values_of(euler["x"]), np.float32(TIMESTEPS))
    np.testing.assert_array_equal(values_of(euler["y"]), np.float32(wanted))


@pytest.mark.parametrize("figure", LADDER)
def test_a_diverged_run_is_a_cross_on_a_strip_of_its_own(
    top: dict[str, Titled], figure: str
) -> None:
    for part in top[figure].parts:
        multibody = traces(part, "pybullet multibody")
        assert {(t["marker"]["symbol"], t["yaxis"]) for t in multibody} == {("x-thin-open", "y2")}
        assert sum(len(values_of(t["x"])) for t in multibody) == len(TIMESTEPS)
    # None with an error is there.
    marks = [t for t in top["convergence"].parts[0]["data"] if t["yaxis"] == "y2"]
    assert {t["legendgroup"] for t in marks} == {"pybullet multibody", "elsewhere fancy<i>"}


def test_stock_timesteps_have_rings(top: dict[str, Titled]) -> None:
    for part in top["convergence"].parts:
        rings = [t for t in part["data"] if t.get("marker", {}).get("symbol") == "circle-open"]
        assert rings
        for ring in rings:
            np.testing.assert_array_equal(values_of(ring["x"]), np.float32(STOCK))


def test_guides_have_the_declared_slopes(top: dict[str, Titled]) -> None:
    drawn = top["convergence"].parts[0]["data"]
    guides = [trace for trace in drawn if trace.get("name", "").startswith("order")]
    assert {t["name"] for t in guides} == {"order 1", "order 4"}
    for guide in guides:
        slope = np.polyfit(np.log(values_of(guide["x"])), np.log(values_of(guide["y"])), 1)[0]
        # Single precision: 2⁻²⁴ of each value over an octave or more.
        assert slope == pytest.approx(int(guide["name"].split()[1]), abs=4 * 2.0**-23 / math.log(2))


def test_cost_is_seconds_a_simulated_second_and_of_timed_runs(top: dict[str, Titled]) -> None:
    stored = results()
    row = next(row for row in stored.rows if row.seconds_per_step)
    assert row.seconds_per_step is not None
    assert cost(row) == row.seconds_per_step / row.timestep
    first, *_ = traces(top["cost"].parts[0], _label(row.key))
    assert values_of(first["x"])[0] == np.float32(cost(row))
    untimed = [replace(row, seconds_per_step=None) for row in stored.rows]
    gathered = report_data(replace(stored, rows=untimed))
    named = {name for scene in gathered.scenes for name in drawn(scene)}
    assert "convergence" in named
    assert "cost" not in named


@each_case(("part", "signal"), [*enumerate(EVERYWHERE)])
def test_the_front_is_drawn_behind_the_curves(part: int, signal: str) -> None:
    first, *others = work_precision(scene(TOP))[part]["data"]
    assert first["name"] == "Pareto front" not in [trace["name"] for trace in others]
    best = [point for _, point in front(curves(scene(TOP), signal))]
    errors = [point.error * SIGNAL[signal].shown for point in best]
    np.testing.assert_array_equal(values_of(first["x"]), np.float32([p.cost for p in best]))
    np.testing.assert_array_equal(values_of(first["y"]), np.float32(errors))


def test_turning_points_of_the_well_are_the_bounds_of_nutation(top: dict[str, Titled]) -> None:
    solved = scene(TOP).solved
    assert solved is not None
    exact = {fact.name: fact.value for fact in facts(solved.scenario)}
    dots = next(t for t in top["potential"].parts[0]["data"] if t["mode"] == "markers")
    bounds = np.float32([exact["nutation from"], exact["nutation to"]])
    np.testing.assert_array_equal(values_of(dots["x"]), bounds)


def exact_line(figure: Figure, drawn_scene: SceneRuns) -> FloatArray:
    """The exact motion's points, (n, 3), as the figure says to the page's script."""
    (overlay,) = figure["overlays"]
    motion = dense_motion(drawn_scene)
    along_axis = motion.to_world(axis_body(drawn_scene.exact.scenario))
    vectors = {"axis": along_axis, "omega_body": motion.omega_body}[overlay["kind"]]
    return np.asarray(vectors @ np.array(overlay["matrix"]).T)


def test_the_axis_stays_on_the_sphere_and_the_dot_is_where_it_starts(
    top: dict[str, Titled],
) -> None:
    figure = top["axis"].parts[0]
    curve, slack = exact_line(figure, scene(TOP)), 4 * np.finfo(np.float32).eps
    np.testing.assert_allclose(np.linalg.norm(curve, axis=1), 1.0, atol=slack)
    (dot,) = (t for t in figure["data"] if t["mode"] == "markers")
    np.testing.assert_allclose([values_of(dot[k])[0] for k in "xyz"], curve[0], atol=slack)


def test_the_polhode_starts_at_the_scenes_own_rates_and_stays_on_the_ellipsoid(
    brick: dict[str, Titled],
) -> None:
    """Of a free body Σ I ω² stays; the made-up motion, which is another, is not drawn."""
    solved = scene(BRICK).solved
    assert solved is not None
    tips = exact_line(brick["polhode"].parts[0], scene(BRICK))
    moments = np.diag(solved.scenario.body.inertia_com)
    slack = 8 * np.finfo(np.float32).eps
    np.testing.assert_allclose(tips**2 @ moments, 1.0, rtol=slack)
    start = solved.scenario.start.omega_body
    np.testing.assert_allclose(tips[0], start / np.sqrt(start**2 @ moments), rtol=slack)


def test_a_method_has_one_colour_in_all_engines_and_none_differ_in_hue_alone() -> None:
    drawn_as = trace_styles([("a", "Euler"), ("a", "RK4"), ("b", "RK4")])
    assert drawn_as["a", "RK4"].colour == drawn_as["b", "RK4"].colour
    assert drawn_as["a", "Euler"].colour != drawn_as["a", "RK4"].colour
    pairs = [(f"engine {k // 9}", f"method {k % 9}") for k in range(len(DASHES) * len(SYMBOLS))]
    assert len({(look.dash, look.symbol) for look in trace_styles(pairs).values()}) == len(pairs)


def test_colours_are_those_of_the_whole_study_on_every_page() -> None:
    merged: dict[str, str] = {}
    for titled in [*drawn(scene(TOP)).values(), *drawn(scene(BRICK)).values()]:
        for trace in titled.parts[0]["data"]:
            if label := trace.get("legendgroup"):
                colour = trace["line"]["color"]
                assert merged.setdefault(label, colour) == colour


def test_colours_are_different_and_stand_out_on_light_and_on_dark_paper() -> None:
    assert len(set(COLOURS)) == len(COLOURS)
    papers = re.findall(r"--paper: (#\w{6})", source("style.css"))
    assert len(papers) == 2
    for colour in COLOURS:
        assert min(contrast(colour, paper) for paper in papers) >= GRAPHICS, colour


def test_axes_reach_from_below_the_floor_to_above_the_errors_that_are_drawn() -> None:
    low, high = error_range([np.array([1e-5, np.nan, 1e-3])], floor=1e-12)
    assert low < 1e-12
    assert high > 1e-3
    # An error of nothing is not drawn.
    low, high = error_range([np.array([np.nan])], floor=np.inf)
    assert 0 < low < high < np.inf
    assert np.isnan(claimed(np.array([0.0, np.inf]), np.inf)).all()
    # Blow-ups do not squeeze the rest.
    _, high = error_range([np.array([1e-5]), np.array([1e30])], floor=1e-12)
    assert high < 1e3


@pytest.mark.parametrize("size", [1e3, 1e35, 1e150])
def test_a_run_that_blows_up_leaves_the_figures_readable(size: float) -> None:
    def wild(row: Row) -> Row:
        if row.outcome != "diverged" or row.motion is None:
            return row
        growth = np.linspace(1.0, size, len(row.motion.t))[:, None]
        return replace(row, motion=replace(row.motion, omega_body=row.motion.omega_body * growth))

    stored = results()
    gathered = report_data(replace(stored, rows=list(map(wild, stored.rows))))
    brick = next(scene for scene in gathered.scenes if scene.name == BRICK)
    for titled in drawn(brick).values():
        for part in titled.parts:
            for trace in part["data"]:
                assert not np.isinf(values_of(trace["y"])).any()
            json.dumps(part, allow_nan=False)
    page = PageData()
    page.add(motion_data(brick))
    assert page.encoded()


def test_a_run_sampled_at_times_of_its_own_is_compared_with_the_exact_motion_at_those() -> None:
    stored = results()
    motion = next(row.motion for row in stored.rows if row.key.scenario == BRICK and row.motion)
    shifted = replace(motion, t=motion.t * 1.001)
    rows = [Row(Key(BRICK, "mujoco", "Euler"), "1.0", 0.1, "ok", motion=shifted)]
    gathered = report_data(replace(stored, rows=rows))
    scenario = stored.scenes[BRICK].scenario
    (run,) = next(scene for scene in gathered.scenes if scene.name == BRICK).compared
    np.testing.assert_array_equal(run.exact.t, shifted.t)
    exact = solve(scenario, shifted.t).trajectory
    np.testing.assert_array_equal(run.exact.omega_body, exact.omega_body)


def traces(part: Figure, label: str) -> list[Trace]:
    """Those of a method."""
    return [trace for trace in part["data"] if trace.get("legendgroup") == label]


def _errors_too_small(figures: dict[str, Titled]) -> Iterator[tuple[str, float]]:
    for name in LADDER:
        for signal, part in zip(EVERYWHERE, figures[name].parts, strict=True):
            # Values are drawn in single precision, and so is their limit.
            limit = np.float32(getattr(UNCERTAINTY, signal))
            for trace in part["data"]:
                if "legendgroup" in trace and trace["yaxis"] == "y":
                    values = values_of(trace["y"])
                    yield from ((name, float(v)) for v in values[values < limit])


def _label(key: Any) -> str:
    return f"{key.engine} {key.method}"
