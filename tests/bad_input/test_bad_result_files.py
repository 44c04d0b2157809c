"""Result files that are none, or were damaged, or cannot be written: one message, exit code 2."""

import os
import resource
import shutil
import sqlite3
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import pytest
from mutated_scenes import LEAST, written
from spincheck.reports.cli import running
from spincheck.reports.cli.app import app
from spincheck.reports.cli.terminal import BAD_INPUT, Complaint
from spincheck.reports.results.result_file import APPLICATION_ID, FORMAT
from typer.testing import CliRunner

COMMAND = Path(sys.executable).with_name("spincheck")
#: A file is cut at this many places, and damaged at as many.
STRIDES = 20
READERS = (["rows"], ["verdicts"], ["report", "--out", "pages"], ["compare"])
#: Nothing that a record holds may be any of these.
DAMAGE = {
    "half JSON": "{",
    "other JSON": "[1]",
    "text": "x",
    "bytes": b"\x00\xff",
    "half an archive": b"PK\x03\x04",
    "another folder": "../../evil",
    "markup": '\x1b[31m<b>&"',
    "huge": 1e308,
    "negative": -1,
}


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    """What a study of one scene leaves."""
    folder = tmp_path_factory.mktemp("good")
    (folder / "made.toml").write_text(written(LEAST))
    out = folder / "good.sqlite"
    running.run([str(folder / "made.toml")], ["mujoco"], ["RK4"], [], 1, out, quick=True)
    return out


def read_by(command: list[str], path: Path) -> str:
    """What a command complains of when it is given a file; empty if of nothing."""
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
    """Whatever a command writes it writes here."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("command", READERS, ids=lambda command: command[0])
def test_a_whole_file_is_read(good, elsewhere, command):
    assert read_by(command, good) == ""


@pytest.mark.parametrize("part", range(STRIDES))
def test_a_file_that_was_cut_is_told(good, elsewhere, part):
    content = good.read_bytes()
    path = elsewhere / "cut.sqlite"
    path.write_bytes(content[: part * len(content) // STRIDES])
    assert read_by(["rows"], path)


@pytest.mark.parametrize("part", range(STRIDES))
def test_a_page_overwritten_is_told_or_holds_nothing(good, elsewhere, part):
    content = bytearray(good.read_bytes())
    page = 4096
    place = (part * len(content) // STRIDES) // page * page
    content[place : place + page] = b"\xa5" * page
    path = elsewhere / "overwritten.sqlite"
    path.write_bytes(content)
    said = read_by(["report", "--out", "pages"], path)
    assert said or read_by(["rows"], path) == ""


def columns(path: Path) -> list[tuple[str, str]]:
    with closing(sqlite3.connect(path)) as connection:
        names = connection.execute("SELECT name FROM sqlite_master WHERE type = 'table'").fetchall()
        filled = [
            name
            for (name,) in names
            if connection.execute(f"SELECT count(*) FROM {name}").fetchone()[0]
        ]
        return [
            (name, row[1])
            for name in filled
            for row in connection.execute(f"PRAGMA table_info({name})")
        ]


def damage(path: Path, places: list[tuple[str, str]], value: object) -> None:
    """Put a value into columns, in the first record of each table."""
    with closing(sqlite3.connect(path)) as connection, connection:
        for table, column in places:
            connection.execute(
                f'UPDATE {table} SET "{column}" = ? WHERE rowid = (SELECT min(rowid) FROM {table})',
                (value,),
            )


def is_read(path: Path) -> bool:
    """Whether a file is read; otherwise it is complained of."""
    said = None
    try:
        running.read(path)
    except Complaint as complaint:
        said = complaint
    assert said is None or said.exit_code == BAD_INPUT
    assert said is None or (str(path) in str(said) and str(said).isprintable())
    return said is None


@pytest.mark.parametrize("value", DAMAGE.values(), ids=DAMAGE)
def test_a_damaged_record_is_told_or_reported_never_stumbled_upon(good, elsewhere, value):
    """What a reader lets pass, of whatever column, the report can be made of."""
    path = elsewhere / "damaged.sqlite"
    passed = []
    for place in columns(good):
        shutil.copy(good, path)
        damage(path, [place], value)
        if is_read(path):
            passed.append(place)
    shutil.copy(good, path)
    damage(path, passed, value)
    read_by(["report", "--out", "pages"], path)
    assert {entry.name for entry in elsewhere.iterdir()} <= {"damaged.sqlite", "pages"}
    assert len(passed) < len(columns(good))


def test_a_page_never_leaves_its_folder(good, elsewhere):
    """A name such as `../../evil` in the file is refused; the report is where it was asked for."""
    path = elsewhere / "evil.sqlite"
    shutil.copy(good, path)
    with closing(sqlite3.connect(path)) as connection, connection:
        for table in ("scenes", "rows", "verdicts"):
            connection.execute(f"UPDATE {table} SET scenario = '../../evil'")
    assert "'../../evil' is no scene's name" in read_by(["report", "--out", "pages"], path)


def foreign(path: Path, application: int, version: int) -> None:
    with closing(sqlite3.connect(path)) as connection, connection:
        connection.execute("CREATE TABLE rows (x)")
        connection.execute(f"PRAGMA application_id = {application}")
        connection.execute(f"PRAGMA user_version = {version}")


NOT_OURS = {
    "text": lambda path: path.write_text("scenario,engine\n" * 100),
    "binary": lambda path: path.write_bytes(bytes(range(256)) * 64),
    "another application's": lambda path: foreign(path, 0x12345678, 1),
    "of nobody": lambda path: foreign(path, 0, 0),
    "an older format": lambda path: foreign(path, APPLICATION_ID, FORMAT - 1),
    "a newer format": lambda path: foreign(path, APPLICATION_ID, FORMAT + 1),
    "a folder": lambda path: path.mkdir(),
    "a pipe": os.mkfifo,
    "a loop of links": lambda path: path.symlink_to(path),
}


@pytest.mark.parametrize("make", NOT_OURS.values(), ids=NOT_OURS)
def test_what_is_no_result_file_is_told_and_left_as_it_is(elsewhere, make):
    path = elsewhere / "other.sqlite"
    make(path)
    before = path.read_bytes() if path.is_file() else None
    (elsewhere / "made.toml").write_text(written(LEAST))
    for command in READERS:
        assert read_by(command, path)
    with pytest.raises(Complaint) as complaint:
        running.run(["made.toml"], ["mujoco"], ["RK4"], [], 1, path, quick=True)
    assert complaint.value.exit_code == BAD_INPUT
    assert before is None or path.read_bytes() == before


@pytest.mark.parametrize("name", ["nowhere/x.sqlite", "x" * 300, "a\nb\x1b[31m/x.sqlite"])
def test_a_place_that_cannot_be_is_one_line_without_escapes(tmp_path, name):
    (tmp_path / "made.toml").write_text(written(LEAST))
    done = subprocess.run(
        [COMMAND, "run", "made.toml", "--quick", "--out", name],
        cwd=tmp_path,
        capture_output=True,
        text=True,
    )
    assert done.returncode == BAD_INPUT
    assert len(done.stderr.splitlines()) == 1
    assert "\x1b" not in done.stderr


def test_a_file_held_by_another_program_is_told(good, elsewhere):
    path = elsewhere / "held.sqlite"
    shutil.copy(good, path)
    with closing(sqlite3.connect(path, isolation_level=None)) as other:
        other.execute("BEGIN EXCLUSIVE")
        assert "another program holds it" in read_by(["rows"], path)


def test_a_log_without_its_file_is_no_result(good, elsewhere):
    (elsewhere / "gone.sqlite-wal").write_bytes(b"\x37\x7f\x06\x82" + bytes(4096))
    assert "no such result file" in read_by(["rows"], elsewhere / "gone.sqlite")


def limited(folder: Path, size: int, *arguments: object) -> subprocess.CompletedProcess[str]:
    """Run the command where no file may grow beyond a size: the disk is full."""
    return subprocess.run(
        [COMMAND, *map(str, arguments)],
        cwd=folder,
        capture_output=True,
        text=True,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size)),
    )


@pytest.mark.parametrize("share", [0.3, 0.9])
def test_a_full_disk_costs_a_message_and_the_run_resumes(good, tmp_path, share):
    (tmp_path / "made.toml").write_text(written(LEAST))
    command = ("run", "made.toml", "--engine", "mujoco", "--method", "RK4", "--quick")
    size = int(share * good.stat().st_size)
    done = limited(tmp_path, size, *command, "--out", "full.sqlite")
    assert done.returncode == BAD_INPUT
    assert "the disk fails or is full" in done.stderr
    assert "Traceback" not in done.stderr
    again = subprocess.run(
        [COMMAND, *command, "--out", "full.sqlite"], cwd=tmp_path, capture_output=True, text=True
    )
    assert again.returncode == 0, again.stderr


def test_a_report_that_does_not_fit_is_told(good, tmp_path):
    done = limited(tmp_path, 10_000, "report", good, "--out", "pages")
    assert done.returncode == BAD_INPUT
    assert done.stderr == "spincheck: pages: cannot be written: File too large\n"


@pytest.mark.parametrize("where", ["/proc/nowhere", "taken"])
def test_a_report_has_to_have_a_folder(good, elsewhere, where):
    (elsewhere / "taken").write_text("a file")
    result = CliRunner().invoke(app, ["report", str(good), "--out", where])
    assert isinstance(result.exception, Complaint)
    assert str(result.exception).startswith(f"{where}: cannot be written: ")
