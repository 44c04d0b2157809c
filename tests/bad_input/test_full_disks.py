"""Full and read-only disks, mounted for the test, are reported; later the run continues."""

import errno
import os
import tempfile
from contextlib import contextmanager
from pathlib import Path

import command_line
import pytest
import small_result_file
from mutated_scenes import LEAST, written
from small_disks import SmallDisk, small_disk
from spincheck.reports.cli import choosing
from spincheck.reports.cli.terminal import AGREES, BAD_INPUT
from spincheck.reports.harness.executors import InProcess
from spincheck.reports.results.store import open_store

STUDY = ("run", "made.toml", "--engine", "pybullet", "--method", "maximal", "--quick")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(choosing, "LocalWorkers", lambda *_: InProcess())
    (tmp_path / "made.toml").write_text(written(LEAST))
    return tmp_path


@contextmanager
def temporary_folder(disk: SmallDisk, monkeypatch):
    """Everything temporary goes there, as from the start of a worker on."""
    with monkeypatch.context() as patched:
        patched.setattr(tempfile, "tempdir", str(disk.folder))
        yield


def test_a_temporary_folder_that_fills_is_no_verdict_on_an_engine(folder, monkeypatch):
    # For the disk itself, one folder and one file: a model does not fit beside what is printed.
    with (
        small_disk(folder / "disk", "size=64k,nr_inodes=3") as disk,
        temporary_folder(disk, monkeypatch),
    ):
        command_line.spincheck(*STUDY)
        with open_store(folder / "spincheck.sqlite") as store:
            (row,) = store.read().rows
        assert (row.outcome, row.cause) == ("failed", "environment")
        assert os.strerror(errno.ENOSPC) in row.reason
        disk.change("size=64k,nr_inodes=100")
        assert command_line.spincheck(*STUDY).returncode == AGREES
        with open_store(folder / "spincheck.sqlite") as store:
            assert "failed" not in {row.outcome for row in store.read().rows}


READING = {
    "rows": ["rows", "results.sqlite"],
    "verdicts": ["rows", "--verdicts", "results.sqlite"],
    "report": ["report", "results.sqlite", "--out", "../pages"],
}
WRITING = {
    "run": [*STUDY, "--out", "results.sqlite"],
    "a run that begins one": [*STUDY, "--out", "new.sqlite"],
    "report": ["report", "results.sqlite", "--out", "pages"],
    "new": ["new", "my-top"],
    "export": ["export", "made.toml", "models"],
    "the exact motion": ["export", "made.toml", "truth", "--truth"],
    "reproduce": [
        *("reproduce", "made.toml", "--engine", "mujoco"),
        *("--method", "RK4", "--timestep", "0.01"),
    ],
}


@contextmanager
def read_only_folder(folder: Path, monkeypatch):
    with small_disk(folder / "disk", "size=8m") as disk:
        small_result_file.write(disk.folder / "results.sqlite")
        (disk.folder / "made.toml").write_text(written(LEAST))
        disk.change("ro")
        with monkeypatch.context() as patched:
            patched.chdir(disk.folder)
            yield disk.folder


def test_what_is_in_a_folder_that_is_read_only_can_be_read(folder, monkeypatch):
    with read_only_folder(folder, monkeypatch):
        done = {name: command_line.spincheck(*command) for name, command in READING.items()}
    assert {name: run.stderr for name, run in done.items()} == dict.fromkeys(READING, "")
    assert (folder / "pages" / "index.html").is_file()


def test_what_cannot_be_written_there_is_one_message(folder, monkeypatch):
    with read_only_folder(folder, monkeypatch) as writable:
        done = {name: command_line.spincheck(*command) for name, command in WRITING.items()}
        assert {path.name for path in writable.iterdir()} == {"results.sqlite", "made.toml"}
    assert {name: run.returncode for name, run in done.items()} == dict.fromkeys(WRITING, BAD_INPUT)
    for run in done.values():
        (line,) = run.stderr.splitlines()
        assert line.endswith("Read-only file system")
