"""What errors cost over scenes whose costs are known."""

import math
from collections.abc import Sequence

import pytest
from laws import COARSEST, COARSEST_ERROR, ROUNDING, curve_of_law, law
from made_up import METHODS, results
from spincheck.reports.pages.analysis.cost_to_reach import LEVELS, Tallies, tallies
from spincheck.reports.pages.analysis.report_data import report_data
from spincheck.reports.pages.analysis.work_precision import Curve
from spincheck.reports.pages.cost_section import median_table


def curve(method: str, seconds: float = 1e-6, **facts: object) -> Curve:
    return curve_of_law(law(1), seconds, engine="e", method=method, **facts)


#: Method a costs 1, 3 and ∞ times the cheapest, method b 2, 1 and 1.
THREE_SCENES = [
    [curve("a", 1e-6), curve("b", 2e-6)],
    [curve("a", 3e-6), curve("b", 1e-6)],
    [curve("a", 3e-6, verdict="disagrees"), curve("b", 1e-6)],
]
A = ("e", "a")
BELOW, ABOVE = COARSEST_ERROR / 1000, COARSEST_ERROR / 7


def costs(*scenes: Sequence[Curve]) -> Tallies:
    return tallies(scenes, (ABOVE, BELOW))


def test_a_tally_tells_what_is_extrapolated_and_a_median_counts_what_is_out_of_reach() -> None:
    """And leaves out what a method cannot simulate."""
    found, steps = costs(*THREE_SCENES), COARSEST / 1000
    assert found[*A, BELOW] == (2, 2, pytest.approx(3e-6 / steps, rel=ROUNDING))
    assert found[*A, ABOVE][:2] == (3, 0)
    assert costs(*THREE_SCENES[1:])[*A, BELOW][2] == math.inf
    cannot = [curve("a", verdict="unsupported", points=(), stable=())]
    (*_, middle) = costs(THREE_SCENES[0], cannot, cannot)[*A, BELOW]
    assert middle == pytest.approx(1e-6 / steps, rel=ROUNDING)


def test_the_table_has_a_row_a_method_and_a_column_a_level() -> None:
    table = median_table(report_data(results()))
    assert len(table.rows) == len(METHODS)
    assert all(len(row) == len(table.headings) == 2 + len(LEVELS) for row in table.rows)
