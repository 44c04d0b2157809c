"""A result file and its log, and a run and its file, stay together; only one run writes."""

import errno
import shutil
from pathlib import Path

import command_line
import pytest
import small_result_file
from spincheck.reports.results import result_file
from spincheck.reports.results.result_file import ResultFileError
from spincheck.reports.results.store import open_store

#: More than the file has at rest.
LATER = {"later": "found by a run that was killed"}


@pytest.fixture
def path(tmp_path):
    return small_result_file.write(tmp_path / "results.sqlite")


def log_of(path: Path) -> Path:
    return path.with_name(f"{path.name}-wal")


def killed(path: Path, copy: Path) -> Path:
    """What a run leaves that is killed while it writes: the file as it then is, and its log."""
    with open_store(path, create=True) as store:
        store.put_environment(LATER)
        shutil.copy(path, copy)
        shutil.copy(log_of(path), log_of(copy))
    return copy


def environment_of(path: Path) -> dict[str, str]:
    with open_store(path) as store:
        return store.read().environment


def test_a_killed_runs_results_are_in_its_log_and_a_file_without_its_log_is_known(path, tmp_path):
    killed_file = killed(path, tmp_path / "killed.sqlite")
    assert LATER.items() <= environment_of(killed_file).items()
    with open_store(killed_file) as store:
        assert not store.log_missing
    alone = shutil.copy(killed_file, tmp_path / "alone.sqlite")
    assert not LATER.items() <= environment_of(alone).items()
    with open_store(alone) as store:
        assert store.log_missing
    printed = command_line.spincheck("rows", str(alone)).stderr
    words = "it was copied, or the disk was full, while it was being written, and its log "
    assert f"{words}'alone.sqlite-wal' is not beside it" in printed
    with open_store(path) as store:
        assert not store.log_missing


def test_a_first_run_that_was_killed_leaves_a_result_file(tmp_path):
    """However early: the file is begun before there is a log."""
    new, alone = tmp_path / "new.sqlite", tmp_path / "alone.sqlite"
    with open_store(new, create=True) as store:
        store.put_environment(LATER)
        shutil.copy(new, alone)
    assert environment_of(alone) == {}


@pytest.mark.parametrize("write", [False, True], ids=["read", "written"])
@pytest.mark.parametrize("which", ["another", "an older one", "another that was killed"])
def test_a_file_beside_the_log_of_another_is_reported_and_kept(path, tmp_path, which, write):
    older = shutil.copy(path, tmp_path / "older.sqlite")
    killed_file = killed(path, tmp_path / "killed.sqlite")
    if which == "an older one":
        shutil.copy(older, killed_file)
    else:
        other = small_result_file.write(tmp_path / "other.sqlite")
        if which == "another that was killed":
            other = killed(other, tmp_path / "other-killed.sqlite")
        shutil.copy(other, killed_file)
    before = killed_file.read_bytes(), log_of(killed_file).read_bytes()
    with (
        pytest.raises(ResultFileError, match=r"killed.sqlite-wal', belongs to another result file"),
        open_store(killed_file, create=write),
    ):
        pass
    assert (killed_file.read_bytes(), log_of(killed_file).read_bytes()) == before


def remove(path: Path) -> dict[str, str]:
    path.unlink()
    return LATER


def replace(path: Path) -> dict[str, str]:
    path.rename(path.with_suffix(".away"))
    path.touch()
    return LATER


@pytest.mark.parametrize("change", [remove, replace])
def test_a_file_that_goes_during_a_run_ends_the_run(path, change):
    with (
        pytest.raises(ResultFileError, match="was removed or replaced while it was being written"),
        open_store(path, create=True) as store,
    ):
        store.put_environment(change(path))


def test_a_file_that_goes_last_of_all_is_reported(path):
    with (
        pytest.raises(ResultFileError, match="was removed or replaced"),
        open_store(path, create=True),
    ):
        path.unlink()


@pytest.mark.parametrize("number", [errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP])
def test_a_disk_without_locks_is_reported(path, monkeypatch, number):
    def refuse(*_: object) -> None:
        raise OSError(number, "refused")

    monkeypatch.setattr("fcntl.flock", refuse)
    with (
        pytest.raises(ResultFileError, match="cannot be locked against a second run: refused"),
        open_store(path, create=True),
    ):
        pass


def test_what_is_forgotten_is_gone_and_nothing_else(path):
    key = small_result_file.KEY
    with open_store(path, create=True) as store:
        store.forget([key])
        results = store.read()
        assert (results.rows, results.verdicts, results.costs) == ([], [], [])
        assert store.keys_with_timing() == set()
        assert results.scenes
        assert results.ensembles[0].points


def test_a_record_is_of_the_size_that_it_may_have(path, monkeypatch):
    monkeypatch.setattr(result_file, "LARGEST_RECORD", 1000)
    with pytest.raises(ResultFileError, match="a record is larger"), open_store(path) as store:
        store.read()
