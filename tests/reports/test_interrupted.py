"""`spincheck run`, killed or interrupted at any moment, loses the runs in flight and no more."""

import os
import random
import signal
import sqlite3
import subprocess
import sys
import time
from contextlib import closing
from pathlib import Path

import pytest
from same_results import differences
from spincheck.reports.store import Results, open_store

COMMAND = Path(sys.executable).with_name("spincheck")
#: A scene of short ladders.
SCENE = "gazebo-box-tumbling"
METHODS = ("--engine", "mujoco", "--method", "Euler", "--method", "RK4")
#: Times that a run is killed before it is let go on to its end.
KILLS = 8
SEED = 20260101
#: s; what Ctrl-C may take, on a machine that is busy with other tests.
PATIENCE = 30.0


def start(path: Path, *options: str) -> subprocess.Popen[str]:
    """`spincheck run` in a process group of its own."""
    return subprocess.Popen(
        [COMMAND, "run", SCENE, *METHODS, "--jobs", "2", "--out", path, *options],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=hear_interrupts,
    )


def hear_interrupts() -> None:
    """Undo what a shell does to commands in the background: they are deaf to Ctrl-C."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def finish(path: Path, *options: str) -> str:
    """Run to the end; returns stderr."""
    run = start(path, *options)
    _, err = run.communicate()
    assert run.returncode == 0, err
    return err


def read(path: Path) -> Results:
    with open_store(path) as store:
        return store.read()


def rows_in(path: Path) -> int:
    """Rows in a result file that is perhaps just being begun."""
    try:
        with closing(sqlite3.connect(f"{path.as_uri()}?mode=ro", uri=True)) as connection:
            return int(connection.execute("SELECT count(*) FROM rows").fetchone()[0])
    except sqlite3.OperationalError:
        return 0


def wait_for_rows(path: Path, rows: int) -> None:
    while rows_in(path) < rows:
        time.sleep(0.01)


def gone(group: int) -> bool:
    """Whether a process group has no process left, dead ones to be reaped by others aside."""
    deadline = time.monotonic() + PATIENCE
    while time.monotonic() < deadline:
        if not any(_belongs(process, group) for process in Path("/proc").glob("[0-9]*")):
            return True
        time.sleep(0.01)
    return False


def _belongs(process: Path, group: int) -> bool:
    try:
        # proc(5), stat: after the name in parentheses come state, parent and process group.
        state, _, pgrp = (process / "stat").read_text().rpartition(")")[2].split()[:3]
    except OSError:
        return False
    return int(pgrp) == group and state != "Z"


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory) -> Results:
    """The results of a quick run that nobody disturbed."""
    path = tmp_path_factory.mktemp("undisturbed") / "results.sqlite"
    finish(path, "--quick")
    return read(path)


def test_killed_at_random_moments_it_ends_as_if_it_had_not_been(tmp_path):
    path, other = tmp_path / "results.sqlite", tmp_path / "undisturbed.sqlite"
    began = time.monotonic()
    finish(other)
    seconds = time.monotonic() - began
    moments = random.Random(SEED)
    for _ in range(KILLS):
        run = start(path)
        time.sleep(moments.uniform(0, seconds))
        os.killpg(run.pid, signal.SIGKILL)
        run.communicate()
    finish(path)
    assert differences(read(path), read(other)) == []


def test_a_killed_run_leaves_its_rows_and_no_process(tmp_path, undisturbed):
    path = tmp_path / "results.sqlite"
    run = start(path, "--quick")
    wait_for_rows(path, 10)
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
    wait_for_rows(path, 5)
    for worker in _children(run.pid):
        os.kill(worker, signal.SIGKILL)
    run.communicate()
    assert run.returncode == 0
    assert differences(read(path), undisturbed) == []


def _children(parent: int) -> list[int]:
    """Its workers, each a child of one of its threads."""
    threads = Path(f"/proc/{parent}/task").iterdir()
    return [int(child) for thread in threads for child in _listed(thread / "children")]


def _listed(children: Path) -> list[str]:
    return children.read_text().split()


@pytest.mark.parametrize("rows", [0, 5])
def test_ctrl_c_ends_it_with_130_one_line_and_no_process(tmp_path, rows):
    path = tmp_path / "results.sqlite"
    run = start(path, "--quick")
    wait_for_rows(path, rows)
    if not rows:
        while not path.exists():
            time.sleep(0.01)
    # As a terminal does: to every process of the group.
    os.killpg(run.pid, signal.SIGINT)
    began = time.monotonic()
    out, err = run.communicate()
    assert time.monotonic() - began < PATIENCE
    assert (run.returncode, out) == (130, "")
    assert "the same command goes on from there" in err.splitlines()[-1]
    assert [line for line in err.splitlines() if not line.startswith("[")] == err.splitlines()[-1:]
    assert gone(run.pid)


def test_a_second_run_into_the_same_file_is_refused(tmp_path, undisturbed):
    path = tmp_path / "results.sqlite"
    first = start(path, "--quick")
    wait_for_rows(path, 1)
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
