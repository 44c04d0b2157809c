"""Result files that an earlier spincheck wrote can be read, and only read."""

import sqlite3
from contextlib import closing
from dataclasses import fields, is_dataclass, replace
from pathlib import Path

import command_line
import numpy as np
import pytest
import small_result_file
from spincheck.engines.engine import COMMON_EFFECTS
from spincheck.reports.cli.terminal import BAD_INPUT
from spincheck.reports.results.result_file import APPLICATION_ID, ResultFileError
from spincheck.reports.results.store import Results, open_store

#: What `small_result_file.write` wrote with the last program of that format, as `.dump` prints it.
DUMP = Path(__file__).with_name("format_12.sql")
#: Added to records since: absent from such a file; and the effects that there were.
ABSENT_FROM_METHODS = {
    "by_angles": False,
    "damping": 0.0,
    "setup": "",
    "effects": COMMON_EFFECTS,
}
ABSENT_FROM_VERDICTS = {"ground": ""}


@pytest.fixture
def old(tmp_path) -> Path:
    path = tmp_path / "old.sqlite"
    with closing(sqlite3.connect(path)) as connection:
        connection.executescript(DUMP.read_text(encoding="utf-8"))
        connection.executescript(
            f"PRAGMA application_id = {APPLICATION_ID}; PRAGMA user_version = 12;"
        )
    return path


def read(path: Path) -> Results:
    with open_store(path) as store:
        return store.read()


def same(a: object, b: object) -> bool:
    if isinstance(a, np.ndarray):
        return np.array_equal(a, b)
    if isinstance(a, list | tuple):
        return len(a) == len(b) and all(map(same, a, b))
    if isinstance(a, dict):
        return list(a) == list(b) and all(same(a[name], b[name]) for name in a)
    if is_dataclass(a):
        return all(same(getattr(a, f.name), getattr(b, f.name)) for f in fields(a))
    return a == b


def test_a_file_of_format_12_holds_what_was_written(old, tmp_path):
    before, now = read(old), read(small_result_file.write(tmp_path / "new.sqlite"))
    now = replace(
        now,
        methods={n: replace(m, **ABSENT_FROM_METHODS) for n, m in now.methods.items()},
        verdicts=[replace(verdict, **ABSENT_FROM_VERDICTS) for verdict in now.verdicts],
    )
    assert [name for name in vars(now) if not same(vars(before)[name], vars(now)[name])] == []
    assert before.rows[0].seconds_per_step is not None


@pytest.mark.parametrize("command", ["rows", "verdicts", "points", "report", "compare"])
def test_every_command_that_reads_takes_it(old, tmp_path, monkeypatch, command):
    monkeypatch.chdir(tmp_path)
    files = [old.name] * (2 if command == "compare" else 1)
    done = command_line.spincheck(command, *files)
    assert (done.returncode != BAD_INPUT, done.stdout != "", done.stderr) == (True, True, "")


def test_it_is_not_written_to(old):
    before = old.read_bytes()
    with (
        pytest.raises(ResultFileError, match="format 12, this version continues 13"),
        open_store(old, create=True),
    ):
        pass
    assert old.read_bytes() == before


def test_a_number_that_was_changed_in_it_is_reported(old):
    with closing(sqlite3.connect(old)) as connection, connection:
        connection.execute("UPDATE rows SET steps = steps + 1")
    with pytest.raises(ResultFileError, match="changed after it was written"):
        read(old)


def test_damage_in_it_is_one_message(old, monkeypatch):
    monkeypatch.chdir(old.parent)
    with closing(sqlite3.connect(old)) as connection, connection:
        connection.execute("UPDATE rows SET motion = x'00'")
    done = command_line.spincheck("rows", old.name)
    assert (done.returncode, len(done.stderr.splitlines())) == (BAD_INPUT, 1)
