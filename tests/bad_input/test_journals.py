"""What a stranger lays beside a result file: nothing else is deleted, written to or waited for."""

import os
import shutil
import sqlite3
import struct
from contextlib import closing
from pathlib import Path

import command_line
import pytest
from spincheck.reports.cli.terminal import BAD_INPUT
from spincheck.reports.results.result_file import ResultFileError
from spincheck.reports.results.store import open_store

SUFFIXES = ("-journal", "-wal", "-shm")
#: sqlite.org/fileformat2.html: begins a journal, and ends the name of a super-journal.
MAGIC = bytes.fromhex("d9d505f920a163d7")
#: The page that is locked, where no content may be: at 2³⁰ bytes.
LOCK_PAGE = (1 << 30) // 4096 + 1


@pytest.fixture
def path(good, tmp_path):
    return Path(shutil.copy(good, tmp_path / "sent.sqlite"))


def beside(path: Path, suffix: str) -> Path:
    return path.with_name(path.name + suffix)


def half_written(path: Path) -> bytes:
    """The journal of a transaction that was killed."""
    with closing(sqlite3.connect(path)) as connection:
        # More than is kept in memory: the journal is on the disk.
        connection.execute("PRAGMA cache_size = 1")
        connection.execute("BEGIN IMMEDIATE")
        connection.execute("UPDATE file SET commits = commits + 1")
        connection.execute("UPDATE rows SET record = record || ' '")
        return beside(path, "-journal").read_bytes()


def naming(file: Path) -> bytes:
    """The end of the journal of a transaction over attached databases."""
    name = os.fsencode(file)
    ends = struct.pack(f">I{len(name)}sII", LOCK_PAGE, name, len(name), sum(name))
    return ends + MAGIC


def refused(path: Path, *, writing: bool) -> str:
    with (
        pytest.raises(ResultFileError) as complaint,
        open_store(path, create=writing) as store,
    ):
        store.read()
    (line,) = str(complaint.value).splitlines()
    return line


@pytest.mark.parametrize("writing", [False, True], ids=["read", "written"])
def test_a_journal_that_names_another_file_deletes_nothing(path, tmp_path, writing):
    letters = tmp_path / "letters.txt"
    letters.write_text("kept")
    beside(path, "-journal").write_bytes(half_written(path) + naming(letters))
    before = path.read_bytes()
    assert "names another file, which SQLite would delete" in refused(path, writing=writing)
    assert letters.read_text() == "kept"
    assert path.read_bytes() == before


def test_a_journal_of_a_killed_run_is_undone_by_the_next_and_reported_until_then(path):
    with open_store(path) as store:
        before = store.read().environment
    beside(path, "-journal").write_bytes(half_written(path))
    done = command_line.spincheck("rows", path)
    assert done.returncode == BAD_INPUT
    assert "a run was killed while it wrote to it" in done.stderr
    with open_store(path, create=True) as store:
        assert store.read().environment == before


@pytest.mark.parametrize("writing", [False, True], ids=["read", "written"])
@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("kind", ["a pipe", "a folder", "a link", "a second name"])
def test_what_lies_beside_it_is_neither_followed_nor_waited_for(
    path, tmp_path, suffix, kind, writing
):
    letters, laid = tmp_path / "letters.txt", beside(path, suffix)
    letters.write_text("kept" * 100)
    make = {
        "a pipe": os.mkfifo,
        "a folder": Path.mkdir,
        "a link": lambda place: place.symlink_to(letters),
        "a second name": lambda place: place.hardlink_to(letters),
    }
    make[kind](laid)
    expected = f"'sent.sqlite{suffix}' beside it must be a file of its own"
    assert expected in refused(path, writing=writing)
    assert letters.read_text() == "kept" * 100


@pytest.mark.parametrize("there", [False, True], ids=["nothing", "an empty file"])
def test_no_result_file_is_begun_through_a_link(tmp_path, there):
    elsewhere, path = tmp_path / "elsewhere", tmp_path / "new.sqlite"
    if there:
        elsewhere.touch()
    path.symlink_to(elsewhere)
    assert "it is a link to" in refused(path, writing=True)
    assert not elsewhere.exists() or elsewhere.read_bytes() == b""


def test_a_result_file_elsewhere_is_used_through_a_link_with_its_own_log(path, tmp_path):
    link = tmp_path / "link.sqlite"
    link.symlink_to(path)
    with open_store(link, create=True) as store:
        store.put_environment({"later": "through the link"})
        assert beside(path, "-wal").exists()
    with open_store(path) as store:
        assert store.read().environment["later"] == "through the link"
