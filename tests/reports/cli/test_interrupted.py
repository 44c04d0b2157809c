"""`spincheck run`, killed at any moment, loses the runs in flight and no more."""

import os
import signal

import pytest
from kills import TARGETS, children, finish, gone, read, rounds, start
from result_files import rows_in, wait_for_rows
from same_results import differences
from spincheck.reports.results.store import Results

pytestmark = pytest.mark.processes

#: Kills of every kind; `kills.py` makes more of them.
KILLS = len(TARGETS)


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory) -> Results:
    """The results of a quick run that nobody disturbed."""
    path = tmp_path_factory.mktemp("undisturbed") / "results.sqlite"
    finish(path, "--quick")
    return read(path)


def test_killed_at_a_random_moment_it_goes_on_as_if_it_had_not_been(tmp_path):
    found = list(rounds(tmp_path, KILLS))
    assert [(kill.target, kill.faults) for kill in found] == [(target, ()) for target in TARGETS]


def test_a_killed_run_leaves_its_rows_and_no_process(tmp_path, undisturbed):
    path = tmp_path / "results.sqlite"
    run = start(path, "--quick")
    wait_for_rows(run, path, 10)
    run.kill()
    run.communicate()
    assert gone(run.pid)
    before = rows_in(path)
    assert before >= 10
    finish(path, "--quick")
    assert differences(read(path), undisturbed) == []


def test_what_is_there_already_is_said(tmp_path):
    path = tmp_path / "results.sqlite"
    finish(path, "--quick")
    assert "2 of 2 results are there already" in finish(path, "--quick")


def test_a_killed_worker_is_replaced_and_its_run_made_again(tmp_path, undisturbed):
    path = tmp_path / "results.sqlite"
    run = start(path, "--quick")
    wait_for_rows(run, path, 5)
    for worker in children(run.pid):
        os.kill(worker, signal.SIGKILL)
    run.communicate()
    assert run.returncode == 0
    assert differences(read(path), undisturbed) == []


def test_a_second_run_into_the_same_file_is_refused(tmp_path, undisturbed):
    path = tmp_path / "results.sqlite"
    first = start(path, "--quick")
    wait_for_rows(first, path, 1)
    # Stopped, so that it cannot end before the second has begun.
    first.send_signal(signal.SIGSTOP)
    second = start(path, "--quick")
    _, err = second.communicate()
    first.send_signal(signal.SIGCONT)
    assert second.returncode == 2
    assert err == f"spincheck: {path}: another 'spincheck run' is writing to it\n"
    first.communicate()
    assert first.returncode == 0
    assert differences(read(path), undisturbed) == []
