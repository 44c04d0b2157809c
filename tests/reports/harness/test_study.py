"""A study: crashes cost one row, motions end at horizons, expectations are judged."""

import re
from dataclasses import replace

import numpy as np
import pytest
from box import BOX
from planted import (
    AbortSession,
    ChattySession,
    HangSession,
    HeunSession,
    planted,
)
from spincheck.reference.solve import ExactMotion
from spincheck.reports.harness import prepared as prepared_module
from spincheck.reports.harness.choice import Choice
from spincheck.reports.harness.comparison.rows import unmet_expectations
from spincheck.reports.harness.executors import LocalWorkers
from spincheck.reports.results.records import Key, Row
from spincheck.reports.results.results import Results
from spincheck.scenarios import Expect, loads
from studies import study as study_of

pytestmark = pytest.mark.slow

#: Steps; Heun's method in Python takes some 30 µs each.
BUDGET = 1 << 9
#: s, of CPU or idle: longer than the ladder of the faultless one takes.
TIME_LIMIT = 2.0
#: s, of the window of `BOX`.
HALFWAY = 0.5


def study(tmp_path, *kinds, text: str = BOX, executor=None) -> Results:
    choice = Choice(tuple(map(planted, kinds)), max_steps=BUDGET, timed=False)
    return study_of(tmp_path / "results.sqlite", [loads(text, "box")], choice, executor)


@pytest.fixture(scope="module")
def isolated(tmp_path_factory):
    """A study, in a worker process, of engines that would take this one along."""
    kinds = (ChattySession, HangSession, AbortSession, HeunSession)
    folder = tmp_path_factory.mktemp("isolated")
    return study(folder, *kinds, executor=LocalWorkers(1, TIME_LIMIT))


@pytest.mark.processes
def test_an_engine_that_hangs_or_crashes_costs_its_own_rows_which_say_so(isolated):
    words = {verdict.key.engine: verdict.verdict for verdict in isolated.verdicts}
    ended = {"Hang": "failed", "Abort": "failed"}
    assert words == ended | {"Chatty": "converges", "Heun": "converges"}
    reasons = {row.key.engine: row.reason for row in isolated.rows if row.key.engine in ended}
    assert f"did not finish within {TIME_LIMIT:g} s: it hangs" in reasons["Hang"]
    assert "SIGABRT; it last printed: assertion failed: norm(q) > 0" in reasons["Abort"]


@pytest.mark.processes
def test_what_an_engine_prints_is_kept_with_its_own_runs(isolated):
    printed = {row.key.engine: set(row.printed.splitlines()) for row in isolated.rows}
    assert printed == {
        "Chatty": {"stepping"},
        "Hang": set(),
        "Abort": {"solver.cpp:42", "assertion failed: norm(q) > 0"},
        "Heun": set(),
    }


class UpToHalfway(ExactMotion):
    """Known up to half the window and no further."""

    def solve(self, times):
        whole = super().solve(times)
        samples = np.searchsorted(times, HALFWAY)
        return replace(whole, trajectory=whole.trajectory.until(samples), horizon=HALFWAY)

    def outline(self, times):
        return super().outline(times).until(np.searchsorted(times, HALFWAY))


def test_where_the_exact_motion_ends_at_a_horizon_so_do_all_runs(monkeypatch):
    monkeypatch.setattr(prepared_module, "ExactMotion", UpToHalfway)
    prepared = prepared_module.prepare(loads(BOX, "box"), [0.01], BUDGET)
    ladder = [(rung, prepared.solution) for rung in prepared.ladder.rungs]
    for rung, solution in ladder + prepared.singles:
        times = rung.sample_steps * rung.timestep
        np.testing.assert_array_equal(times, solution.trajectory.t)
        assert 0 < times[-1] < HALFWAY


EXPECTATION = """
[[expect]]
engine = "Heun"
method = "Heun"
timestep = 0.01
"""


@pytest.mark.parametrize(
    ("expected", "words"),
    [
        ("omega = 1e-2", None),
        ("omega = 1e-12", r"^ω error at 0.01 s: .* exceeds the expected 1e-12 from t = 0.1 s on$"),
        ('outcome = "diverges"', "^outcome at 0.01 s: ok; expected: diverges$"),
    ],
)
def test_an_expectation_passes_if_it_is_met_and_says_by_how_much_if_not(tmp_path, expected, words):
    (verdict,) = study(tmp_path, HeunSession, text=BOX + EXPECTATION + expected).verdicts
    assert verdict.agrees == (words is None)
    assert verdict.agrees or re.search(words, verdict.unmet[0])


def test_of_a_run_that_blew_up_the_unmet_bound_is_stated():
    expected = Expect(engine="mujoco", method="Euler", timestep=2e-3, attitude=1e-4)
    row = Row(Key("top", "mujoco", "Euler"), "4", 2e-3, "diverged", "the energy exceeds all bounds")
    exact = ExactMotion(loads(BOX, "box")).solve(np.array([0.0])).trajectory
    assert unmet_expectations(loads(BOX, "box"), expected, row, exact) == [
        "outcome at 0.002 s: diverged, the energy exceeds all bounds; "
        "expected: attitude error at most 0.00573° (0.0001 rad)"
    ]
