"""Malicious result files: nothing but data is read from them."""

import io
import json
import shutil
import sqlite3
import tracemalloc
import zipfile
from contextlib import closing
from unittest.mock import patch

import command_line
import numpy as np
import pytest
import small_result_file
from forging import FIELD, change, columns, forge, seal
from made_up_ensembles import METHODS
from spincheck.reports.cli.terminal import BAD_INPUT
from spincheck.reports.results.ensemble_records import MAX_MEMBERS, EnsemblePoint
from spincheck.reports.results.result_file import ResultFileError
from spincheck.reports.results.store import open_store
from spincheck.reports.results.tables import pack, unpack
from spincheck.scenarios import SIGNAL, Trajectory
from spincheck.scenarios.errors import is_control

pytestmark = pytest.mark.slow

#: Never read by a report: which run wrote last.
NOT_READ = ("file",)
BLOBS = ("trajectory", "motion")
#: Bytes; unpacking refuses what is larger than a motion without having unpacked it.
BOMB = 1 << 26
#: Place of a byte of an archive's first array, after its header of 59.
IN_THE_FIRST_ARRAY = 100
COMMANDS = ("\x1b[2J", "\x9b31m", "\u202e", "\u200e", "\ufeff", "\x07", "\r")
HOSTILE = f"evil{''.join(COMMANDS)}"


@pytest.fixture
def path(good, tmp_path, monkeypatch):
    """A copy to be forged, in the folder that commands write to."""
    monkeypatch.chdir(tmp_path)
    return shutil.copy(good, tmp_path / "forged.sqlite")


def executed(path, *statements: str) -> None:
    with closing(sqlite3.connect(path)) as connection, connection:
        for statement in statements:
            connection.execute(statement)


def rewritten_schema(path, old: str, new: str) -> None:
    executed(
        path,
        "PRAGMA writable_schema = ON",
        f"UPDATE sqlite_master SET sql = CAST(replace(sql, '{old}', {new}) AS TEXT)",
    )


ENDLESS = "WITH RECURSIVE n(x) AS (SELECT 1 UNION ALL SELECT x FROM n) SELECT x FROM n"
SCHEMAS = {
    "a view that never ends": lambda path: executed(
        path, "DROP TABLE environment", f"CREATE VIEW environment(name) AS {ENDLESS}"
    ),
    "a trigger that forges": lambda path: executed(
        path,
        "CREATE TRIGGER t AFTER INSERT ON verdicts BEGIN "
        "UPDATE verdicts SET verdict = 'converges'; END",
    ),
    "a further table": lambda path: executed(path, "CREATE TABLE evil (x)"),
    "a further index": lambda path: executed(path, "CREATE INDEX evil ON rows (record)"),
    "a column that is computed": lambda path: executed(
        path, "ALTER TABLE rows ADD COLUMN evil AS (record || 'evil')"
    ),
    "a check that is computed": lambda path: rewritten_schema(
        path, "record TEXT NOT NULL", "'record TEXT NOT NULL CHECK (length(randomblob(1e9)))'"
    ),
    "a virtual table": lambda path: executed(
        path,
        "PRAGMA writable_schema = ON",
        "INSERT INTO sqlite_master VALUES "
        "('table', 'evil', 'evil', 0, 'CREATE VIRTUAL TABLE evil USING fts5(x)')",
    ),
    "a byte that is no text": lambda path: rewritten_schema(path, "record", "x'd8'"),
}


@pytest.mark.parametrize("write", [False, True], ids=["read", "written"])
@pytest.mark.parametrize("forged", SCHEMAS.values(), ids=SCHEMAS)
def test_a_file_of_another_schema_is_refused_and_left_as_it_is(path, forged, write):
    forged(path)
    before = path.read_bytes()
    with (
        pytest.raises(ResultFileError, match=r"its schema is not|not a usable result file"),
        open_store(path, create=write),
    ):
        pass
    assert path.read_bytes() == before


def test_nothing_can_be_written_through_a_file_opened_to_be_read(path):
    with (
        open_store(path) as store,
        pytest.raises(sqlite3.OperationalError, match="readonly"),
        store._database.transaction() as connection,
    ):
        connection.execute("DELETE FROM rows")


@pytest.mark.parametrize("name", ["/tmp/evil", "../../evil", "a/b", "..", "-x", ""])
def test_a_scene_in_what_an_ensemble_asks_for_names_no_page(path, name):
    with_asked(path, scenario=name)
    assert command_line.spincheck("report", str(path), "--out", "pages").returncode == BAD_INPUT
    assert {entry.name for entry in path.parent.iterdir()} == {path.name}


def test_a_number_that_was_changed_is_reported(good, path):
    """Any column of any table that is read, but for motions, which have checksums of their own."""
    silent = []
    for table, column in columns(good):
        if table in NOT_READ or column in BLOBS:
            continue
        shutil.copy(good, path)
        change(path, [(table, column)], 0.125)
        if "changed after it was written" not in complaint_of(path):
            silent.append((table, column))
    assert silent == []


#: Numbers that may be negative.
SIGNED = {"got", "wanted", "numbers"}


def with_each_replaced(value, number: float, name: str = ""):
    """The last name of each number in a value of JSON, and the value with another in its place."""
    if isinstance(value, dict | list):
        for key in [*value] if isinstance(value, dict) else range(len(value)):
            inner = key if isinstance(value, dict) else name
            for last, changed in with_each_replaced(value[key], number, inner):
                whole = value.copy()
                whole[key] = changed
                yield last, whole
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield name, number


@pytest.mark.parametrize("number", [float("nan"), -1.0])
def test_no_size_at_any_depth_of_a_record_is_negative_or_not_a_number(good, path, number):
    """Errors in each signal, of `spins` too, drifts, times a step."""
    forge(path, [("rows", "record.errors")], dict.fromkeys(SIGNAL, 1e-3))
    with_spins = path.read_bytes()
    accepted, tried = [], set()
    for table, column in columns(path):
        if table in NOT_READ or not column.startswith(FIELD):
            continue
        for name, value in with_each_replaced(first_value(path, table, column), number, column):
            if not (number < 0 and name.removeprefix(FIELD) in SIGNED):
                forge(path, [(table, column)], value)
                tried.add(name)
                if "cannot be read" not in complaint_of(path):
                    accepted.append((table, column, name))
                path.write_bytes(with_spins)
    assert accepted == []
    assert tried > {*SIGNAL, "seconds_per_step", "L_norm", "median", "gains", "tail", "off"}


def first_value(path, table: str, column: str):
    with closing(sqlite3.connect(path)) as connection:
        (record,) = connection.execute(f"SELECT record FROM {table} ORDER BY rowid").fetchone()
    return json.loads(record)[column.removeprefix(FIELD)]


def complaint_of(path) -> str:
    try:
        with open_store(path) as store:
            store.read()
    except ResultFileError as error:
        return str(error)
    return ""


def test_a_run_that_ended_ok_and_has_no_errors_is_compared_without_them(good, path):
    forge(path, [("rows", "record.errors")], None)
    for old, new in ((good, path), (path, good)):
        done = command_line.spincheck("compare", str(old), str(new))
        assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize(("table", "column"), [("scenes", "trajectory"), ("rows", "motion")])
def test_a_motion_that_was_changed_is_reported(path, table, column):
    with closing(sqlite3.connect(path)) as connection, connection:
        (blob,) = connection.execute(f"SELECT {column} FROM {table}").fetchone()
        changed = bytearray(blob)
        changed[IN_THE_FIRST_ARRAY] ^= 1
        connection.execute(f"UPDATE {table} SET {column} = ?", (bytes(changed),))
    with pytest.raises(ResultFileError, match="cannot be read"), open_store(path) as store:
        store.read()


def archive_of(arrays: dict[str, np.ndarray], **others: np.ndarray) -> bytes:
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **arrays, **others)
    return buffer.getvalue()


def lying(blob: bytes) -> bytes:
    """An archive whose largest member declares a small size."""
    content = bytearray(blob)
    content = content.replace((BOMB + 128).to_bytes(4, "little"), (200).to_bytes(4, "little"))
    return bytes(content)


MOTION = Trajectory(
    np.arange(3.0), np.tile([1.0, 0, 0, 0], (3, 1)), *(np.zeros((3, 3)) for _ in range(3))
)
ARRAYS = dict(vars(MOTION))
ZEROS = {**ARRAYS, "t": np.zeros(BOMB // 8)}
BLOBS_OF_HARM = {
    "of zeros": archive_of(ZEROS),
    "of zeros, said to be few": lying(archive_of(ZEROS)),
    "with another array": archive_of(ARRAYS, evil=np.zeros(3)),
    "with an array too few": archive_of({"t": np.zeros(3)}),
    "of numbers of another type": archive_of({**ARRAYS, "t": np.arange(3)}),
    "of objects": archive_of({**ARRAYS, "t": np.array([None] * 3)}),
    "none": b"PK\x05\x06" + bytes(18),
}


@pytest.mark.parametrize("blob", BLOBS_OF_HARM.values(), ids=BLOBS_OF_HARM)
def test_no_archive_unpacks_to_more_than_a_motion(blob):
    assert len(unpack(pack(MOTION)).t) == len(MOTION.t)
    tracemalloc.start()
    try:
        with pytest.raises((ValueError, zipfile.BadZipFile)):
            unpack(blob)
        assert tracemalloc.get_traced_memory()[1] < BOMB / 10
    finally:
        tracemalloc.stop()


def with_asked(path, **changed: object) -> None:
    with closing(sqlite3.connect(path)) as connection, connection:
        (definition,) = connection.execute("SELECT ensemble FROM ensembles").fetchone()
        text = json.dumps(json.loads(definition) | changed)
        connection.execute("UPDATE ensembles SET ensemble = ?", (text,))
    seal(path)


ASKED = {
    "more members than anyone waits for": {"members": 10**12},
    "no members": {"members": 0},
    "members that are no number": {"members": "10"},
    "a negative seed": {"seed": -1},
    "a seed of a thousand digits": {"seed": 10**1000},
    "a timestep of nothing": {"timestep": 0.0},
    "something else": {"evil": 1},
}


@pytest.mark.parametrize("changed", ASKED.values(), ids=ASKED)
def test_an_ensemble_that_nobody_can_ask_for_is_one_message(path, changed):
    with_asked(path, **changed)
    for command in ("rows", "report"):
        done = command_line.spincheck(command, str(path))
        assert (done.returncode, done.stdout) == (BAD_INPUT, "")
        assert len(done.stderr.splitlines()) == 1
        assert "a record cannot be read" in done.stderr


def test_reading_the_largest_ensemble_takes_as_long_as_what_there_is_of_it(path):
    with_asked(path, members=MAX_MEMBERS)
    places = 0
    varied = EnsemblePoint.varied.fget

    def counted(place: EnsemblePoint) -> dict[str, float]:
        nonlocal places
        places += 1
        return varied(place)

    with open_store(path) as store, patch.object(EnsemblePoint, "varied", property(counted)):
        (ensemble,) = store.read().ensembles
    assert len(ensemble.points) == small_result_file.MEMBERS * len(METHODS)
    assert places < 10 * len(columns(path))


FORMS = ([], ["--csv"], ["--json"])
OUTPUTS = (
    *(["rows", *verdicts, *form] for verdicts in ([], ["--verdicts"]) for form in FORMS),
    ["report"],
)


def test_nothing_in_a_file_commands_a_terminal_or_a_page(path):
    kept = {"rows": "printed", "verdicts": "quoted", "environment": "value"}
    forge(path, [(table, f"record.{name}") for table, name in kept.items()], HOSTILE)
    forge(path, [("rows", "record.reason"), ("rows", "record.engine_version")], HOSTILE)
    forge(path, [("verdicts", "record.unmet")], [HOSTILE])
    shown = "".join(command_line.spincheck(*arguments, str(path)).stdout for arguments in OUTPUTS)
    pages = [page for page in path.parent.rglob("*") if page.suffix in (".html", ".md")]
    shown += "".join(page.read_text(encoding="utf-8") for page in pages)
    assert shown.count("evil\\x1b[2J\\x9b31m") > len(kept)
    assert {c for c in shown if is_control(c)} <= {"\n", "\t"}
