"""Ctrl-C, SIGTERM and a terminal that closes end every command at once: one line, no process."""

import os
import pty
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest
import small_result_file
from command_line import spincheck
from default_signals import WITH_DEFAULT_SIGNALS
from kills import COMMAND, PATIENCE, STUDY, is_gone, read, start
from result_files import rows_in, wait_for_rows

pytestmark = pytest.mark.processes

#: One call of the engine that takes minutes: s, and so many steps from sample to sample.
TINY = "1e-10"
#: A report that never ends, and says when it has begun.
RENDERING = """
import sys
from spincheck.reports.cli import app as cli
from spincheck.reports.pages import render
def forever(*_):
    print("begun", flush=True)
    while True:
        pass
render._write_scenes = forever
sys.argv[0] = "spincheck"
cli.main()
"""


Phase = Callable[[subprocess.Popen[str], Path], None]


def begun(run: subprocess.Popen[str], path: Path) -> None:
    while not path.exists():
        assert run.poll() is None, run.communicate()
        time.sleep(0.01)


def solved(run: subprocess.Popen[str], path: Path) -> None:
    wait_for_rows(run, path, 1, "scenes")


def stop(run: subprocess.Popen[str], number: signal.Signals) -> list[str]:
    """Send a signal as a terminal does, to the whole group; returns the lines on stderr."""
    os.killpg(run.pid, number)
    _, err = run.communicate()
    assert run.returncode == 128 + number
    assert is_gone(run.pid)
    return [line for line in err.splitlines() if not line.startswith("[")]


def stop_run(run: subprocess.Popen[str], path: Path, number: signal.Signals) -> None:
    messages = [line for line in stop(run, number) if line.startswith("spincheck: ")]
    assert messages == [
        f"spincheck: stopped by {number.name}; finished results are in {path}; "
        "the same command continues from there"
    ]


@pytest.mark.parametrize(
    ("phase", "options"),
    [(begun, ()), (solved, ("--timestep", TINY))],
    ids=["solving", "in-a-long-call"],
)
def test_a_run_is_stopped(path: Path, phase: Phase, options: tuple[str, ...]) -> None:
    run = start(path, *options)
    phase(run, path)
    stop_run(run, path, signal.SIGINT)


def close_the_terminal(path: Path) -> None:
    """Of a run with some results."""
    ours, theirs = pty.openpty()
    run = subprocess.Popen(
        [*WITH_DEFAULT_SIGNALS, COMMAND, "run", *STUDY, "--jobs", "1", "--out", path],
        stdin=theirs,
        stdout=theirs,
        stderr=theirs,
        start_new_session=True,
    )
    os.close(theirs)
    os.set_blocking(ours, False)
    while rows_in(path) < 3:
        assert run.poll() is None
        with suppress(BlockingIOError):
            # Somebody reads it, so far.
            os.read(ours, 1 << 16)
        time.sleep(0.01)
    os.close(ours)
    assert run.wait(PATIENCE) == 128 + signal.SIGHUP
    assert is_gone(run.pid)
    assert rows_in(path) >= 3


def test_a_run_whose_terminal_closes_and_one_stopped_while_timing_are_gone_on_with(
    path: Path,
) -> None:
    close_the_terminal(path)
    run = start(path)
    wait_for_rows(run, path, 2, "verdicts")
    stop_run(run, path, signal.SIGTERM)
    # In this process.
    assert spincheck("run", *STUDY, "--out", path).returncode == 0
    results = read(path)
    assert {verdict.verdict for verdict in results.verdicts} == {"converges"}
    assert None not in {row.seconds_per_step for row in results.rows if row.outcome == "ok"}


def test_a_report_being_made_is_stopped(path: Path) -> None:
    small_result_file.write(path)
    command = [sys.executable, "-c", RENDERING, "report", path, "--out", path.with_name("report")]
    report = subprocess.Popen(
        [*WITH_DEFAULT_SIGNALS, *command],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    assert report.stdout
    assert report.stdout.readline() == "begun\n"
    assert stop(report, signal.SIGINT) == ["spincheck: stopped by SIGINT"]


def test_what_is_to_survive_its_terminal_does(path: Path) -> None:
    """As nohup has it: who ignores a signal goes on ignoring it."""
    command = [COMMAND, "run", *STUDY, "--quick", "--jobs", "1", "--out", path]
    run = subprocess.Popen(
        ["nohup", *map(str, command)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    wait_for_rows(run, path, 1)
    run.send_signal(signal.SIGHUP)
    wait_for_rows(run, path, 3)
    run.terminate()
    run.communicate()
    assert run.returncode == 128 + signal.SIGTERM
