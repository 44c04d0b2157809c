"""`spincheck run`, killed at any moment, loses the runs in flight and no more."""

import os
import signal
from pathlib import Path

import pytest
from command_line import spincheck
from kills import STUDY, after, children, is_gone, read, start
from result_files import wait_for_rows
from same_results import differences
from spincheck.reports.results.results import Results

pytestmark = pytest.mark.processes

#: Rows that are stored before something is killed: some of the first ladder's, most of both.
EARLY, LATE = 3, 10


def finish(path: Path) -> None:
    """The same command, in this process, to its end."""
    done = spincheck("run", *STUDY, "--quick", "--jobs", 1, "--out", path)
    assert done.returncode == 0, done.stderr


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory) -> Results:
    """The results of a quick run that nobody disturbed."""
    path = tmp_path_factory.mktemp("undisturbed") / "results.sqlite"
    finish(path)
    return read(path)


@pytest.mark.parametrize(("target", "rows"), [("run", LATE), ("group", EARLY)])
def test_a_killed_run_goes_on_as_if_it_had_not_been(path, undisturbed, target, rows):
    """`kills.py` does the same at random moments, fifty times."""
    run = start(path, "--quick", jobs=1)
    wait_for_rows(run, path, rows)
    (os.killpg if target == "group" else os.kill)(run.pid, signal.SIGKILL)
    run.communicate()
    assert is_gone(run.pid)
    assert list(after(path, undisturbed, finish)) == []


def test_neither_a_second_run_into_its_file_nor_a_killed_worker_changes_a_result(path, undisturbed):
    """The second run is refused; the worker is replaced, and its run made again."""
    first = start(path, "--quick", jobs=1)
    wait_for_rows(first, path, EARLY)
    # Stopped, so that it cannot end before the second has begun.
    first.send_signal(signal.SIGSTOP)
    try:
        second = spincheck("run", *STUDY, "--quick", "--out", path)
        for worker in children(first.pid):
            os.kill(worker, signal.SIGKILL)
    finally:
        first.send_signal(signal.SIGCONT)
    assert second.returncode == 2
    assert second.stderr == f"spincheck: {path}: another 'spincheck run' is writing to it\n"
    first.communicate()
    assert first.returncode == 0
    assert differences(read(path), undisturbed) == []
