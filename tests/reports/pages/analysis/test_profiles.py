"""Performance profiles, tallies and tables over scenes whose costs are known."""

import math
from collections.abc import Sequence

import numpy as np
import pytest
from laws import COARSEST, COARSEST_ERROR, ROUNDING, curve_of_law, law
from made_up import METHODS, results
from plotted import values_of
from spincheck.reports.pages.analysis.cost_to_reach import LEVELS, Costs
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


def curve(method: str, seconds: float = 1e-6, **facts: object) -> Curve:
    return curve_of_law(law(1), seconds, engine="e", method=method, **facts)


#: Method a costs 1, 3 and ∞ times the cheapest, method b 2, 1 and 1.
THREE_SCENES = [
    [curve("a", 1e-6), curve("b", 2e-6)],
    [curve("a", 3e-6), curve("b", 1e-6)],
    [curve("a", 3e-6, verdict="disagrees"), curve("b", 1e-6)],
]
A, B = ("e", "a"), ("e", "b")
BELOW, ABOVE = COARSEST_ERROR / 1000, COARSEST_ERROR / 7


def costs(*scenes: Sequence[Curve]) -> Costs:
    return Costs(scenes, "omega", (ABOVE, BELOW))


def test_a_profile_counts_the_scenes_within_a_factor() -> None:
    within = costs(*THREE_SCENES).profile(BELOW)
    of_a = [within.fraction(A, factor) for factor in (1, 2.9, 3.1, math.inf)]
    assert of_a == [1 / 3, 1 / 3, 2 / 3, 2 / 3]
    assert [within.fraction(B, factor) for factor in (1, 2.1)] == [2 / 3, 1]
    # A scene that nobody reaches still counts.
    unresolved = [curve(method, verdict="unresolved") for method in "ab"]
    assert costs(*THREE_SCENES, unresolved).profile(BELOW).fraction(B, math.inf) == 3 / 4


def test_a_tally_tells_what_is_extrapolated_and_a_median_counts_what_is_out_of_reach() -> None:
    """And leaves out what a method cannot simulate."""
    found, steps = costs(*THREE_SCENES).tallies(), COARSEST / 1000
    assert found[*A, BELOW] == (2, 2, pytest.approx(3e-6 / steps, rel=ROUNDING))
    assert found[*A, ABOVE][:2] == (3, 0)
    assert costs(*THREE_SCENES[1:]).tallies()[*A, BELOW][2] == math.inf
    cannot = [curve("a", verdict="unsupported", points=(), stable=())]
    (*_, middle) = costs(THREE_SCENES[0], cannot, cannot).tallies()[*A, BELOW]
    assert middle == pytest.approx(1e-6 / steps, rel=ROUNDING)


def test_ratios_of_orders_are_over_the_scenes_where_both_reach() -> None:
    fourth = curve_of_law(law(4), 4e-6, method="c", declared=4)
    scenes = [[*scene, fourth] for scene in THREE_SCENES[:2]]
    of_laws = 1000 / (4 * 1000**0.25)
    *_, (count, middle, largest) = costs(*scenes, THREE_SCENES[2]).order_ratios()
    assert (count, middle, largest) == (2, *[pytest.approx(of_laws, rel=ROUNDING)] * 2)
    # Without one of fourth order there is none.
    assert costs(*THREE_SCENES).order_ratios()[-1] == (0, None, None)


def test_a_profile_s_curve_ends_at_the_scenes_reached() -> None:
    within = costs(*THREE_SCENES).profile(BELOW)
    (figure,) = profile_figures([within], trace_styles([A, B]))
    ends = {trace["name"]: values_of(trace["y"])[-1] for trace in figure["data"]}
    assert ends == {"e a": np.float32(2 / 3), "e b": 1.0}


def test_tables_have_a_row_a_method_and_a_column_a_level(top: SceneRuns) -> None:
    gathered = report_data(results())
    scenes = [curves(scene, "omega") for scene in gathered.scenes if scene.solved]
    every = Costs(scenes, "omega")
    tables = (
        reach_table(top, "omega"),
        reached_table(gathered, every),
        median_table(gathered, every),
    )
    for table in tables:
        assert len(table.rows) == len(METHODS)
        assert all(len(row) == len(table.headings) for row in table.rows)
        assert len(table.headings) >= 2 + len(LEVELS)
    assert len(ratio_table(every).headings) == 1 + len(LEVELS)


def test_a_cost_that_is_not_measured_is_marked(top: SceneRuns) -> None:
    cells = [cell for row in reach_table(top, "omega").rows for cell in row]
    assert any(cell.text.startswith("≤ ") for cell in cells)
    extrapolated = [cell for cell in cells if cell.text.startswith("≈ ")]
    assert extrapolated
    assert all("floor" in cell.detail for cell in extrapolated)
