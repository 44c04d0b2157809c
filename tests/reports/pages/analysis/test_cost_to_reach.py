"""The cost of an error: on laws whose answers are known, and where it cannot be reached."""

import math
from dataclasses import replace

import pytest
from laws import COARSEST, COARSEST_ERROR, ROUNDING, curve_of_errors, curve_of_law, law
from spincheck.reports.pages.analysis.cost_to_reach import LEVELS, reach
from spincheck.reports.pages.analysis.work_precision import EPS, Curve


@pytest.mark.parametrize("order", [1, 4])
def test_between_two_runs_the_cost_is_that_of_the_law(order: int) -> None:
    level = COARSEST_ERROR / 7.0
    timestep = COARSEST * (1 / 7.0) ** (1 / order)
    reached = reach(curve_of_law(law(order)), level)
    assert reached.word == "measured"
    assert reached.timestep == pytest.approx(timestep, rel=ROUNDING)
    assert reached.cost == pytest.approx(1e-6 / timestep, rel=ROUNDING)
    # Interpolating without logarithms would be noticed.
    coarse, fine = COARSEST / 2 ** (1 / order), COARSEST / 4 ** (1 / order)
    linear = fine + (coarse - fine) * (1 / 7.0 - 1 / 4) / (1 / 2 - 1 / 4)
    assert order == 1 or reached.timestep != pytest.approx(linear, rel=ROUNDING)


def test_the_error_of_a_run_takes_that_run_s_timestep_and_at_most_the_coarsest() -> None:
    curve = curve_of_law(law(1))
    for point in curve.points[1:]:
        reached = reach(curve, point.error)
        assert reached.timestep == pytest.approx(point.timestep, rel=ROUNDING)
    reached = reach(curve, 2 * COARSEST_ERROR)
    assert (reached.word, reached.timestep) == ("at most", COARSEST)


@pytest.mark.parametrize("order", [1, 2])
def test_below_the_finest_run_the_order_carries_on(order: int) -> None:
    reached = reach(curve_of_law(law(order)), COARSEST_ERROR / 1000**order)
    assert reached.word == "extrapolated"
    assert reached.timestep == pytest.approx(COARSEST / 1000, rel=ROUNDING)


def test_what_is_extrapolated_states_its_floor() -> None:
    curve = curve_of_law(law(1), rounding=1e-13)
    reached = reach(curve, COARSEST_ERROR / 1000)
    assert reached.floor == pytest.approx(curve.uncertainty + 1e-13 / (COARSEST / 1000))
    assert reached.floor < reached.level
    assert f"{reached.floor:.1e}" in reached.reason


def test_rounding_ends_extrapolation_and_errors_at_round_off_are_said_to_be() -> None:
    level = COARSEST_ERROR / 1000
    rounding = level * COARSEST / 1000
    assert reach(curve_of_law(law(1), rounding=rounding / 2), level).word == "extrapolated"
    reached = reach(curve_of_law(law(1), rounding=rounding), level)
    assert (reached.word, reached.cost) == ("round-off", None)
    assert reached.floor >= level
    reached = reach(curve_of_errors(3e-14, 5e-14, 9e-14, rounding=1e-13), 1e-14)
    assert (reached.word, reached.cost) == ("round-off", None)
    assert reached.floor == EPS + 1e-13 * (1 / COARSEST)  # of one second


def test_only_what_converges_is_extrapolated_but_what_is_measured_always_counts() -> None:
    level = COARSEST_ERROR / 1000
    for word in ("disagrees", "unresolved", "diverges", "failed", "unsupported"):
        curve = curve_of_law(law(1), verdict=word, reason="because")
        assert (reach(curve, level).word, reach(curve, level).reason) == (word, "because")
        assert reach(curve, COARSEST_ERROR / 7).word == "measured"
    assert reach(curve_of_law(law(1)), level).word == "extrapolated"


NO_RUNS = curve_of_law(law(1), points=(), stable=(), verdict="unsupported")
FAR_REFERENCE = curve_of_law(law(1), uncertainty=COARSEST_ERROR / 6)


@pytest.mark.parametrize(
    ("curve", "level", "word"),
    [
        (NO_RUNS, LEVELS[0], "unsupported"),
        (NO_RUNS, NO_RUNS.uncertainty / 2, "unsupported"),
        # Of a study stopped early.
        (replace(NO_RUNS, verdict=None), LEVELS[0], "no verdict"),
        (curve_of_law(law(1), seconds=None), COARSEST_ERROR / 7, "not timed"),
        (FAR_REFERENCE, COARSEST_ERROR / 7, "reference limit"),
        # Relative to nothing.
        (curve_of_errors(math.inf, math.inf, math.inf), 1e-3, "undefined"),
        (curve_of_errors(1e-2, 1e-2, 1e-2, 1e-2), 1e-3, "no order"),
    ],
)
def test_where_an_error_has_no_cost_a_word_says_why(curve: Curve, level: float, word: str) -> None:
    reached = reach(curve, level)
    assert (reached.word, reached.cost) == (word, None)
    assert reach(FAR_REFERENCE, COARSEST_ERROR / 5).word == "measured"


def test_an_accident_at_a_coarse_timestep_is_no_reach_and_rounding_takes_nothing_from_it() -> None:
    accident = curve_of_errors(5e-2, 1e-9, 2e-2, 1e-2, 5e-3)
    reached = reach(accident, 7e-3)
    assert COARSEST / 2**4 < reached.timestep < COARSEST / 2**3
    rising = curve_of_errors(1e-6, 1e-9, 1e-13, 3e-13, 6e-13, rounding=1e-15)
    assert COARSEST / 2**2 <= reach(rising, 2e-13).timestep < COARSEST / 2
    # Growth over several timesteps shows rounding, however large.
    assert reach(replace(rising, rounding=0.0), 2e-13) == reach(rising, 2e-13)
