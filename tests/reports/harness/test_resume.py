"""A study that was stopped in any way is continued, and ends with the same results."""

import errno
import os
from dataclasses import replace
from pathlib import Path
from shutil import copyfile

import pytest
from box import BOX
from command_line import spincheck
from failing_calls import FailingCalls, of_function
from planted import HeunSession, RaisingSession, planted
from same_results import differences
from spincheck.engines.lost_process import KILLED
from spincheck.reports.harness import study as study_module
from spincheck.reports.harness.choice import Choice
from spincheck.reports.harness.executors import CallFailed, Executor
from spincheck.reports.harness.judging import ladder_end
from spincheck.reports.harness.prepared import prepare
from spincheck.reports.harness.study import simulate
from spincheck.reports.results import fingerprints as fingerprints
from spincheck.reports.results.records import Record, Row
from spincheck.reports.results.results import Results
from spincheck.reports.results.store import Store, open_store
from spincheck.scenarios import loads
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


@pytest.fixture
def path(tmp_path):
    return tmp_path / "results.sqlite"


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


@pytest.fixture
def runs(monkeypatch) -> list[Row]:
    """The rows stored from now on."""
    stored: list[Row] = []
    put = Store.put

    def counting(store: Store, *records: Record) -> None:
        put(store, *records)
        stored.extend(record for record in records if isinstance(record, Row))

    monkeypatch.setattr(Store, "put", counting)
    return stored


def test_a_study_that_is_complete_runs_nothing(finished, runs, undisturbed):
    assert run(finished) == []
    assert runs == []
    assert differences(read(finished), undisturbed) == []


@pytest.mark.parametrize("rows", [0, 1, 3, 6])
def test_a_study_stopped_after_some_rows_runs_only_the_others(
    path, runs, undisturbed, monkeypatch, rows
):
    put = Store.put

    def stopping(store: Store, *records: Record) -> None:
        if len(runs) == rows and isinstance(records[0], Row):
            raise KeyboardInterrupt
        put(store, *records)

    with monkeypatch.context() as patch:
        patch.setattr(Store, "put", stopping)
        with pytest.raises(KeyboardInterrupt):
            run(path)
    run(path)
    assert len(runs) == len(undisturbed.rows)
    assert differences(read(path), undisturbed) == []


def test_a_study_stopped_before_steps_are_timed_has_them_timed(path, monkeypatch):
    with monkeypatch.context() as patch:
        patch.setattr(study_module, "time_scene", _interrupted)
        with pytest.raises(KeyboardInterrupt):
            run(path, TIMED)
    assert run(path, TIMED) == ["box  timed"]
    assert run(path, TIMED) == []
    timed = {row.key.engine for row in read(path).rows if row.seconds_per_step is not None}
    assert timed == {"Heun"}


def _interrupted(*_: object) -> None:
    raise KeyboardInterrupt


def test_the_samples_of_a_finished_ladder_are_those_of_one_run(undisturbed):
    rows = [row for row in undisturbed.rows if row.key.engine == "Heun" and not row.stock]
    (with_motion,) = [row for row in rows if row.motion is not None]
    assert with_motion.timestep == min(row.timestep for row in rows)


@pytest.mark.parametrize(("changed", "again"), [("# a comment\n", 0), ("", 1)])
def test_a_scene_is_run_anew_if_it_says_something_else(finished, runs, undisturbed, changed, again):
    text = BOX + EXPECTATION
    run(finished, text=text + changed if changed else text.replace("samples = 11", "samples = 6"))
    assert len(runs) == again * len(undisturbed.rows)


def test_another_version_of_an_engine_has_its_own_runs_made_anew(finished, runs, monkeypatch):
    monkeypatch.setattr(type(planted(HeunSession)), "version", "2")
    run(finished)
    assert {row.key.engine for row in runs} == {"Heun"}
    assert len(read(finished).verdicts) == len(ENGINES)


def test_another_spincheck_runs_everything_anew(finished, runs, undisturbed, monkeypatch):
    monkeypatch.setattr(fingerprints, "program", lambda kind: f"another {kind}")
    run(finished)
    assert len(runs) == len(undisturbed.rows)


def test_costs_measured_on_another_processor_are_taken_anew(path, monkeypatch):
    run(path, TIMED)
    monkeypatch.setattr("spincheck.reports.harness.plan.processor", lambda: "another")
    assert run(path, TIMED) == ["box  timed"]


def test_an_engine_added_later_is_run_alone(path, runs, undisturbed):
    run(path, replace(LADDER, engines=ENGINES[:1]))
    runs.clear()
    run(path)
    assert {row.key.engine for row in runs} == {"Raising"}
    assert differences(read(path), undisturbed) == []


def test_a_scene_run_later_leaves_the_others_as_they_are(finished, undisturbed):
    both = study_of(finished, [loads(BOX, "crate")], LADDER)
    one = replace(
        both,
        scenes={"box": both.scenes["box"]},
        rows=[row for row in both.rows if row.key.scenario == "box"],
        verdicts=[verdict for verdict in both.verdicts if verdict.key.scenario == "box"],
    )
    assert differences(one, undisturbed) == []


def test_an_unmet_expectation_is_reported_by_a_study_that_was_gone_on_with(
    finished, runs, monkeypatch
):
    unmet = [verdict.unmet for verdict in read(finished).verdicts if verdict.key.engine == "Heun"]
    with open_store(finished, create=True) as store, store._database.transaction() as connection:
        connection.execute("DELETE FROM verdicts")
    run(finished)
    again = [verdict.unmet for verdict in read(finished).verdicts if verdict.key.engine == "Heun"]
    assert unmet == again
    assert "ω error" in unmet[0][0]


def test_a_timestep_is_run_once_however_often_it_is_asked_for(path, runs):
    run(path, ALONE)
    runs.clear()
    assert run(path, ALONE) == []
    assert runs == []


def test_a_timestep_asked_for_leaves_the_ladder_and_its_verdict(finished, undisturbed):
    run(finished, ALONE)
    results = read(finished)
    ladder = replace(results, rows=[row for row in results.rows if row.timestep != 0.02])
    assert differences(ladder, undisturbed) == []


def test_the_verdict_on_a_timestep_is_its_own(finished):
    run(finished, ALONE)
    (verdict,) = read(finished, timesteps=(0.02,)).verdicts
    assert (verdict.verdict, "no ladder was run" in verdict.reason) == ("unresolved", True)


def test_a_ladder_cut_short_by_a_lesser_limit_is_gone_on_with(path, tmp_path, monkeypatch):
    # No limit is known so well: all rungs are run.
    for goal in ("GOAL", "FINE_GOAL"):
        monkeypatch.setattr(ladder_end, goal, 0.0)
    longer, other = replace(LADDER, max_steps=1 << 11), tmp_path / "longer.sqlite"
    run(path)
    run(other, longer)
    assert len(read(path).rows) < len(read(other).rows)
    run(path, longer)
    assert differences(read(path), read(other)) == []


def test_a_longer_ladder_serves_whoever_asks_for_a_shorter_one(finished, runs):
    run(finished, replace(LADDER, max_steps=1))
    assert runs == []


@pytest.mark.parametrize("name", ["SIGKILL", "SIGXCPU", "SIGUSR1"])
def test_a_run_that_was_killed_from_outside_is_made_again(path, undisturbed, name):
    killed = CallFailed(f"the worker process {KILLED} by {name}", "killed")
    run(path, executor=FailingCalls(of_function(simulate, killed)))
    assert {verdict.verdict for verdict in read(path).verdicts} == {"failed"}
    run(path)
    assert differences(read(path), undisturbed) == []


@pytest.mark.parametrize("function", [simulate, prepare], ids=["run", "reference"])
def test_what_the_machine_refused_is_made_again(path, undisturbed, function):
    """No worker could be started, for want of descriptors or processes."""
    refused = CallFailed("no worker process could be started: [Errno 24]", "environment")
    run(path, executor=FailingCalls(of_function(function, refused)))
    assert {verdict.verdict for verdict in read(path).verdicts} == {"failed"}
    run(path)
    assert differences(read(path), undisturbed) == []


@pytest.mark.parametrize(
    ("number", "again"),
    [
        *((number, True) for number in (errno.ENOSPC, errno.EMFILE, errno.EAGAIN, errno.EROFS)),
        *((number, False) for number in (errno.EINVAL, errno.ENOENT)),
    ],
    ids=errno.errorcode.get,
)
def test_an_error_of_the_system_is_the_engines_only_if_it_stays(
    path, runs, monkeypatch, number, again
):
    def refuse(*_: object) -> None:
        raise OSError(number, os.strerror(number))

    with monkeypatch.context() as patch:
        patch.setattr(type(ENGINES[0]), "open", refuse)
        run(path)
    runs.clear()
    run(path)
    assert {row.key.engine for row in runs} == ({"Heun"} if again else set())


def test_everything_is_made_again_if_that_is_asked_for(finished, runs, undisturbed):
    run(finished, replace(LADDER, again=True))
    assert len(runs) == len(undisturbed.rows)
    assert differences(read(finished), undisturbed) == []


def overrun(path: Path, reason: str) -> None:
    """Have one run of Heun's method, and so its verdict, end for a reason."""
    with open_store(path, create=True) as store:
        stored = store.read()
        (verdict,) = (v for v in stored.verdicts if v.key.engine == "Heun")
        row = next(row for row in stored.rows if row.key == verdict.key)
        store.put(replace(row, outcome="failed", reason=reason, errors=None))
        store.put_verdict(replace(verdict, verdict="failed", reason=reason))


@pytest.mark.parametrize(
    ("time_limit", "again"), [(None, False), (100.0, False), (120.0, False), (200.0, True)]
)
def test_what_was_stopped_is_run_again_by_whoever_gives_it_longer(
    finished, runs, undisturbed, time_limit, again
):
    overrun(finished, "did not finish within 120 s; it last printed: a word")
    runs.clear()
    run(finished, replace(LADDER, time_limit=time_limit))
    assert {row.key.engine for row in runs} == ({"Heun"} if again else set())
    assert (differences(read(finished), undisturbed) == []) == again


@pytest.mark.parametrize("seconds", ["0", "-1", "nan", "inf"])
def test_a_time_limit_that_is_none_is_one_message(path, seconds):
    done = spincheck("run", "fast-top", "--time-limit", seconds, "--out", path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("spincheck: '--time-limit' must be positive")
    assert not path.exists()


@pytest.mark.parametrize("what", ["outcome", "motion", "verdict", "missing"])
def test_the_comparison_notices(undisturbed, what):
    heun = next(row for row in undisturbed.rows if row.motion is not None)
    assert heun.motion
    planted_fault = {
        "outcome": replace(heun, outcome="diverged", errors=None),
        "motion": replace(heun, motion=heun.motion.until(3)),
    }
    others = [row for row in undisturbed.rows if row is not heun]
    if what == "verdict":
        first, *rest = undisturbed.verdicts
        other = replace(undisturbed, verdicts=[replace(first, reason="another"), *rest])
    else:
        changed = [planted_fault[what]] if what in planted_fault else []
        other = replace(undisturbed, rows=[*others, *changed])
    assert len(differences(undisturbed, other)) == 1
