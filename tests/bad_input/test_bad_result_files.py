"""Damaged, foreign and unwritable result files give one message and exit code 2."""

import os
import resource
import shutil
import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from functools import partial
from pathlib import Path

import command_line
import pytest
from case_loops import each_case
from forging import columns, forge
from mutated_scenes import LEAST, written
from spincheck.reports.cli import choosing
from spincheck.reports.cli.app import app
from spincheck.reports.cli.run import running
from spincheck.reports.cli.terminal import AGREES, BAD_INPUT, Complaint
from spincheck.reports.harness.executors import InProcess
from spincheck.reports.results.result_file import APPLICATION_ID, FORMAT
from typer.testing import CliRunner

pytestmark = pytest.mark.slow

#: Bytes of a file that fit on a full disk: an empty result file has less, a full one more.
FULL = 100_000
#: A file is cut at this many places, and damaged at as many.
STRIDES = 8
READERS = (["rows"], ["report", "--out", "pages"], ["compare"])
#: Nothing that a record holds may be any of these.
DAMAGE = {
    "half JSON": "{",
    "other JSON": "[1]",
    "bytes": b"PK\x03\x04\x00\xff",
    "another folder": "../../evil",
    "markup": '\x1b[31m<b>&"',
    "huge": 1e308,
    "negative": -1,
}


def read_by(command: list[str], path: Path) -> str:
    """The complaint of a command about a file; empty if there is none."""
    first = [str(path)] if command[0] != "compare" else [str(path), str(path)]
    result = CliRunner().invoke(app, [command[0], *first, *command[1:]])
    if isinstance(result.exception, Complaint):
        assert result.exception.exit_code == BAD_INPUT
        assert str(path) in str(result.exception)
        assert "\n" not in str(result.exception)
        return str(result.exception)
    if not isinstance(result.exception, SystemExit | None):
        raise result.exception
    return ""


@pytest.fixture
def elsewhere(tmp_path, monkeypatch):
    """A folder in which commands write their files."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("command", READERS, ids=lambda command: command[0])
def test_a_whole_file_is_read(good, elsewhere, command):
    assert read_by(command, good) == ""


@each_case("part", range(STRIDES))
def test_a_file_that_was_cut_is_reported(good, elsewhere, part):
    content = good.read_bytes()
    path = elsewhere / "cut.sqlite"
    path.write_bytes(content[: part * len(content) // STRIDES])
    assert read_by(["rows"], path)


@each_case("part", range(STRIDES))
def test_a_page_overwritten_is_reported_or_holds_nothing(good, elsewhere, part):
    content = bytearray(good.read_bytes())
    page = 4096
    place = (part * len(content) // STRIDES) // page * page
    content[place : place + page] = b"\xa5" * page
    path = elsewhere / "overwritten.sqlite"
    path.write_bytes(content)
    message = read_by(["report", "--out", "pages"], path)
    assert message or read_by(["rows"], path) == ""


def is_read(path: Path) -> bool:
    """Whether a file can be read; if not, there must be a complaint."""
    refusal = None
    try:
        running.read(path)
    except Complaint as complaint:
        refusal = complaint
    assert refusal is None or refusal.exit_code == BAD_INPUT
    assert refusal is None or (str(path) in str(refusal) and str(refusal).isprintable())
    return refusal is None


@pytest.mark.parametrize("value", DAMAGE.values(), ids=DAMAGE)
def test_a_damaged_record_is_reported_never_stumbled_upon(good, elsewhere, value):
    """If the reader accepts a changed column, the report can be made."""
    path = elsewhere / "damaged.sqlite"
    passed = []
    for place in columns(good):
        shutil.copy(good, path)
        forge(path, [place], value)
        if is_read(path):
            passed.append(place)
    shutil.copy(good, path)
    forge(path, passed, value)
    read_by(["report", "--out", "pages"], path)
    assert {entry.name for entry in elsewhere.iterdir()} <= {"damaged.sqlite", "pages"}
    assert len(passed) < len(columns(good))


def foreign(path: Path, application: int, version: int) -> None:
    with closing(sqlite3.connect(path)) as connection, connection:
        connection.execute("CREATE TABLE rows (x)")
        connection.execute(f"PRAGMA application_id = {application}")
        connection.execute(f"PRAGMA user_version = {version}")


#: What makes each, and words of the complaint.
NOT_OURS = {
    "text": (lambda path: path.write_text("scenario,engine\n" * 100), "not a usable result file"),
    "binary": (lambda path: path.write_bytes(bytes(range(256)) * 64), "not a usable result file"),
    "another application's": (lambda path: foreign(path, 0x12345678, 1), "of spincheck"),
    "of nobody": (lambda path: foreign(path, 0, 0), "not a result file of spincheck"),
    "an older format": (
        lambda path: foreign(path, APPLICATION_ID, FORMAT - 1),
        f"format {FORMAT - 1}, this version has format {FORMAT}: move it away, and start that",
    ),
    "a newer format": (
        *(lambda path: foreign(path, APPLICATION_ID, FORMAT + 1), f"format {FORMAT + 1}"),
    ),
    "a folder": (lambda path: path.mkdir(), "cannot be read: it is a folder"),
    "a pipe": (os.mkfifo, ""),
    "a loop of links": (lambda path: path.symlink_to(path), ""),
}


@pytest.mark.parametrize(("make", "words"), NOT_OURS.values(), ids=NOT_OURS)
def test_what_is_no_result_file_is_reported_and_left_as_it_is(elsewhere, make, words):
    path = elsewhere / "other.sqlite"
    make(path)
    before = path.read_bytes() if path.is_file() else None
    (elsewhere / "made.toml").write_text(written(LEAST))
    for command in READERS:
        complaint = read_by(command, path)
        assert complaint
        assert words in complaint
    with pytest.raises(Complaint) as complaint:
        running.run(["made.toml"], ["mujoco"], ["RK4"], [], 1, path, quick=True)
    assert complaint.value.exit_code == BAD_INPUT
    assert before is None or path.read_bytes() == before


@pytest.mark.parametrize("name", ["nowhere/x.sqlite", "x" * 300, "a\nb\x1b[31m/x.sqlite"])
def test_a_place_that_cannot_be_is_one_line_without_escapes(elsewhere, name):
    (elsewhere / "made.toml").write_text(written(LEAST))
    done = command_line.spincheck("run", "made.toml", "--quick", "--out", name)
    assert done.returncode == BAD_INPUT
    assert len(done.stderr.splitlines()) == 1
    assert "\x1b" not in done.stderr


def test_a_file_held_by_another_program_is_reported(good, elsewhere, monkeypatch):
    path = elsewhere / "held.sqlite"
    shutil.copy(good, path)
    with closing(sqlite3.connect(path, isolation_level=None)) as other:
        other.execute("BEGIN EXCLUSIVE")
        monkeypatch.setattr(sqlite3, "connect", partial(sqlite3.connect, timeout=0.1))
        assert "another program has locked it" in read_by(["rows"], path)


def test_a_log_without_its_file_is_no_result(good, elsewhere):
    (elsewhere / "gone.sqlite-wal").write_bytes(b"\x37\x7f\x06\x82" + bytes(4096))
    assert "no such result file" in read_by(["rows"], elsewhere / "gone.sqlite")


@contextmanager
def full_disk(size: int) -> Iterator[None]:
    """No file may grow beyond a size."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


@pytest.mark.parametrize("size", [4_000, FULL], ids=["begun", "first rows"])
def test_a_full_disk_costs_a_message_and_the_run_resumes(elsewhere, monkeypatch, size):
    monkeypatch.setattr(choosing, "LocalWorkers", lambda *_: InProcess())
    (elsewhere / "made.toml").write_text(written(LEAST))
    command = ("run", "made.toml", "--engine", "mujoco", "--method", "RK4", "--quick")
    with full_disk(size):
        done = command_line.spincheck(*command, "--out", "full.sqlite")
    assert done.returncode == BAD_INPUT
    assert done.stderr.endswith("the disk fails or is full\n")
    assert command_line.spincheck(*command, "--out", "full.sqlite").returncode == AGREES


def test_a_report_that_does_not_fit_is_reported(good, elsewhere):
    with full_disk(FULL):
        done = command_line.spincheck("report", str(good), "--out", "pages")
    assert done.returncode == BAD_INPUT
    assert done.stderr == "spincheck: pages: cannot be written: File too large\n"


@pytest.mark.parametrize("where", ["/proc/nowhere", "taken"])
def test_a_report_has_to_have_a_folder(good, elsewhere, where):
    (elsewhere / "taken").write_text("a file")
    result = CliRunner().invoke(app, ["report", str(good), "--out", where])
    assert isinstance(result.exception, Complaint)
    assert str(result.exception).startswith(f"{where}: cannot be written: ")
