"""Maps as figures: a run a place, errors as colours, the rest as signs, theory as lines."""

import json
import math
from dataclasses import replace
from html import escape
from types import SimpleNamespace

import numpy as np
import plotly.graph_objects as go
import pytest
from contrast import contrast
from made_up_sweeps import METHODS, MISCHIEF, UNCERTAINTY, UPRIGHT, map_result
from plotted import coloured, values_of
from spincheck.reference.stability_bounds import RK4_LIMIT
from spincheck.reports.pages.analysis.map_grid import Grid, axis_title, places, with_unit
from spincheck.reports.pages.analysis.measures import COLOURS, HORIZON, SIGNS, is_coloured, marks
from spincheck.reports.pages.figures import map_axes
from spincheck.reports.pages.figures import map_figure as map_figure_module
from spincheck.reports.pages.figures.map_bounds import bounds_of, clamp
from spincheck.reports.pages.figures.map_figure import drawn_bounds, legend_of_bounds, map_figure
from spincheck.reports.pages.figures.plot import Figure
from spincheck.reports.results.sweep_records import SweepResult
from spincheck.scenarios.vary import parse_axis

#: WCAG 2.1, 1.4.11.
GRAPHICS = 3.0
PAPERS = ("#ffffff", "#14171b")
EULER, RK4, MULTIBODY = METHODS
#: Figures are packed in single precision.
SINGLE = 2 * float(np.finfo(np.float32).eps)


#: s, of MuJoCo alone.
STOCK = 0.002


def grid(result: SweepResult | None = None) -> Grid:
    return Grid(result or map_result(), dict(METHODS), {"mujoco": STOCK})


@pytest.fixture(scope="module")
def figure() -> Figure:
    return map_figure(grid())


def heatmap(figure: Figure, k: int) -> np.ndarray:
    axis = f"x{k}" if k > 1 else "x"
    (trace,) = (t for t in figure["data"] if t["type"] == "heatmap" and t["xaxis"] == axis)
    rows, columns = map(int, trace["z"]["shape"].split(","))
    return values_of(trace["z"]).reshape(rows, columns)


def test_there_is_a_panel_a_method(figure: Figure) -> None:
    go.Figure(coloured(figure))
    headings = [note["text"] for note in figure["layout"]["annotations"] if "<b>" in note["text"]]
    assert headings == [f"<b>{' '.join(pair)}</b>" for pair in METHODS]


def test_colour_is_the_error_of_omega_and_never_below_the_reference(figure: Figure) -> None:
    trace = heatmap(figure, 2)
    timesteps = np.array(grid().axes[1].values)
    wanted = np.log10(np.maximum(timesteps**4, UNCERTAINTY))
    np.testing.assert_allclose(trace, np.tile(wanted[:, None], 9), rtol=SINGLE)
    assert trace.min() > np.log10(timesteps.min() ** 4) + 0.5


def test_every_run_is_either_coloured_or_signed(figure: Figure) -> None:
    for k, pair in enumerate(METHODS, start=1):
        axis = f"x{k}" if k > 1 else "x"
        signed = sum(
            len(values_of(t["x"]))
            for t in figure["data"]
            if t.get("mode") == "markers" and t.get("xaxis") == axis
        )
        assert np.isfinite(heatmap(figure, k)).sum() + signed == 9 * 7
        assert signed == sum(not is_coloured(p) for p in grid().points[pair].values())


def test_diverged_runs_are_signed_by_cause(figure: Figure) -> None:
    entries = [t for t in figure["data"] if t.get("showlegend") and t["mode"] == "markers"]
    names = [t["name"] for t in entries]
    assert names == ["diverged: energy", "diverged: not-finite", "unsupported: clamp"]
    assert len({t["marker"]["symbol"] for t in entries}) == 3


def test_signs_of_different_outcomes_differ_and_stand_out() -> None:
    every = [symbol for signs in SIGNS.values() for symbol in signs]
    assert len(set(every)) == len(every)
    for outcome, colour in COLOURS.items():
        assert min(contrast(colour, paper) for paper in PAPERS) >= GRAPHICS, outcome


def test_nothing_that_an_engine_said_is_markup(figure: Figure) -> None:
    assert "alert" in json.dumps(figure)
    assert MISCHIEF not in json.dumps(figure)
    assert "<script" not in json.dumps(figure)


def test_panels_share_their_axes_whose_titles_stand_outside_only(figure: Figure) -> None:
    layout = figure["layout"]
    # Plotly complains of an axis that is to match itself.
    assert "matches" not in layout["xaxis"]
    for k in (2, 3):
        assert layout[f"xaxis{k}"]["matches"] == "x"
        assert layout[f"xaxis{k}"]["range"] == layout["xaxis"]["range"]
    assert layout["xaxis"]["title"]["text"] == "start.omega_body[2], rad/s"
    assert layout["yaxis"]["title"]["text"] == "timestep, s"
    assert layout["yaxis2"]["title"]["text"] == ""
    assert not layout["yaxis2"]["showticklabels"]


@pytest.mark.parametrize(
    ("path", "title"),
    [
        ("body.inertia[1]", "body.inertia[1], kg m²"),
        ("effects.gravity.acceleration[2]", "effects.gravity.acceleration[2], m/s²"),
        ("effects.torque.body[0]", "effects.torque.body[0], N m"),
        ("body.mass", "body.mass, kg"),
        ("start.quaternion_wxyz[0]", "start.quaternion_wxyz[0]"),
    ],
)
def test_units_are_those_of_the_scene_file(path: str, title: str) -> None:
    axis = parse_axis(f"{path}=1:2")
    assert axis_title(axis) == title
    assert with_unit(axis, 40.0).split(" ", 1) == ["40", *title.split(", ")[1:]]


def bound_line(result: SweepResult, pair: tuple[str, str], label: str) -> np.ndarray:
    """Points of a line, (n, 2), in the axes' own units."""
    points = {b.label: points for b, _, points in drawn_bounds(grid(result), pair)}[label]
    return np.asarray(10**points)


def test_runge_kutta_s_limit_is_where_the_disc_s_rate_times_the_timestep_is() -> None:
    """(I3 − I1)/I1 = ½: ½ ω3 dt = 2√2, but for the nudge of 0.1 rad/s, next to nothing."""
    spin, timestep = bound_line(map_result(), RK4, "2√2").T
    np.testing.assert_allclose(spin * timestep, 2 * RK4_LIMIT, rtol=0.02)
    assert not np.allclose(spin * timestep, RK4_LIMIT, rtol=0.5)


def test_the_clamp_is_where_the_adapter_says_and_stands_in_for_the_turn_of_one() -> None:
    spin, timestep = bound_line(map_result(), MULTIBODY, "π/4").T
    np.testing.assert_allclose(np.hypot(spin, 0.1) * timestep, math.pi / 4, rtol=0.01)
    labels = {pair: {bound.label for bound in bounds_of(METHODS[pair])} for pair in METHODS}
    assert labels[EULER] & {"1 rad", "π/4"} == {"1 rad"}
    assert "1 rad" not in labels[MULTIBODY]


def test_the_engine_s_stock_timestep_is_a_level_line_and_stands_in_the_legend() -> None:
    _, timestep = bound_line(map_result(), RK4, "stock 2 ms").T
    np.testing.assert_allclose(timestep, STOCK, rtol=64 * float(np.finfo(float).eps))
    assert "stock 2 ms" in {bound.label for bound in legend_of_bounds(grid())}
    assert not {b.label for b, *_ in drawn_bounds(grid(), MULTIBODY)} & {"stock 2 ms"}


def test_an_upright_top_s_map_is_divided_where_it_falls_asleep() -> None:
    """ω3 = √80, at every timestep; between nodes by the interpolated logarithm, which is linear."""
    spin, timestep = bound_line(map_result(UPRIGHT, "upright"), EULER, "sleeps").T
    np.testing.assert_allclose(spin, math.sqrt(80), rtol=64 * float(np.finfo(float).eps))
    assert (timestep.min(), timestep.max()) == pytest.approx((1e-3, 1.0))


def test_a_disc_does_not_sleep_and_a_method_nobody_declared_has_lines_of_the_scene_alone() -> None:
    assert "sleeps" not in {bound.label for bound, *_ in drawn_bounds(grid(), EULER)}
    labels = {bound.label for bound in bounds_of(None)}
    assert labels & {"2√2", "separatrix"} == {"separatrix"}


def test_each_line_has_its_word_on_it_apart_from_the_others(figure: Figure) -> None:
    words = [n for n in figure["layout"]["annotations"] if n.get("xref") == "x2"]
    drawn = drawn_bounds(grid(), RK4)
    assert [word["text"] for word in words] == [bound.label for bound, *_ in drawn]
    for word, (_, _, points) in zip(words, drawn, strict=True):
        assert [word["x"], word["y"]] in points.tolist()
    assert len({word["x"] for word in words}) == len(words)


def test_a_run_that_the_reference_does_not_follow_to_the_end_is_signed() -> None:
    whole = map_result()
    cut = tuple(replace(p, steps=p.steps // 2) for p in whole.points)
    shortened = replace(whole, points=cut)
    assert all(grid(shortened).is_cut(point) == is_coloured(point) for point in cut)
    label, traces = escape(HORIZON.label), map_figure(grid(shortened))["data"]
    assert label not in [t.get("name") for t in map_figure(grid(whole))["data"]]
    assert label in [t.get("name") for t in traces]
    signed = [
        t for t in traces if t.get("marker", {}).get("symbol") == HORIZON.symbol and "text" in t
    ]
    # The colour stays visible around them.
    assert {t["marker"]["size"] for t in signed} == {map_figure_module.SMALLEST_SIGN}
    assert sum(len(t["text"]) for t in signed) == sum(map(is_coloured, cut))


def test_a_place_without_a_scene_is_signed_in_every_panel() -> None:
    whole = map_result()
    first = whole.points[0]
    ended = {"outcome": "unsupported", "cause": "scene", "reason": "no", "errors": None}
    ended["timestep"] = 0.0
    points = tuple(
        replace(p, **ended) if p.variation == first.variation else p for p in whole.points
    )
    drawn = grid(replace(whole, points=points))
    assert all(drawn.points[pair][0, 0].cause == "scene" for pair in METHODS)
    assert marks(drawn.result.points)["unsupported", "scene"].label == "no scene"
    # Without lines there, as it has no timestep; a map that is not complete is drawn too.
    go.Figure(coloured(map_figure(drawn)))
    go.Figure(coloured(map_figure(grid(replace(whole, points=whole.points[:5])))))


def with_errors_of(omega: float) -> Figure:
    whole = map_result()
    points = (
        replace(p, errors=replace(p.errors, omega=omega)) if p.errors else p for p in whole.points
    )
    return map_figure(grid(replace(whole, points=tuple(points))))


@pytest.mark.parametrize(("omega", "cmin", "least_ticks"), [(2.0, -1, 2), (1e-300, -11, 6)])
def test_the_colour_scale_has_a_width_and_few_ticks(omega, cmin, least_ticks) -> None:
    """However large the errors are; those below the uncertainty count as that."""
    axis = with_errors_of(omega)["layout"]["coloraxis"]
    assert (axis["cmin"], axis["cmax"]) == (cmin, 0)
    assert axis["colorbar"]["ticktext"][0] == "≥ 1"
    assert len(axis["colorbar"]["tickvals"]) == least_ticks


def test_an_error_that_is_infinite_has_no_colour() -> None:
    assert np.isnan(heatmap(with_errors_of(math.inf), 2)).all()


def test_lines_are_found_between_uneven_nodes_and_not_where_they_are_undefined() -> None:
    x, y = np.array([0.0, 7.0]), np.array([0.0, 1.0, 3.0])
    values = np.array([[-2.0, -1.0], [-1.0, math.nan], [1.0, 1.0]])
    assert map_figure_module._crossings(x, y, values).tolist() == [[0.0, 2.0]]


def test_runge_kutta_s_limit_is_of_swings_too_and_only_fractions_of_pi_are_called_so() -> None:
    (limit,) = (bound for bound in bounds_of(METHODS[RK4]) if bound.label == "2√2")
    swings = SimpleNamespace(gyration=0.0, swinging=4.0)
    assert limit.value(swings, RK4_LIMIT / 4) == pytest.approx(0.0, abs=SINGLE)
    assert [clamp(most).label for most in (math.pi / 4, 1.0)] == ["π/4", "1 rad"]


def test_cells_are_around_values_and_fit_into_panels() -> None:
    assert map_axes.edges(parse_axis("body.mass=1:3:3")).tolist() == [0.5, 1.5, 2.5, 3.5]
    assert map_axes.cell_side((100, 2), 1) == map_axes.PANEL_HEIGHT / 100
    assert map_axes.cell_side((2, 100), 4) < map_axes.PANEL_HEIGHT / 2
    legends = [map_axes.panels(grid(), n)["margin"]["b"] for n in (4, 5)]
    assert np.diff(legends) == map_axes.LEGEND_LINE


@pytest.mark.parametrize(
    ("axis", "ticks"), [("0.01:1", ["0.01", "0.1", "1"]), ("0.1:1", ["0.1", "0.2", "0.5", "1"])]
)
def test_ticks_are_decades_or_more_where_these_are_few(axis: str, ticks: list[str]) -> None:
    shared = map_axes.shared(parse_axis(f"body.mass={axis}:5:log"), outer=True)
    assert shared["ticktext"] == ticks


def test_linear_axes_are_drawn_in_their_own_units() -> None:
    assert places(parse_axis("body.mass=1:3:3")).tolist() == [1.0, 2.0, 3.0]
    assert places(parse_axis("body.mass=1:100:3:log")).tolist() == pytest.approx([0.0, 1.0, 2.0])


def test_a_large_map_tells_less_of_each_point(monkeypatch: pytest.MonkeyPatch) -> None:
    """Or its page would weigh many megabytes."""
    whole = len(json.dumps(map_figure(grid())))
    monkeypatch.setattr(map_figure_module, "MOST_HOVER_TEXTS", 9 * 7 - 1)
    assert len(json.dumps(map_figure(grid()))) < 0.8 * whole
