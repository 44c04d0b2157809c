"""What each method needs for several bounds: cautious where curves bend, in whole steps."""

import math
from dataclasses import replace

import pytest
from ladders import (
    BELOW,
    BETWEEN,
    INTERVAL,
    ROUNDING,
    TOP,
    Law,
    bending_down,
    bending_up,
    chosen,
    only_top,
    scene_of,
    straight,
    with_law,
)
from made_up import METHODS, TIMESTEPS, results
from spincheck.reports.pages.analysis.candidates import Candidate, as_cheap, candidates
from spincheck.reports.pages.analysis.cost_to_reach import reach
from spincheck.reports.pages.analysis.work_precision import curve_of
from spincheck.reports.results.records import Key
from spincheck.reports.results.store import Results


def test_an_engine_as_shipped_is_no_candidate() -> None:
    found = with_law(straight)
    pair = ("mujoco", "Euler")
    assert pair in labels_of(found)
    shipped = {pair: replace(found.methods[pair], as_shipped=True)}
    assert pair not in labels_of(replace(found, methods=found.methods | shipped))


def labels_of(found: Results) -> list[tuple[str, str]]:
    return [(c.key.engine, c.key.method) for c in candidates(scene_of(found), {"omega": BETWEEN})]


LAWS = [straight, bending_up, bending_down]


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("bound", [2.3e-2, 7e-3, BELOW], ids=["between", "lower", "below"])
def test_a_curve_that_bends_does_not_break_the_bound(law: Law, bound: float) -> None:
    best = chosen(with_law(law), "Euler", omega=bound)
    assert law(best.timestep) <= bound * (1 + ROUNDING)


def test_plain_interpolation_would_break_it() -> None:
    scene = scene_of(with_law(bending_down))
    euler = next(runs for runs in scene.methods if runs.method == "Euler")
    plain = reach(curve_of(scene, euler, "omega"), 2.3e-2)
    assert bending_down(plain.timestep) > 2.3e-2 * (1 + ROUNDING)


@pytest.mark.parametrize("bound", [2e-2, 7e-3, BELOW])
def test_the_interval_between_samples_is_a_whole_number_of_steps(bound: float) -> None:
    steps = INTERVAL / chosen(with_law(straight), "Euler", omega=bound).timestep
    assert steps == pytest.approx(round(steps), rel=ROUNDING)


def test_a_rung_that_fits_is_not_cut() -> None:
    """Rounding down must not take a step off a quotient that is whole but for its last bits."""
    found = with_law(straight)
    assert chosen(found, "Euler", omega=1.0).timestep == pytest.approx(TIMESTEPS[0], rel=ROUNDING)


def test_the_tightest_of_several_bounds_decides() -> None:
    found = with_law(straight)
    both = chosen(found, "Euler", omega=1e-2, energy=1e-3)
    assert both == replace(chosen(found, "Euler", energy=1e-3), decided_by="energy")
    assert both.timestep < chosen(found, "Euler", omega=1e-2).timestep


def test_the_cheapest_comes_first_and_what_is_out_of_reach_last() -> None:
    found = candidates(scene_of(only_top(results())), {"omega": BETWEEN})
    costs = [candidate.cost or math.inf for candidate in found]
    assert costs == sorted(costs)
    assert found[0].key.method == "RK4"
    assert {candidate.word for candidate in found} > {"diverges", "failed", "unsupported"}
    assert len(found) == len(METHODS)


def test_the_largest_stable_timestep_is_below_the_last_blow_up() -> None:
    found = with_law(straight)
    rows = [
        replace(row, outcome="diverged", errors=None)
        if row.key.method == "Euler" and row.timestep == TIMESTEPS[1]
        else row
        for row in found.rows
    ]
    assert chosen(found, "Euler", omega=BETWEEN).largest_stable == TIMESTEPS[0]
    after = chosen(replace(found, rows=rows), "Euler", omega=BETWEEN)
    assert after.largest_stable == TIMESTEPS[2]


def test_costs_within_the_spread_of_the_timings_are_called_alike() -> None:
    key = Key(TOP, "e", "m")
    best = Candidate(key, "measured", "", "omega", None, 1e-3, cost=1.0, spread=0.1)
    near, far = replace(best, cost=1.05), replace(best, cost=1.2)
    lost = replace(best, timestep=None, cost=None)
    assert as_cheap([best, near, far, lost]) == [near]
    assert as_cheap([lost, lost]) == []
