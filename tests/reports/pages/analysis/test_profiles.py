"""Performance profiles, tallies and tables over scenes whose costs are known."""

import math

import numpy as np
import pytest
from laws import COARSEST, COARSEST_ERROR, ROUNDING, curve_of_law, law
from made_up import METHODS, results
from plotted import values_of
from spincheck.reports.pages.analysis.cost_to_reach import LEVELS, order_ratios, profile, tally
from spincheck.reports.pages.analysis.report_data import SceneRuns, report_data
from spincheck.reports.pages.analysis.trace_style import trace_styles
from spincheck.reports.pages.analysis.work_precision import Curve, curves
from spincheck.reports.pages.cost_section import (
    median_table,
    ratio_table,
    reach_table,
    reached_table,
)
from spincheck.reports.pages.figures.profile_figure import profile_figures


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
    curve = profile(three_scenes(), "omega", BELOW)
    assert curve.fraction(("e", method), factor) == scenes / 3


def test_a_scene_that_nobody_reaches_still_counts() -> None:
    unresolved = [curve_of_law(law(1), engine="e", method=m, verdict="unresolved") for m in "ab"]
    curve = profile([*three_scenes(), unresolved], "omega", BELOW)
    assert curve.fraction(("e", "b"), math.inf) == 3 / 4


def test_a_tally_tells_what_is_extrapolated() -> None:
    counts = tally(three_scenes(), ("e", "a"), BELOW)
    assert (counts.reached, counts.extrapolated) == (2, 2)
    measured = tally(three_scenes(), ("e", "a"), COARSEST_ERROR / 7)
    assert (measured.reached, measured.extrapolated) == (3, 0)


def test_a_median_counts_what_is_out_of_reach_as_infinite() -> None:
    counts = tally(three_scenes(), ("e", "a"), BELOW)
    assert counts.median_cost == pytest.approx(3e-6 / (COARSEST / 1000), rel=ROUNDING)
    assert tally(three_scenes()[1:], ("e", "a"), BELOW).median_cost == math.inf


def test_a_median_leaves_out_what_a_method_cannot_simulate() -> None:
    cannot = [
        curve_of_law(law(1), engine="e", method="a", verdict="unsupported", points=(), stable=())
    ]
    counts = tally([*three_scenes()[:1], cannot, cannot], ("e", "a"), BELOW)
    assert counts.median_cost == pytest.approx(1e-6 / (COARSEST / 1000), rel=ROUNDING)


def test_ratios_of_orders_are_over_the_scenes_where_both_reach() -> None:
    fourth = {"method": "c", "declared": 4}
    scenes = [[*scene, curve_of_law(law(4), 4e-6, **fourth)] for scene in three_scenes()[:2]]
    ratios = order_ratios([*scenes, three_scenes()[2]], BELOW)
    assert ratios == pytest.approx([1000 / (4 * 1000**0.25)] * 2, rel=ROUNDING)


def test_a_profile_s_curve_ends_at_the_scenes_reached() -> None:
    drawn = trace_styles([("e", "a"), ("e", "b")])
    (figure,) = profile_figures([profile(three_scenes(), "omega", BELOW)], drawn)
    ends = {trace["name"]: values_of(trace["y"])[-1] for trace in figure["data"]}
    assert ends == {"e a": np.float32(2 / 3), "e b": 1.0}


def test_tables_have_a_row_a_method_and_a_column_a_level(top: SceneRuns) -> None:
    gathered = report_data(results())
    scenes = [curves(scene, "omega") for scene in gathered.scenes if scene.solved]
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
