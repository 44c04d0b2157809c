"""What each method needs for several bounds; the tables of a report agree with it."""

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from ladders import (
    BELOW,
    BETWEEN,
    ROUNDING,
    TOP,
    Law,
    bending_down,
    bending_up,
    chosen,
    only,
    scene_of,
    straight,
    with_law,
)
from library_scenes import library
from made_up import METHODS, TIMESTEPS, results
from spincheck.reports.cli.run.short_summary import short_summary
from spincheck.reports.cli.run.summary import verdict_records
from spincheck.reports.pages.analysis.best_choice import Candidate, as_cheap, candidates
from spincheck.reports.pages.analysis.cost_to_reach import LEVELS, reach
from spincheck.reports.pages.analysis.report_data import SceneRuns
from spincheck.reports.pages.analysis.wording import duration
from spincheck.reports.pages.analysis.work_precision import EPS, curve_of
from spincheck.reports.results.records import Key, Row
from spincheck.reports.results.results import SceneResult
from spincheck.reports.results.verdict_words import VerdictWord
from spincheck.scenarios import Errors


def test_an_engine_as_shipped_is_no_candidate() -> None:
    stored, pair = with_law(straight), ("mujoco", "Euler")
    shipped = {pair: replace(stored.methods[pair], as_shipped=True)}
    other = replace(stored, methods=stored.methods | shipped)
    for found, is_there in ((stored, True), (other, False)):
        tried = candidates(scene_of(found), {"omega": BETWEEN})
        assert (pair in [(one.key.engine, one.key.method) for one in tried]) == is_there


LAWS = [straight, bending_up, bending_down]


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("bound", [2.3e-2, 7e-3, BELOW], ids=["between", "lower", "below"])
def test_a_curve_that_bends_does_not_break_the_bound(law: Law, bound: float) -> None:
    best = chosen(with_law(law), "Euler", omega=bound)
    assert law(best.timestep) <= bound * (1 + ROUNDING)


def test_the_tightest_of_several_bounds_decides() -> None:
    stored = with_law(straight)
    both = chosen(stored, "Euler", omega=1e-2, energy=1e-3)
    assert both == replace(chosen(stored, "Euler", energy=1e-3), decided_by="energy")
    assert both.timestep < chosen(stored, "Euler", omega=1e-2).timestep


def test_the_cheapest_comes_first_and_what_is_out_of_reach_last() -> None:
    choices = candidates(scene_of(only(results())), {"omega": BETWEEN})
    costs = [candidate.cost or math.inf for candidate in choices]
    assert costs == sorted(costs)
    assert choices[0].key.method == "RK4"
    assert {candidate.word for candidate in choices} > {"diverges", "failed", "unsupported"}
    assert len(choices) == len(METHODS)


def test_the_largest_stable_timestep_is_below_the_last_blow_up() -> None:
    def blown_up(row: Row) -> Row:
        ends = row.key.method == "Euler" and row.timestep == TIMESTEPS[1]
        return replace(row, outcome="diverged", errors=None) if ends else row

    stored = with_law(straight)
    after = replace(stored, rows=list(map(blown_up, stored.rows)))
    assert chosen(stored, "Euler", omega=BETWEEN).largest_stable == TIMESTEPS[0]
    assert chosen(after, "Euler", omega=BETWEEN).largest_stable == TIMESTEPS[2]


def test_no_timestep_is_recommended_below_which_errors_grow() -> None:
    """As those of single precision do, far above what one ulp a step comes to."""

    def grows(timestep: float) -> float:
        return straight(timestep) + 16 * straight(TIMESTEPS[-1]) * TIMESTEPS[-1] / timestep

    stored = with_law(grows)
    least = min(TIMESTEPS, key=grows)
    assert least > TIMESTEPS[-1]
    within, beyond = (
        chosen(stored, "Euler", omega=bound) for bound in (1.1 * grows(least), 0.5 * grows(least))
    )
    assert within.finest_useful == beyond.finest_useful == least
    assert within.timestep >= least
    assert (beyond.word, beyond.timestep) == ("round-off", None)
    assert f"{least:.3g} s is the least" in beyond.reason
    assert chosen(with_law(straight), "Euler", omega=BELOW).finest_useful is None


def test_in_single_precision_nothing_is_extrapolated_to_where_rounding_decides() -> None:
    """At random it comes to the root of the number of steps, times what an ulp does."""
    stored = with_law(straight)
    single = replace(stored, single_precision=frozenset({"mujoco"}))
    solution = stored.scenes[TOP].solution
    ulp, order = float(np.finfo(np.float32).eps), 1.0
    growth = solution.conditioning.omega / EPS
    for bound in (1e-3, 1e-4, 1e-5, 1e-6):
        assert chosen(stored, "Euler", omega=bound).timestep is not None
        timestep = TIMESTEPS[-1] * (bound / straight(TIMESTEPS[-1])) ** (1 / order)
        steps = solution.trajectory.t[-1] / timestep
        is_above = ulp * growth * math.sqrt(steps) < bound
        found = chosen(single, "Euler", omega=bound)
        assert (found.word == "round-off") == (found.timestep is None) == (not is_above)
    assert not is_above
    assert chosen(single, "Euler", omega=BETWEEN).timestep is not None


def test_runs_at_stock_timesteps_alone_have_a_cost() -> None:
    stored = with_law(straight)
    stored = replace(stored, rows=[replace(row, stock=True) for row in stored.rows])
    assert chosen(stored, "Euler", omega=BETWEEN).timestep is not None


@pytest.mark.parametrize("grows", [True, False])
def test_a_run_ends_with_the_timestep_below_which_errors_grow(grows: bool) -> None:
    rounding = 16 * straight(TIMESTEPS[-1]) * TIMESTEPS[-1] * grows
    stored = with_law(lambda timestep: straight(timestep) + rounding / timestep)
    least = min(TIMESTEPS, key=lambda timestep: straight(timestep) + rounding / timestep)
    every = short_summary(stored, Path("results.sqlite"))
    lines = [line for line in every if "Finer than this makes it worse" in line]
    of_json = {one["method"]: one["finest_useful_timestep"] for one in verdict_records(stored)}
    assert of_json["Euler"] == (least if grows else None)
    assert [f"Euler {duration(least)}" in line for line in lines] == [True] * grows


@pytest.mark.parametrize(("size", "word"), [(1e-13, "converges"), (1.0, "disagrees")])
def test_errors_that_grow_below_what_matters_or_without_converging_are_no_reason_against_finer(
    size: float, word: VerdictWord
) -> None:
    rounding = 16 * straight(TIMESTEPS[-1]) * TIMESTEPS[-1]
    stored = with_law(lambda timestep: size * (straight(timestep) + rounding / timestep))
    stored = replace(stored, verdicts=[replace(one, verdict=word) for one in stored.verdicts])
    assert "makes it worse" not in " ".join(short_summary(stored, Path("results.sqlite")))


def test_costs_within_the_spread_of_the_timings_are_called_alike() -> None:
    key = Key(TOP, "e", "m")
    best = Candidate(key, "measured", "", "omega", None, 1e-3, cost=1.0, spread=0.1)
    near, far = replace(best, cost=1.05), replace(best, cost=1.2)
    without_cost = replace(best, timestep=None, cost=None)
    assert as_cheap([best, near, far, without_cost]) == [near]
    assert as_cheap([without_cost, without_cost]) == []


def of_the_library() -> Iterator[SceneRuns]:
    """Every scene with made-up runs, whose orders, sizes, bends and costs differ scene by scene."""
    stored = only(results())
    stand_in = stored.scenes[TOP].solution
    for k, scenario in enumerate(library()):
        random = np.random.default_rng(k)
        size, bend, price = (float(10 ** random.uniform(-2, 1)) for _ in range(3))
        rows = [
            replace(
                row,
                key=replace(row.key, scenario=scenario.name),
                errors=row.errors and scaled(row.errors, size * (1 + bend * row.timestep)),
                seconds_per_step=row.seconds_per_step and row.seconds_per_step * price,
            )
            for row in stored.rows
        ]
        verdicts = [replace(v, key=replace(v.key, scenario=scenario.name)) for v in stored.verdicts]
        scenes = {scenario.name: SceneResult(scenario, stand_in)}
        yield scene_of(replace(stored, scenes=scenes, rows=rows, verdicts=verdicts))


def scaled(errors: Errors, factor: float) -> Errors:
    return Errors(*(factor * error for _, error in errors))


def test_of_every_scene_of_the_library_a_bound_on_one_error_costs_what_it_costs_to_reach() -> None:
    """Which methods reach an error, by which timestep, at what cost, in the same words."""
    reached = 0
    for scene in of_the_library():
        for level in LEVELS[::2]:
            for candidate in candidates(scene, {"omega": level}):
                curve = curve_of(scene, scene.by_pair[candidate.key.pair], "omega")
                found = reach(curve, level)
                assert (candidate.word, candidate.cost) == (found.word, found.cost)
                if found.cost is not None:
                    reached += 1
                    assert candidate.timestep == found.timestep
    assert reached
