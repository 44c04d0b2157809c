"""`spincheck rows --tidy` deletes what no longer counts, and nothing else."""

from dataclasses import replace

import pytest
import small_result_file
from command_line import spincheck
from spincheck.reports.cli.terminal import AGREES, BAD_INPUT
from spincheck.reports.results import tables
from spincheck.reports.results.provenance_records import Fingerprint
from spincheck.reports.results.store import open_store
from spincheck.reports.results.tables import from_json


@pytest.fixture
def path(tmp_path):
    return small_result_file.write(tmp_path / "r.sqlite")


def outdate(path) -> int:
    """Make all results of an engine outdated; returns how many there are."""
    key = small_result_file.KEY
    with open_store(path, create=True) as store:
        (row, *_) = store.rows_of(key)
        # Large enough for pages of the file to become free.
        for k in range(1, 5):
            store.put(replace(row, timestep=row.timestep / 2**k, printed="x" * 100_000))
        outdated = sum(
            len(store.select(table, "scenario = ? AND engine = ?", (key.scenario, key.engine)))
            for table in tables.OF_STUDIES
        )
        store.rest_on([Fingerprint(key.scenario, key.engine, "engine", "another")])
    return outdated


def test_what_no_longer_counts_is_deleted_and_its_room_is_freed(path):
    assert spincheck("rows", str(path), "--tidy").stderr == "0 records deleted, 0.0 MB freed\n"
    outdated = outdate(path)
    with open_store(path) as store:
        before = store.read()
    done = spincheck("rows", str(path), "--tidy")
    assert done.returncode == AGREES
    assert done.stderr == f"{outdated} records deleted, 0.4 MB freed\n"
    with open_store(path) as store:
        after = store.read()
        assert after.rows == before.rows == []
        assert len(after.ensembles[0].points) == len(before.ensembles[0].points) > 0
    assert spincheck("rows", str(path), "--tidy").stderr == "0 records deleted, 0.0 MB freed\n"


@pytest.mark.parametrize("name", ["nowhere.sqlite", "text.sqlite"])
def test_no_file_is_made_or_changed_that_is_none_of_ours(tmp_path, name):
    (tmp_path / "text.sqlite").write_text("spincheck = 1\n" * 100)
    done = spincheck("rows", str(tmp_path / name), "--tidy")
    assert (done.returncode, len(done.stderr.splitlines())) == (BAD_INPUT, 1)
    assert [entry.name for entry in tmp_path.iterdir()] == ["text.sqlite"]


def test_json_of_a_record_is_an_object():
    with pytest.raises(ValueError, match="must be a JSON object"):
        from_json("[1]")
