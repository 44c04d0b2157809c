"""Errors against cost, the cost of a level, and profiles: on laws whose answers are known."""

import base64
import math
import re
from collections.abc import Callable
from dataclasses import replace
from importlib import import_module
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from made_up import METHODS, SECONDS_PER_STEP, TIMESTEPS, UNCERTAINTY, results
from spincheck.reports.cost_tables import median_table, ratio_table, reach_table, reached_table
from spincheck.reports.cost_to_reach import LEVELS, cheapest, order_ratio, reach
from spincheck.reports.gather import SceneRuns, gather
from spincheck.reports.looks import looks
from spincheck.reports.profile_figure import profile_figure
from spincheck.reports.profiles import order_ratios, profile, tally
from spincheck.reports.verdict import ASYMPTOTIC
from spincheck.reports.work_precision import (
    EPS,
    SIGNALS,
    Curve,
    Point,
    cost,
    curves,
    front,
    observed_order,
)

#: A power and a quotient of logarithms, each good to a few ulp of numbers up to some tens.
ROUNDING = 64 * EPS
#: s
COARSEST = 0.01
RUNGS = 6
#: Asymptotic, as errors go.
COARSEST_ERROR = 0.05


def law(order: float, error: float = COARSEST_ERROR) -> Callable[[float], float]:
    """Error of a timestep: `error` at the coarsest, a power below."""
    return lambda timestep: error * (timestep / COARSEST) ** order


def curve_of_law(
    error: Callable[[float], float], seconds: float | None = 1e-6, **known: object
) -> Curve:
    """A converging method with that error on every rung."""
    timesteps = [COARSEST / 2**k for k in range(RUNGS)]
    points = tuple(Point(dt, seconds and seconds / dt, error(dt)) for dt in timesteps)
    curve = Curve(
        engine="made-up",
        method="law",
        signal="omega",
        points=points,
        stable=points,
        seconds_per_step=seconds,
        uncertainty=EPS,
        rounding=0.0,
        declared=1,
        verdict="converges",
        reason="order as declared",
        order=None,
    )
    return replace(curve, **known)


def curve_of_errors(*errors: float, **known: object) -> Curve:
    """The same with its errors listed, coarse to fine."""
    found = {COARSEST / 2**k: error for k, error in enumerate(errors)}
    points = tuple(Point(dt, 1e-6 / dt, error) for dt, error in found.items())
    return curve_of_law(law(1), points=points, stable=points, **known)


@pytest.fixture(scope="module")
def top() -> SceneRuns:
    return {scene.name: scene for scene in gather(results()).scenes}["made-up-top"]


def test_cost_is_seconds_a_simulated_second(top: SceneRuns) -> None:
    euler = next(curve for curve in curves(top, "omega") if curve.label == "mujoco Euler")
    assert [point.cost for point in euler.points] == [SECONDS_PER_STEP / dt for dt in TIMESTEPS]


def test_every_run_that_ended_well_is_a_point_and_no_other_is(top: SceneRuns) -> None:
    found = {curve.label: len(curve.points) for curve in curves(top, "energy")}
    finished = {"converges", "disagrees", "unresolved"}
    wanted = {
        f"{m.engine} {m.method}": len(TIMESTEPS) if m.verdict in finished else 0 for m in METHODS
    }
    assert found == wanted


@pytest.mark.parametrize("signal", SIGNALS)
def test_no_error_is_below_what_the_reference_is_good_for(top: SceneRuns, signal: str) -> None:
    limit = getattr(UNCERTAINTY, signal)
    assert all(p.error >= limit for curve in curves(top, signal) for p in curve.points)


def test_some_runs_would_claim_less_than_the_reference_is_good_for(top: SceneRuns) -> None:
    tight = replace(UNCERTAINTY, attitude=1e-6)
    found = replace(top.found, solution=replace(top.found.solution, uncertainty=tight))
    raised = curves(replace(top, found=found), "attitude")
    assert min(p.error for curve in raised for p in curve.points) == tight.attitude
    assert min(p.error for curve in curves(top, "attitude") for p in curve.points) < tight.attitude


def test_a_scene_without_a_truth_has_no_curves() -> None:
    unsolved = next(scene for scene in gather(results()).scenes if scene.found is None)
    assert curves(unsolved, "omega") == []


def test_stable_runs_are_those_below_the_last_that_did_not_end_well(top: SceneRuns) -> None:
    runs = next(runs for runs in top.methods if runs.label == "mujoco Euler")
    rows = tuple(
        replace(row, outcome="diverged") if k == 2 else row for k, row in enumerate(runs.rows)
    )
    (curve,) = curves(replace(top, methods=(replace(runs, rows=rows),)), "omega")
    assert [point.timestep for point in curve.stable] == list(TIMESTEPS[3:])
    assert [point.timestep for point in curve.points] == [*TIMESTEPS[:2], *TIMESTEPS[3:]]


@pytest.mark.parametrize("order", [1, 2, 4])
def test_the_order_of_a_law_is_found(order: int) -> None:
    assert observed_order(curve_of_law(law(order))) == pytest.approx(order, rel=ROUNDING)


def test_the_order_of_growing_errors_is_negative() -> None:
    assert observed_order(curve_of_law(law(-1, 1e-3))) == pytest.approx(-1, rel=ROUNDING)


def test_an_order_is_not_read_off_saturated_errors() -> None:
    """Too few of them are asymptotic: the order is the verdict's."""
    saturated = curve_of_law(law(1, ASYMPTOTIC * 2 ** (RUNGS - 1)), order=1.5)
    assert observed_order(saturated) == 1.5


@pytest.mark.parametrize("order", [1, 4])
def test_between_two_runs_the_cost_is_that_of_the_law(order: int) -> None:
    level = COARSEST_ERROR / 7.0
    timestep = COARSEST * (1 / 7.0) ** (1 / order)
    found = reach(curve_of_law(law(order)), level)
    assert found.word == "measured"
    assert found.timestep == pytest.approx(timestep, rel=ROUNDING)
    assert found.cost == pytest.approx(1e-6 / timestep, rel=ROUNDING)


def test_interpolating_without_logarithms_would_be_noticed() -> None:
    level = COARSEST_ERROR / 7.0
    coarse, fine = COARSEST / 2 ** (1 / 4), COARSEST / 4 ** (1 / 4)
    linear = fine + (coarse - fine) * (1 / 7.0 - 1 / 4) / (1 / 2 - 1 / 4)
    found = reach(curve_of_law(law(4)), level)
    assert found.timestep != pytest.approx(linear, rel=ROUNDING)


@pytest.mark.parametrize("k", range(1, RUNGS))
def test_the_error_of_a_run_takes_that_run_s_timestep(k: int) -> None:
    curve = curve_of_law(law(1))
    found = reach(curve, curve.points[k].error)
    assert found.timestep == pytest.approx(curve.points[k].timestep, rel=ROUNDING)


def test_what_the_coarsest_run_reaches_costs_that_at_most() -> None:
    found = reach(curve_of_law(law(1)), 2 * COARSEST_ERROR)
    assert (found.word, found.timestep) == ("at most", COARSEST)


@pytest.mark.parametrize("order", [1, 2])
def test_below_the_finest_run_the_order_carries_on(order: int) -> None:
    found = reach(curve_of_law(law(order)), COARSEST_ERROR / 1000**order)
    assert found.word == "extrapolated"
    assert found.timestep == pytest.approx(COARSEST / 1000, rel=ROUNDING)


def test_what_is_extrapolated_states_its_floor() -> None:
    curve = curve_of_law(law(1), rounding=1e-13)
    found = reach(curve, COARSEST_ERROR / 1000)
    assert found.floor == pytest.approx(curve.uncertainty + 1e-13 / (COARSEST / 1000))
    assert found.floor < found.level
    assert f"{found.floor:.1e}" in found.reason


def test_rounding_ends_extrapolation() -> None:
    level = COARSEST_ERROR / 1000
    rounding = level * COARSEST / 1000
    assert reach(curve_of_law(law(1), rounding=rounding / 2), level).word == "extrapolated"
    found = reach(curve_of_law(law(1), rounding=rounding), level)
    assert (found.word, found.cost) == ("round-off", None)
    assert found.floor >= level


def test_errors_at_round_off_are_said_to_be() -> None:
    found = reach(curve_of_errors(3e-14, 5e-14, 9e-14, rounding=1e-13), 1e-14)
    assert (found.word, found.cost) == ("round-off", None)
    assert found.floor == EPS + 1e-13 / COARSEST


@pytest.mark.parametrize("word", ["disagrees", "unresolved", "diverges", "failed", "unsupported"])
def test_only_what_converges_is_extrapolated(word: str) -> None:
    level = COARSEST_ERROR / 1000
    curve = curve_of_law(law(1), verdict=word, reason="because")
    assert (reach(curve, level).word, reach(curve, level).reason) == (word, "because")
    assert reach(curve_of_law(law(1)), level).word == "extrapolated"


def test_what_is_measured_counts_whatever_the_verdict() -> None:
    found = reach(curve_of_law(law(1), verdict="disagrees"), COARSEST_ERROR / 7)
    assert found.word == "measured"


def test_a_method_without_runs_has_its_verdict_s_word() -> None:
    curve = curve_of_law(law(1), points=(), stable=(), verdict="unsupported")
    assert reach(curve, LEVELS[0]).word == "unsupported"
    assert reach(curve, curve.uncertainty / 2).word == "unsupported"


def test_a_study_stopped_early_has_no_verdict() -> None:
    curve = curve_of_law(law(1), points=(), stable=(), verdict=None)
    assert reach(curve, LEVELS[0]).word == "no verdict"


def test_what_was_not_timed_is_said_to_be() -> None:
    found = reach(curve_of_law(law(1), seconds=None), COARSEST_ERROR / 7)
    assert (found.word, found.cost) == ("not timed", None)


def test_nothing_is_reached_below_the_reference() -> None:
    curve = curve_of_law(law(1), uncertainty=COARSEST_ERROR / 6)
    assert reach(curve, COARSEST_ERROR / 7).word == "reference limit"
    assert reach(curve, COARSEST_ERROR / 5).word == "measured"


def test_an_error_relative_to_nothing_is_undefined() -> None:
    found = reach(curve_of_errors(math.inf, math.inf, math.inf), 1e-3)
    assert (found.word, found.cost) == ("undefined", None)


def test_errors_that_do_not_shrink_show_no_order() -> None:
    found = reach(curve_of_errors(1e-2, 1e-2, 1e-2, 1e-2), 1e-3)
    assert (found.word, found.cost) == ("no order", None)


def test_an_accident_at_a_coarse_timestep_is_no_reach() -> None:
    accident = curve_of_errors(5e-2, 1e-9, 2e-2, 1e-2, 5e-3)
    found = reach(accident, 7e-3)
    assert COARSEST / 2**4 < found.timestep < COARSEST / 2**3


def test_rounding_at_fine_timesteps_takes_nothing_from_coarse_ones() -> None:
    rising = curve_of_errors(1e-6, 1e-9, 1e-13, 3e-13, 6e-13, rounding=1e-15)
    assert COARSEST / 2**2 <= reach(rising, 2e-13).timestep < COARSEST / 2
    unexplained = replace(rising, rounding=0.0)
    assert reach(unexplained, 2e-13).cost is None


def test_the_cheapest_is_the_one_that_costs_least() -> None:
    first, fourth = curve_of_law(law(1)), curve_of_law(law(4), seconds=4e-6, method="RK4")
    assert cheapest([first, fourth], COARSEST_ERROR)[0] is first
    assert cheapest([first, fourth], COARSEST_ERROR / 100)[0] is fourth
    assert cheapest([curve_of_law(law(1), verdict="disagrees")], 1e-6) is None


def test_the_ratio_of_two_orders_is_that_of_their_laws() -> None:
    cheap, dear = curve_of_law(law(1)), curve_of_law(law(1), seconds=2e-6)
    fourth = curve_of_law(law(4), seconds=4e-6, declared=4)
    n = 1000.0
    wanted = n / (4 * n**0.25)
    found = order_ratio([dear, fourth, cheap], COARSEST_ERROR / n)
    assert found == pytest.approx(wanted, rel=ROUNDING)
    assert order_ratio([cheap, dear], COARSEST_ERROR / n) is None


def test_every_point_of_the_front_is_better_than_all_cheaper_ones(top: SceneRuns) -> None:
    best = [point for _, point in front(curves(top, "omega"))]
    assert len(best) > 2
    assert all(a.cost < b.cost and a.error > b.error for a, b in pairwise(best))


def test_every_other_point_is_beaten_by_one_of_the_front(top: SceneRuns) -> None:
    tried = curves(top, "omega")
    best = [point for _, point in front(tried)]
    others = [p for curve in tried for p in curve.points if p not in best]
    assert others
    for point in others:
        assert any(b.cost <= point.cost and b.error <= point.error for b in best)


def test_untimed_runs_are_not_on_the_front() -> None:
    assert front([curve_of_law(law(1), seconds=None)]) == []


def three_scenes() -> list[list[Curve]]:
    """Method a costs 1, 3 and ∞ times the cheapest, method b 2, 1 and 1."""
    a, b = {"engine": "e", "method": "a"}, {"engine": "e", "method": "b"}
    far = {"verdict": "disagrees"}
    return [
        [curve_of_law(law(1), 1e-6, **a), curve_of_law(law(1), 2e-6, **b)],
        [curve_of_law(law(1), 3e-6, **a), curve_of_law(law(1), 1e-6, **b)],
        [curve_of_law(law(1), 3e-6, **a, **far), curve_of_law(law(1), 1e-6, **b)],
    ]


BELOW = COARSEST_ERROR / 1000


@pytest.mark.parametrize(
    ("method", "factor", "scenes"),
    [("a", 1, 1), ("a", 2.9, 1), ("a", 3.1, 2), ("a", math.inf, 2), ("b", 1, 2), ("b", 2.1, 3)],
)
def test_a_profile_counts_the_scenes_within_a_factor(
    method: str, factor: float, scenes: int
) -> None:
    found = profile(three_scenes(), "omega", BELOW)
    assert found.fraction(("e", method), factor) == scenes / 3


def test_a_scene_that_nobody_reaches_still_counts() -> None:
    lost = [curve_of_law(law(1), engine="e", method=m, verdict="unresolved") for m in "ab"]
    found = profile([*three_scenes(), lost], "omega", BELOW)
    assert found.fraction(("e", "b"), math.inf) == 3 / 4


def test_a_tally_tells_what_is_extrapolated() -> None:
    found = tally(three_scenes(), ("e", "a"), BELOW)
    assert (found.reached, found.extrapolated) == (2, 2)
    measured = tally(three_scenes(), ("e", "a"), COARSEST_ERROR / 7)
    assert (measured.reached, measured.extrapolated) == (3, 0)


def test_a_median_counts_what_is_out_of_reach_as_infinite() -> None:
    found = tally(three_scenes(), ("e", "a"), BELOW)
    assert found.median_cost == pytest.approx(3e-6 / (COARSEST / 1000), rel=ROUNDING)
    assert tally(three_scenes()[1:], ("e", "a"), BELOW).median_cost == math.inf


def test_a_median_leaves_out_what_a_method_cannot_simulate() -> None:
    cannot = [
        curve_of_law(law(1), engine="e", method="a", verdict="unsupported", points=(), stable=())
    ]
    found = tally([*three_scenes()[:1], cannot, cannot], ("e", "a"), BELOW)
    assert found.median_cost == pytest.approx(1e-6 / (COARSEST / 1000), rel=ROUNDING)


def test_ratios_of_orders_are_over_the_scenes_where_both_reach() -> None:
    fourth = {"method": "c", "declared": 4}
    scenes = [[*scene, curve_of_law(law(4), 4e-6, **fourth)] for scene in three_scenes()[:2]]
    found = order_ratios([*scenes, three_scenes()[2]], BELOW)
    assert found.scenes == 2
    assert found.median == pytest.approx(1000 / (4 * 1000**0.25), rel=ROUNDING)


def test_a_profile_s_curve_ends_at_the_scenes_reached() -> None:
    drawn = looks([("e", "a"), ("e", "b")])
    figure = profile_figure([profile(three_scenes(), "omega", BELOW)], drawn)
    ends = {trace["name"]: _last(trace["y"]) for trace in figure["data"]}
    assert ends == {"e a": np.float32(2 / 3), "e b": 1.0}


def test_tables_have_a_row_a_method_and_a_column_a_level(top: SceneRuns) -> None:
    gathered = gather(results())
    scenes = [curves(scene, "omega") for scene in gathered.scenes if scene.found]
    tables = (
        reach_table(top, "omega"),
        reached_table(gathered, scenes),
        median_table(gathered, scenes),
    )
    for table in tables:
        assert len(table.rows) == len(METHODS)
        assert all(len(row) == len(table.headings) for row in table.rows)
        assert len(table.headings) >= 2 + len(LEVELS)
    assert len(ratio_table(scenes).headings) == 1 + len(LEVELS)


def test_a_cost_that_is_not_measured_is_marked(top: SceneRuns) -> None:
    cells = [cell for row in reach_table(top, "omega").rows for cell in row]
    assert any(cell.text.startswith("≤ ") for cell in cells)
    extrapolated = [cell for cell in cells if cell.text.startswith("≈ ")]
    assert extrapolated
    assert all("floor" in cell.detail for cell in extrapolated)


def test_a_row_that_was_not_timed_has_no_cost() -> None:
    row = next(row for row in results().rows if row.outcome == "ok")
    assert cost(replace(row, seconds_per_step=None)) is None


DOCS = Path(__file__).parents[2] / "docs" / "cost.md"


@pytest.mark.parametrize(
    ("module", "constant"), re.findall(r"`reports/(\w+)\.py`: `([A-Z_]+)`", DOCS.read_text())
)
def test_every_constant_that_the_page_on_cost_names_exists(module: str, constant: str) -> None:
    assert hasattr(import_module(f"spincheck.reports.{module}"), constant)


def _last(spec: dict[str, str]) -> float:
    return np.frombuffer(base64.b64decode(spec["bdata"]), dtype="<f4")[-1]
