"""Runs at stock timesteps: made in addition to the ladder, stored, refused with a reason."""

from dataclasses import replace

import numpy as np
import pytest
from box import BOX
from planted import ExplodingSession, HeunSession, RaisingSession, planted
from spincheck.engines import Engine
from spincheck.reports.harness.choice import Choice
from spincheck.reports.harness.timesteps.ladder import QUICK_STEPS, single
from spincheck.reports.harness.timesteps.stock import (
    COMMON_TIMESTEP,
    STEP_BUDGET,
    StockRun,
    stock_rung,
    stock_runs_of,
)
from spincheck.reports.results.records import Row
from spincheck.reports.results.results import Results
from spincheck.scenarios import loads
from studies import stop_at
from studies import study as study_of

pytestmark = pytest.mark.slow

STOCK = 1 / 240
#: Steps; Heun's method in Python takes some 30 µs each.
BUDGET = 1 << 8


class HeunAsSold(type(planted(HeunSession))):
    """The faultless engine, with a timestep of its own."""

    stock_timestep = STOCK


def study(path, *engines: Engine, text: str = BOX, **choices) -> Results:
    choice = replace(Choice(engines, max_steps=BUDGET, timed=False), **choices)
    return study_of(path, [loads(text, "box")], choice)


def stock_rows(results: Results) -> dict[float, Row]:
    return {row.timestep: row for row in results.rows if row.stock}


@pytest.fixture(scope="module")
def stock_results(tmp_path_factory) -> Results:
    return study(tmp_path_factory.mktemp("stock") / "r.sqlite", HeunAsSold())


def test_an_engine_is_run_at_its_own_stock_timestep_and_at_one_for_all(stock_results):
    """Such a run has errors and keeps its samples."""
    assert set(stock_rows(stock_results)) == {STOCK, COMMON_TIMESTEP}
    for row in stock_rows(stock_results).values():
        assert row.outcome == "ok"
        assert row.errors.omega > 0
        assert row.motion.t[-1] == pytest.approx(1.0, abs=row.timestep / 2)


def test_the_verdict_is_that_without_them(stock_results, path, monkeypatch):
    """Their replays are among what it rests on."""
    monkeypatch.setattr("spincheck.reports.harness.prepared.stock_timesteps", lambda _: ())
    without = study(path, HeunAsSold())
    assert not stock_rows(without)
    for verdict, other in zip(without.verdicts, stock_results.verdicts, strict=True):
        assert (verdict.verdict, verdict.steps) == (other.verdict, other.steps)
        assert len(verdict.replays) == len(other.replays) - 1


def test_a_blow_up_at_a_stock_timestep_leaves_the_verdict(path):
    class LastStepExplodes(HeunAsSold):
        def open(self, scenario, method, timestep):
            kind = ExplodingSession if timestep == STOCK else HeunSession
            return kind(scenario, timestep)

    results = study(path, LastStepExplodes())
    assert stock_rows(results)[STOCK].outcome == "diverged"
    assert results.verdicts[0].verdict == "converges"


def test_a_study_stopped_before_its_stock_runs_makes_them_alone_and_once(path, runs, monkeypatch):
    stop_at(monkeypatch, lambda row: row.stock, lambda: study(path, HeunAsSold()))
    runs.clear()
    study(path, HeunAsSold())
    assert sorted(row.timestep for row in runs) == [COMMON_TIMESTEP, STOCK]
    study(path, HeunAsSold())
    assert len(runs) == 2


def test_stock_timesteps_are_left_out_where_all_fail_or_others_are_asked_for(path):
    assert [row.outcome for row in study(path, planted(RaisingSession)).rows] == ["failed"]
    path.unlink()
    results = study(path, HeunAsSold(), timesteps=(0.02,))
    assert [row.timestep for row in results.rows] == [0.02]


def test_where_the_motion_is_too_fast_for_it_a_row_says_so_and_nothing_is_run(path):
    fast = BOX.replace("[1.0, 2.0, 0.5]", "[0.0, 0.0, 2000.0]")
    fast = fast.replace("duration = 1.0", "duration = 0.1")
    row = stock_rows(study(path, HeunAsSold(), text=fast))[STOCK]
    assert (row.outcome, row.cause, row.errors) == ("unsupported", "timestep", None)
    assert "turns 477° a step" in row.reason
    assert not row.made


@pytest.mark.parametrize(
    ("timestep", "rate", "horizon", "words"),
    [
        (1e-3, 1.0, 2 * STEP_BUDGET * 1e-3, "takes 2.62e+05 steps"),
        (1e-3, 1.0, 5e-3, "are 5 steps, too few to judge"),
        (2e-3, 2000.0, 1.0, "turns 229° a step"),
    ],
)
def test_what_makes_no_sense_is_reported_with_its_numbers(timestep, rate, horizon, words):
    assert words in str(stock_rung(np.array([0.0, horizon]), timestep, rate))


HARD = BOX.replace("spincheck = 1\n", 'spincheck = 1\ntags = ["hard"]\n')


@pytest.mark.parametrize(
    ("text", "stock_timestep", "steps", "is_made"),
    [
        (BOX, STOCK, 2 * QUICK_STEPS, True),
        (HARD, STOCK, 2 * QUICK_STEPS, False),
        (HARD, STOCK, QUICK_STEPS, True),
        (HARD, COMMON_TIMESTEP, 2 * QUICK_STEPS, True),
        (HARD, None, 2 * QUICK_STEPS, True),
    ],
    ids=["plain", "hard", "short", "its own", "its users set one"],
)
def test_of_a_hard_scene_a_long_run_is_made_at_the_engines_own_timestep_alone(
    text, stock_timestep, steps, is_made, monkeypatch
):
    monkeypatch.setattr(HeunAsSold, "stock_timestep", stock_timestep)
    times = np.array([0.0, steps * COMMON_TIMESTEP])
    prepared = [StockRun(COMMON_TIMESTEP, single(COMMON_TIMESTEP, times))]
    (run,) = stock_runs_of(HeunAsSold(), loads(text, "box"), prepared)
    assert (run.rung is not None) == is_made
    assert is_made or f"takes {steps} steps; on hard scenes at most 16384" in run.refusal
