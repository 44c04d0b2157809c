"""Errors against cost: which runs count, lower limits of errors, orders, and the Pareto front."""

import re
from dataclasses import replace
from importlib import import_module
from itertools import pairwise
from pathlib import Path

import pytest
from laws import ROUNDING, RUNGS, curve_of_errors, curve_of_law, law
from made_up import METHODS, SECONDS_PER_STEP, TIMESTEPS, UNCERTAINTY, results
from spincheck.reports.pages.analysis.observed_order import ASYMPTOTIC
from spincheck.reports.pages.analysis.report_data import SceneRuns, report_data
from spincheck.reports.pages.analysis.work_precision import cost, curves, front
from spincheck.scenarios import EVERYWHERE


def test_cost_is_seconds_a_simulated_second(top: SceneRuns) -> None:
    tried = curves(top, "omega")
    euler = next(curve for curve in tried if curve.label == "mujoco Euler")
    assert [point.cost for point in euler.points] == [SECONDS_PER_STEP / dt for dt in TIMESTEPS]
    row = next(row for row in results().rows if row.outcome == "ok")
    assert cost(replace(row, seconds_per_step=None)) is None


def test_every_run_that_ended_well_is_a_point_and_no_other_is(top: SceneRuns) -> None:
    points_of = {curve.label: len(curve.points) for curve in curves(top, "energy")}
    finished = {"converges", "disagrees", "unresolved"}
    wanted = {
        f"{m.engine} {m.method}": len(TIMESTEPS) if m.verdict in finished else 0 for m in METHODS
    }
    assert points_of == wanted
    unsolved = next(scene for scene in report_data(results()).scenes if scene.solved is None)
    assert curves(unsolved, "omega") == []


def test_no_error_is_below_what_the_reference_is_good_for(top: SceneRuns) -> None:
    for signal in EVERYWHERE:
        limit = getattr(UNCERTAINTY, signal)
        assert all(p.error >= limit for curve in curves(top, signal) for p in curve.points)
    # Some runs would claim less.
    tight = replace(UNCERTAINTY, attitude=1e-6)
    tightened = replace(top.solved, solution=replace(top.solved.solution, uncertainty=tight))
    raised = curves(replace(top, solved=tightened), "attitude")
    assert min(p.error for curve in raised for p in curve.points) == tight.attitude
    assert min(p.error for curve in curves(top, "attitude") for p in curve.points) < tight.attitude


def test_errors_are_shown_in_signals_that_the_reference_and_every_run_have(top: SceneRuns) -> None:
    """Results from before spins were a signal have none of a scene with rotors."""
    with_spins = replace(UNCERTAINTY, spins=1e-13)
    solution = replace(top.solved.solution, uncertainty=with_spins)
    known = replace(top, solved=replace(top.solved, solution=solution))
    assert [signal.name for signal in known.signals] == list(EVERYWHERE)


def test_stable_runs_are_those_below_the_last_that_did_not_end_well(top: SceneRuns) -> None:
    runs = next(runs for runs in top.methods if runs.label == "mujoco Euler")
    rows = tuple(
        replace(row, outcome="diverged", errors=None) if k == 2 else row
        for k, row in enumerate(runs.rows)
    )
    (curve,) = curves(replace(top, methods=(replace(runs, rows=rows),)), "omega")
    assert [point.timestep for point in curve.stable] == list(TIMESTEPS[3:])
    assert [point.timestep for point in curve.points] == [*TIMESTEPS[:2], *TIMESTEPS[3:]]


@pytest.mark.parametrize(("order", "coarsest"), [(1, 0.05), (2, 0.05), (4, 0.05), (-1, 1e-3)])
def test_the_order_of_a_law_is_found_negative_if_errors_grow(order: int, coarsest: float) -> None:
    found = curve_of_law(law(order, coarsest)).observed_order
    assert found == pytest.approx(order, rel=ROUNDING)
    # Too few of saturated errors are asymptotic: the order is the verdict's.
    saturated = curve_of_law(law(1, ASYMPTOTIC * 2 ** (RUNGS - 1)), order=1.5)
    assert saturated.observed_order == 1.5


def test_rounding_takes_over_where_errors_grow_again() -> None:
    """From the run of the least error on; not where they are level, as at their uncertainty."""
    falling = (1e-2, 1e-3, 1e-4)
    bent = curve_of_errors(*falling, 2e-4, 4e-4)
    assert bent.least == bent.points[2]
    for errors in (falling, (*falling, 1e-4), (*falling, 1.2e-4), (*falling, 4e-4), ()):
        assert curve_of_errors(*errors).least is None
    # Where the ladder ends with one larger error, runs at stock timesteps may show it, too.
    ended = curve_of_errors(*falling, 4e-4)
    stock = replace(ended.points[-1], timestep=ended.points[-1].timestep / 10)
    for error, is_shown in ((3e-4, True), (1.2e-4, False)):
        with_stock = replace(ended, points=(*ended.points, replace(stock, error=error)))
        assert (with_stock.least == ended.points[2]) == is_shown


def test_every_point_of_the_front_is_better_than_all_cheaper_ones(top: SceneRuns) -> None:
    """And every other one is beaten by one of the front; untimed runs are none."""
    tried = curves(top, "omega")
    best = [point for _, point in front(tried)]
    assert len(best) > 2
    assert all(a.cost < b.cost and a.error > b.error for a, b in pairwise(best))
    others = [p for curve in tried for p in curve.points if p not in best]
    assert others
    for point in others:
        assert any(b.cost <= point.cost and b.error <= point.error for b in best)
    assert front([curve_of_law(law(1), seconds=None)]) == []


DOCS = Path(__file__).parents[4] / "docs/explanation/cost.md"


@pytest.mark.parametrize(
    ("module", "constant"), re.findall(r"`reports/([\w/]+)\.py`: `([A-Z_]+)`", DOCS.read_text())
)
def test_every_constant_that_the_page_on_cost_names_exists(module: str, constant: str) -> None:
    path = module.replace("/", ".")
    assert hasattr(import_module(f"spincheck.reports.{path}"), constant)
