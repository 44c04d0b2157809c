"""Result files of an earlier spincheck are refused, with what to do, and left as they are."""

import sqlite3
from contextlib import closing

import command_line
import pytest
import small_result_file
from spincheck.reports.cli.terminal import BAD_INPUT
from spincheck.reports.results.result_file import FORMAT


@pytest.fixture
def old(tmp_path):
    path = small_result_file.write(tmp_path / "old.sqlite")
    with closing(sqlite3.connect(path)) as connection:
        connection.execute(f"PRAGMA user_version = {FORMAT - 1}")
    return path


@pytest.mark.parametrize("command", ["rows", "report", "compare", "run"])
def test_every_command_says_what_to_do_in_one_line(old, command):
    before = old.read_bytes()
    files = {"compare": [str(old)] * 2, "run": ["fast-top", "--out", str(old)]}
    done = command_line.spincheck(command, *files.get(command, [str(old)]), cwd=old.parent)
    assert (done.returncode, done.stdout, len(done.stderr.splitlines())) == (BAD_INPUT, "", 1)
    for words in (f"format {FORMAT - 1}", f"has format {FORMAT}", "move it away", "spincheck run"):
        assert words in done.stderr
    assert old.read_bytes() == before
