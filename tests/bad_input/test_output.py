"""Output that cannot be written, and signals that arrive while Python cannot handle them."""

import errno
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
import tomllib
from io import StringIO

import command_line
import pytest
from case_loops import each_case
from default_signals import WITH_DEFAULT_SIGNALS
from library_scenes import library_scene
from spincheck.engines import engines
from spincheck.reports.cli import choosing, terminal
from spincheck.reports.cli.stopping import ENDING, HEARING
from spincheck.reports.cli.terminal import AGREES, BAD_INPUT, NOT_RUN, to_json

pytestmark = pytest.mark.processes

#: The command line as its script has it.
SPINCHECK = (
    "import sys; from spincheck.reports.cli.app import main; sys.argv[0] = 'spincheck'; main()"
)
#: Programs that print "begun" and then run for ever: native code, an import, code that catches all.
ENDLESS = {
    "a query": """
import sqlite3
def run():
    print("begun", flush=True)
    sqlite3.connect(":memory:").execute(
        "WITH RECURSIVE n(x) AS (SELECT 1 UNION ALL SELECT 1 FROM n) SELECT count(*) FROM n"
    ).fetchall()
""",
    "an import": """
import importlib.util, sys
from pathlib import Path
def run():
    Path("endless.py").write_text("print('begun', flush=True)\\nwhile True: pass\\n")
    sys.path.insert(0, "")
    # As numpy does with half of itself: another error comes of it.
    try:
        import endless
    except BaseException as error:
        raise RecursionError from error
""",
    "what lets nothing through": """
def run():
    print("begun", flush=True)
    while True:
        try:
            while True:
                pass
        except BaseException:
            pass
""",
}
PROGRAM = """
from spincheck.reports.cli import app
app.app = run
app.main()
"""
#: s; of a machine that is busy with other things.
PATIENCE = 10 * (HEARING + ENDING)


def shell(redirected: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    """A command with its output redirected as a shell does."""
    return subprocess.run(
        ["sh", "-c", f'exec "$0" -c "$@" {redirected}', sys.executable, SPINCHECK, *arguments],
        capture_output=True,
        text=True,
    )


def test_output_to_a_full_disk_is_reported():
    done = shell(">/dev/full", "list", "--json")
    assert done.returncode == NOT_RUN
    assert done.stderr == "spincheck: the output cannot be written: No space left on device\n"


def test_messages_to_a_full_disk_stop_nothing():
    done = shell("2>/dev/full", "show", "nowhere")
    assert (done.returncode, done.stdout, done.stderr) == (BAD_INPUT, "", "")


def test_streams_that_are_closed_are_survived():
    done = shell("<&- >&- 2>&-", "list")
    assert (done.returncode, done.stdout, done.stderr) == (AGREES, "", "")


@pytest.mark.parametrize("words", [["list", "--json"], ["list", "hard"]], ids=["long", "short"])
def test_a_pipe_that_nobody_reads_is_no_traceback(words):
    reading, writing = os.pipe()
    os.close(reading)
    try:
        command = [sys.executable, "-c", SPINCHECK, *words]
        done = subprocess.run(command, stdout=writing, stderr=subprocess.PIPE, text=True)
    finally:
        os.close(writing)
    assert (done.returncode, done.stderr) == (NOT_RUN, "")


@pytest.mark.parametrize(
    ("kind", "number"),
    [*((kind, signal.SIGTERM) for kind in ENDLESS), ("what lets nothing through", signal.SIGINT)],
)
def test_a_signal_is_obeyed_whatever_never_ends(tmp_path, kind, number):
    run = subprocess.Popen(
        [*WITH_DEFAULT_SIGNALS, sys.executable, "-c", ENDLESS[kind] + PROGRAM],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert run.stdout
    assert run.stdout.readline() == "begun\n"
    # Then it is under way, as a rule.
    time.sleep(0.1)
    run.send_signal(number)
    began = time.monotonic()
    try:
        _, err = run.communicate(timeout=PATIENCE)
    finally:
        run.kill()
    assert time.monotonic() - began < PATIENCE
    assert (run.returncode, err) == (128 + number, f"spincheck: stopped by {number.name}\n")


def test_a_signal_before_the_first_word_is_no_traceback():
    """While the command line itself is still being imported."""
    program = """
import os, signal
from spincheck.reports.cli import start
signal.signal(signal.SIGINT, signal.default_int_handler)
import sys
class Importing:
    def find_spec(self, name, *_):
        if name.endswith("cli.app"):
            os.kill(os.getpid(), signal.SIGINT)
sys.meta_path.insert(0, Importing())
start.main()
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (-signal.SIGINT, "")


def test_json_escapes_what_commands_a_terminal_and_reads_back_the_same():
    text = "a\x1b[2J\x9b31m\u202e\u00e9\nb"
    printed = to_json({text: [text]})
    assert not {"\x1b", "\x9b", "\u202e"} & set(printed)
    assert "\u00e9" in printed
    assert json.loads(printed) == {text: [text]}


@pytest.mark.parametrize("form", ["--json", "--toml"])
def test_what_a_program_reads_is_read_whatever_the_encoding_of_the_output(tmp_path, form):
    text = library_scene("fast-top").text
    source = tomllib.loads(text)["source"]
    (tmp_path / "top.toml").write_text(text.replace(source, f"{source} é\u0101"), encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-c", SPINCHECK, "show", "top.toml", form],
        cwd=tmp_path,
        env=os.environ | {"PYTHONIOENCODING": "ascii"},
        capture_output=True,
        encoding="utf-8",
        check=True,
    )
    read = (json if form == "--json" else tomllib).loads(done.stdout)
    assert read["source"] == f"{source} é\u0101"


@pytest.mark.parametrize("command", ["run", "recommend"])
def test_no_temporary_folder_is_reported_before_anything_is_run(tmp_path, monkeypatch, command):
    def none() -> str:
        raise FileNotFoundError(errno.ENOENT, "No usable temporary directory found in ['/tmp']")

    # Found once a process, and some use a temporary folder as they are imported.
    engines()
    monkeypatch.chdir(tmp_path)
    for module in (tempfile, choosing):
        monkeypatch.setattr(module, "gettempdir", none)
    options = ["--omega", "1e-3"] if command == "recommend" else ["--quick"]
    done = command_line.spincheck(command, "gazebo-box-tumbling", "--engine", "mujoco", *options)
    assert (done.returncode, done.stdout) == (NOT_RUN, "")
    assert done.stderr.endswith("'TMPDIR' names another\n")


#: Turns text about, cannot be seen, begins a file.
UNSEEN = ("\u202e", "\u200e", "\ufeff", "\u2066", "\u061c")


@each_case(
    ("words", "character"),
    [
        *((words, UNSEEN[0]) for words in (("show",), ("run", "--engine"), ("--",), ("report",))),
        *((("show",), character) for character in UNSEEN[1:]),
    ],
)
def test_no_message_turns_text_about(words, character, tmp_path):
    """Nor those that the libraries of the command line print themselves."""
    name = f"evil{character}.toml"
    (tmp_path / name).write_text("spincheck = 1")
    done = command_line.spincheck(*words, name, cwd=tmp_path)
    assert done.returncode == BAD_INPUT
    assert "evil" in done.stderr
    assert character not in done.stdout + done.stderr


def test_tables_of_a_terminal_are_drawn(capsys):
    stream = StringIO()
    terminal.escape_what_turns_text(stream)
    print("\x1b[1mθ\x1b[0m \u202etop", file=stream)
    assert stream.getvalue() == "\x1b[1mθ\x1b[0m \\u202etop\n"


IN_A_DELETED_FOLDER = """
import os, sys
os.rmdir(os.getcwd())
from spincheck.reports.cli.app import main
for words in {commands}:
    sys.argv = ["spincheck", *words]
    try:
        main()
    except SystemExit as end:
        assert end.code in {codes}, (words, end.code)
"""


def test_a_current_folder_that_was_deleted_is_no_traceback(tmp_path):
    (tmp_path / "gone").mkdir()
    commands = [(name, "robot.urdf") for name in ("inspect", "import", "run", "check", "new")]
    commands += [("report",), ("list",)]
    program = IN_A_DELETED_FOLDER.format(commands=commands, codes=(AGREES, BAD_INPUT, NOT_RUN))
    done = subprocess.run(
        [sys.executable, "-c", program],
        cwd=tmp_path / "gone",
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, "Traceback" in done.stderr) == (0, False), done.stderr
