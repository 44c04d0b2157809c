"""A study that was stopped in any way is continued, and ends with the same results."""

import errno
import os
from dataclasses import replace
from pathlib import Path
from shutil import copyfile

import pytest
from box import BOX
from failing_calls import FailingCalls, of_function
from ladders import only
from planted import HeunSession, RaisingSession, planted
from same_results import differences
from spincheck.engines.child import ANSWER_LIMIT
from spincheck.engines.lost_process import KILLED
from spincheck.reports.harness import study as study_module
from spincheck.reports.harness.choice import Choice
from spincheck.reports.harness.executors import TIME_LIMIT, CallFailed, Executor
from spincheck.reports.harness.judging import ladder_end
from spincheck.reports.harness.measuring.examine import examine_or_refuse
from spincheck.reports.harness.measuring.replay import examine_runs
from spincheck.reports.harness.prepared import prepare
from spincheck.reports.harness.study import simulate
from spincheck.reports.results import fingerprints as fingerprints
from spincheck.reports.results.results import Results
from spincheck.reports.results.store import open_store
from spincheck.reports.results.verdicts import Verdict
from spincheck.scenarios import loads
from studies import stop_at
from studies import study as study_of

pytestmark = pytest.mark.slow

EXPECTATION = """
[[expect]]
engine = "Heun"
method = "Heun"
timestep = 0.01
omega = 1e-12
"""
#: Steps; Heun's method in Python takes some 30 µs each.
BUDGET = 1 << 9
ENGINES = (planted(HeunSession), planted(RaisingSession))
LADDER = Choice(ENGINES, max_steps=BUDGET, timed=False)
TIMED = replace(LADDER, timed=True)
ALONE = Choice(ENGINES[:1], timesteps=(0.02,), timed=False)


def run(
    path: Path,
    choice: Choice = LADDER,
    text: str = BOX + EXPECTATION,
    executor: Executor | None = None,
) -> list[str]:
    """Run a study of one scene; returns what progress was told."""
    lines: list[str] = []
    study_of(path, [loads(text, "box")], choice, executor, lines.append)
    return lines


def read(path: Path, timesteps: tuple[float, ...] = ()) -> Results:
    with open_store(path) as store:
        return store.read(timesteps)


@pytest.fixture(scope="module")
def complete(tmp_path_factory) -> Path:
    """The file of a study that nobody disturbed."""
    path = tmp_path_factory.mktemp("undisturbed") / "results.sqlite"
    run(path)
    return path


@pytest.fixture(scope="module")
def undisturbed(complete) -> Results:
    return read(complete)


@pytest.fixture
def finished(complete, path) -> Path:
    """A copy of that file."""
    return Path(copyfile(complete, path))


def test_a_study_that_is_complete_or_of_a_longer_ladder_runs_nothing(finished, runs, undisturbed):
    assert run(finished) == []
    run(finished, replace(LADDER, max_steps=1))
    assert runs == []
    assert differences(read(finished), undisturbed) == []


@pytest.mark.parametrize("rows", [0, 1, 3, 6])
def test_a_study_stopped_after_some_rows_runs_only_the_others(
    path, runs, undisturbed, monkeypatch, rows
):
    stop_at(monkeypatch, lambda _: len(runs) == rows, lambda: run(path))
    run(path)
    assert len(runs) == len(undisturbed.rows)
    assert differences(read(path), undisturbed) == []


def test_a_study_stopped_before_steps_are_timed_has_them_timed(path, monkeypatch):
    """Once, and on another processor anew."""
    with monkeypatch.context() as patch:
        patch.setattr(study_module, "time_scene", _interrupted)
        with pytest.raises(KeyboardInterrupt):
            run(path, TIMED)
    assert run(path, TIMED) == ["box  timed"]
    assert run(path, TIMED) == []
    timed = {row.key.engine for row in read(path).rows if row.seconds_per_step is not None}
    assert timed == {"Heun"}
    monkeypatch.setattr("spincheck.reports.harness.plan.processor", lambda: "another")
    assert run(path, TIMED) == ["box  timed"]


def _interrupted(*_: object) -> None:
    raise KeyboardInterrupt


def test_the_samples_kept_are_of_the_finest_run_and_of_what_is_expected(undisturbed):
    rows = [row for row in undisturbed.rows if row.key.engine == "Heun" and not row.stock]
    (expected,) = undisturbed.scenes["box"].scenario.expect
    with_motion = {row.timestep for row in rows if row.motion is not None}
    assert with_motion == {min(row.timestep for row in rows), expected.timestep}


def test_a_scene_is_run_anew_if_it_says_something_else(finished, runs, undisturbed):
    text = BOX + EXPECTATION
    run(finished, text=f"{text}# a comment\n")
    assert runs == []
    run(finished, text=text.replace("samples = 11", "samples = 6"))
    assert len(runs) == len(undisturbed.rows)


def test_everything_is_run_anew_by_another_spincheck_and_if_that_is_asked_for(
    finished, runs, undisturbed, monkeypatch
):
    with monkeypatch.context() as patch:
        patch.setattr(fingerprints, "program", lambda kind: f"another {kind}")
        run(finished)
    assert len(runs) == len(undisturbed.rows)
    runs.clear()
    run(finished, replace(LADDER, again=True))
    assert len(runs) == len(undisturbed.rows)
    assert differences(read(finished), undisturbed) == []


def test_another_version_of_an_engine_has_its_own_runs_made_anew(finished, runs, monkeypatch):
    monkeypatch.setattr(type(planted(HeunSession)), "version", "2")
    run(finished)
    assert {row.key.engine for row in runs} == {"Heun"}
    assert len(read(finished).verdicts) == len(ENGINES)


def test_an_engine_added_later_is_run_alone(path, runs, undisturbed):
    run(path, replace(LADDER, engines=ENGINES[:1]))
    runs.clear()
    run(path)
    assert {row.key.engine for row in runs} == {"Raising"}
    assert differences(read(path), undisturbed) == []


def test_a_scene_run_later_leaves_the_others_as_they_are(finished, undisturbed):
    both = study_of(finished, [loads(BOX, "crate")], LADDER)
    assert differences(only(both, "box"), undisturbed) == []


def test_an_unmet_expectation_is_reported_by_a_study_that_was_gone_on_with(finished):
    def unmet() -> tuple[str, ...]:
        return next(v.unmet for v in read(finished).verdicts if v.key.engine == "Heun")

    before = unmet()
    with open_store(finished, create=True) as store, store._database.transaction() as connection:
        connection.execute("DELETE FROM verdicts")
    run(finished)
    assert unmet() == before
    assert "ω error" in before[0]


def test_a_timestep_asked_for_is_run_once_and_leaves_the_ladder_and_its_verdict(
    finished, runs, undisturbed
):
    run(finished, ALONE)
    runs.clear()
    assert run(finished, ALONE) == []
    assert runs == []
    results = read(finished)
    ladder = replace(results, rows=[row for row in results.rows if row.timestep != 0.02])
    assert differences(ladder, undisturbed) == []
    # The verdict on it is its own.
    (verdict,) = read(finished, timesteps=(0.02,)).verdicts
    assert verdict.verdict == "converges"
    assert 0.02 in [one.timestep for one in verdict.replays]


def test_a_ladder_cut_short_by_a_lesser_limit_is_gone_on_with(path, tmp_path, monkeypatch):
    # No errors are so small: all rungs are run.
    monkeypatch.setattr(ladder_end, "GOAL", 0.0)
    longer, other = replace(LADDER, max_steps=1 << 11), tmp_path / "longer.sqlite"
    run(path)
    run(other, longer)
    assert len(read(path).rows) < len(read(other).rows)
    run(path, longer)
    assert differences(read(path), read(other)) == []


SIGNALLED = CallFailed(f"the worker process {KILLED} by SIGUSR1", "killed")
REFUSED = CallFailed("no worker process could be started: [Errno 24]", "environment")


def of_heun(path: Path) -> Verdict:
    """The verdict on the engine that fails nothing."""
    (verdict,) = (one for one in read(path).verdicts if one.key.engine == "Heun")
    return verdict


@pytest.mark.parametrize(
    ("function", "failure", "word"),
    [
        (simulate, SIGNALLED, "failed"),
        (simulate, REFUSED, "failed"),
        (prepare, REFUSED, "failed"),
        (examine_or_refuse, SIGNALLED, "unresolved"),
        (examine_runs, REFUSED, "unresolved"),
    ],
    ids=["killed", "run refused", "reference refused", "steps killed", "replay refused"],
)
def test_what_the_machine_killed_or_refused_is_made_again(
    path, undisturbed, function, failure, word
):
    run(path, executor=FailingCalls(of_function(function, failure)))
    assert of_heun(path).verdict == word
    run(path)
    assert differences(read(path), undisturbed) == []


@pytest.mark.parametrize("function", [examine_or_refuse, examine_runs])
def test_an_engine_that_crashes_only_when_it_is_examined_has_failed(path, runs, function):
    """Its runs are ok, and what came of them is not made again."""
    crash = CallFailed("the worker process was killed by SIGSEGV", "crash")
    executor = FailingCalls(of_function(function, crash))
    run(path, executor=executor)
    assert of_heun(path).verdict == "failed"
    assert of_heun(path).reason == f"when set to other states, it fails: {crash.reason}"
    runs.clear()
    run(path, executor=executor)
    assert not runs


OF_THE_SYSTEM = (errno.ENOSPC, errno.EMFILE, errno.EAGAIN, errno.EROFS)
OF_THE_ENGINE = (errno.EINVAL, errno.ENOENT)


@pytest.mark.parametrize("number", OF_THE_SYSTEM + OF_THE_ENGINE, ids=errno.errorcode.get)
def test_an_error_of_the_system_is_the_engines_only_if_it_stays(path, runs, monkeypatch, number):
    def refuse(*_: object) -> None:
        raise OSError(number, os.strerror(number))

    with monkeypatch.context() as patch:
        patch.setattr(type(ENGINES[0]), "open", refuse)
        run(path)
    runs.clear()
    run(path)
    assert {row.key.engine for row in runs} == ({"Heun"} if number in OF_THE_SYSTEM else set())


def overrun(path: Path, reason: str) -> None:
    """Have one run of Heun's method, and so its verdict, end for a reason."""
    with open_store(path, create=True) as store:
        stored = store.read()
        (verdict,) = (v for v in stored.verdicts if v.key.engine == "Heun")
        row = next(row for row in stored.rows if row.key == verdict.key)
        store.put(replace(row, outcome="failed", reason=reason, errors=None))
        store.put_verdict(replace(verdict, verdict="failed", quoted=reason))


RUN, CHILD = "did not finish", "it did not answer 'advance'"


@pytest.mark.parametrize(
    ("what", "exceeded", "time_limit", "again"),
    [
        (RUN, TIME_LIMIT, None, False),
        (RUN, TIME_LIMIT / 2, None, True),
        (RUN, TIME_LIMIT, TIME_LIMIT / 2, False),
        (RUN, TIME_LIMIT, TIME_LIMIT, False),
        (RUN, TIME_LIMIT, 2 * TIME_LIMIT, True),
        (CHILD, ANSWER_LIMIT / 2, None, True),
        (CHILD, ANSWER_LIMIT, 2 * TIME_LIMIT, False),
    ],
)
def test_what_was_stopped_is_run_again_by_whoever_gives_it_longer(
    finished, runs, undisturbed, what, exceeded, time_limit, again
):
    overrun(finished, f"{what} within {exceeded:g} s; it last printed: a word")
    runs.clear()
    run(finished, replace(LADDER, time_limit=time_limit))
    assert {row.key.engine for row in runs} == ({"Heun"} if again else set())
    assert (differences(read(finished), undisturbed) == []) == again


def test_the_comparison_notices(undisturbed):
    heun = next(row for row in undisturbed.rows if row.motion is not None)
    others = [row for row in undisturbed.rows if row is not heun]
    ended = replace(heun, outcome="diverged", errors=None)
    cut = replace(heun, motion=heun.motion.until(3))
    first, *rest = undisturbed.verdicts
    for changed in (
        {"rows": [*others, ended]},
        {"rows": [*others, cut]},
        {"rows": others},
        {"verdicts": [replace(first, quoted="another"), *rest]},
    ):
        assert len(differences(undisturbed, replace(undisturbed, **changed))) == 1
