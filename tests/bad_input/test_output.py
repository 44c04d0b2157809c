"""Where output cannot go, and signals that come while Python does not listen."""

import errno
import os
import signal
import subprocess
import sys
import tempfile
import time

import command_line
import pytest
from mutated_scenes import LEAST, written
from spincheck.reports.cli import executing
from spincheck.reports.cli.stopping import HEARING
from spincheck.reports.cli.terminal import AGREES, BAD_INPUT, NOT_RUN

pytestmark = pytest.mark.processes

#: The command line as its script has it.
SPINCHECK = (
    "import sys; from spincheck.reports.cli.app import main; sys.argv[0] = 'spincheck'; main()"
)
#: One call into C that never ends, as a query of a stranger's file may be.
QUERYING = """
import sqlite3, sys
from spincheck.reports.cli.stopping import Stopped, raise_when_stopped
raise_when_stopped()
try:
    print("begun", flush=True)
    sqlite3.connect(":memory:").execute(
        "WITH RECURSIVE n(x) AS (SELECT 1 UNION ALL SELECT 1 FROM n) SELECT count(*) FROM n"
    ).fetchall()
except Stopped as stopped:
    # It came before the query.
    print(f"spincheck: {stopped}", file=sys.stderr)
    sys.exit(stopped.exit_code)
"""
#: s; of a machine that is busy with other things.
PATIENCE = 20 * HEARING


def shell(redirected: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    """A command with its output redirected as a shell does."""
    return subprocess.run(
        ["sh", "-c", f'exec "$0" -c "$@" {redirected}', sys.executable, SPINCHECK, *arguments],
        capture_output=True,
        text=True,
    )


def test_output_to_a_full_disk_is_told():
    done = shell(">/dev/full", "list", "--json")
    assert done.returncode == NOT_RUN
    assert done.stderr == "spincheck: the output cannot be written: No space left on device\n"


def test_messages_to_a_full_disk_stop_nothing():
    done = shell("2>/dev/full", "show", "nowhere")
    assert (done.returncode, done.stdout, done.stderr) == (BAD_INPUT, "", "")


def test_streams_that_are_closed_are_survived():
    done = shell("<&- >&- 2>&-", "list")
    assert (done.returncode, done.stdout, done.stderr) == (AGREES, "", "")


def test_a_pipe_that_nobody_reads_is_no_traceback():
    reading, writing = os.pipe()
    os.close(reading)
    try:
        command = [sys.executable, "-c", SPINCHECK, "list", "--json"]
        done = subprocess.run(command, stdout=writing, stderr=subprocess.PIPE, text=True)
    finally:
        os.close(writing)
    assert done.stderr == ""


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_is_obeyed_during_a_call_that_never_ends(number):
    run = subprocess.Popen(
        [sys.executable, "-c", QUERYING],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        # However this process was started, as from a script in the background.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    assert run.stdout
    assert run.stdout.readline() == "begun\n"
    # Then the query is under way, as a rule.
    time.sleep(HEARING)
    run.send_signal(number)
    began = time.monotonic()
    try:
        _, err = run.communicate(timeout=PATIENCE)
    finally:
        run.kill()
    assert time.monotonic() - began < PATIENCE
    assert (run.returncode, err) == (128 + number, f"spincheck: stopped by {number.name}\n")


def test_two_scenes_of_one_name_are_told(tmp_path):
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "made.toml").write_text(written(LEAST))
    done = command_line.spincheck("check", str(tmp_path))
    assert (done.returncode, done.stdout) == (BAD_INPUT, "")
    assert "another scene has the same name" in done.stderr


@pytest.mark.parametrize("command", ["run", "recommend"])
def test_no_temporary_folder_is_told_before_anything_is_run(tmp_path, monkeypatch, command):
    def none() -> str:
        raise FileNotFoundError(errno.ENOENT, "No usable temporary directory found in ['/tmp']")

    monkeypatch.chdir(tmp_path)
    for module in (tempfile, executing):
        monkeypatch.setattr(module, "gettempdir", none)
    options = ["--omega", "1e-3"] if command == "recommend" else ["--quick"]
    done = command_line.spincheck(command, "gazebo-box-tumbling", "--engine", "mujoco", *options)
    assert (done.returncode, done.stdout) == (NOT_RUN, "")
    assert done.stderr.endswith("'TMPDIR' names another\n")
