"""Result files that an earlier spincheck wrote can be read, and only read."""

import json
import sqlite3
from contextlib import closing
from dataclasses import fields, is_dataclass, replace
from pathlib import Path

import command_line
import numpy as np
import pytest
import small_result_file
from spincheck.engines.method import COMMON_EFFECTS
from spincheck.reports.cli.terminal import BAD_INPUT
from spincheck.reports.results.database import put
from spincheck.reports.results.result_file import APPLICATION_ID, ResultFileError
from spincheck.reports.results.results import Results
from spincheck.reports.results.store import open_store
from spincheck.reports.results.sweep_records import PlacedRow

#: What `small_result_file.write` wrote with the last program of that format, as `.dump` prints it.
DUMP = Path(__file__).with_name("format_12.sql")
#: Added to records since: absent from such a file; and the effects that there were.
ABSENT_FROM_METHODS = {"by_angles": False, "damping": 0.0, "setup": "", "effects": COMMON_EFFECTS}
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


def without_turns(point: PlacedRow) -> PlacedRow:
    """A point as it was before turns were counted."""
    return replace(point, turns=None, turns_within_1deg=None, attitude_a_turn=None)


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
    sweeps = [replace(one, points=tuple(map(without_turns, one.points))) for one in now.sweeps]
    now = replace(now, sweeps=sweeps)
    assert [name for name in vars(now) if not same(vars(before)[name], vars(now)[name])] == []
    assert before.rows[0].seconds_per_step is not None


@pytest.mark.parametrize("command", ["rows", "verdicts", "points", "report", "compare"])
def test_every_command_that_reads_takes_it(old, tmp_path, command):
    files = [old.name] * (2 if command == "compare" else 1)
    done = command_line.spincheck(command, *files, cwd=tmp_path)
    assert (done.returncode != BAD_INPUT, done.stdout != "", done.stderr) == (True, True, "")


def test_it_is_not_written_to(old):
    before = old.read_bytes()
    with (
        pytest.raises(ResultFileError, match="format 12, this version continues 13"),
        open_store(old, create=True),
    ):
        pass
    assert old.read_bytes() == before


def test_a_number_that_was_changed_in_it_is_reported_and_damage_is_one_message(old):
    with closing(sqlite3.connect(old)) as connection, connection:
        connection.execute("UPDATE rows SET steps = steps + 1")
    with pytest.raises(ResultFileError, match="changed after it was written"):
        read(old)
    with closing(sqlite3.connect(old)) as connection, connection:
        connection.execute("UPDATE rows SET steps = steps - 1, motion = x'00'")
    done = command_line.spincheck("rows", old)
    assert (done.returncode, len(done.stderr.splitlines())) == (BAD_INPUT, 1)


#: As they were in earlier files of this format: what is at the place, and no version.
EARLIER = {"timestep": 0.01, "reason": "so", "reference_uncertainty": 0.0, "steps": 0}
EARLIER_ENDS = {
    ("mujoco", "skipped", "steps"): ("unsupported", "timestep"),
    ("pybullet", "unsupported", "clamp"): ("unsupported", "clamp"),
    ("", "invalid", "scene"): None,
}


def test_earlier_points_of_this_format_are_read_in_the_words_of_now(tmp_path):
    """Those that are no scene, which were of no engine, are passed over."""
    path = small_result_file.write(tmp_path / "now.sqlite")
    with closing(sqlite3.connect(path)) as connection, connection:
        connection.row_factory = sqlite3.Row
        (place,) = connection.execute("SELECT place FROM points WHERE place LIKE '%member\": 0,%'")
        connection.execute("DELETE FROM points")
        for engine, outcome, cause in EARLIER_ENDS:
            record = EARLIER | {"at": [0.0], "outcome": outcome, "cause": cause}
            columns = {"scenario": small_result_file.SWEPT, "place": place["place"]}
            columns |= {"engine": engine, "method": "RK4" * bool(engine), "digest": ""}
            put(connection, "points", columns | {"record": json.dumps(record)})
    points = [row for sweep in read(path).sweeps for row in sweep.points]
    ends = {(row.key.engine, row.outcome, row.cause) for row in points}
    assert ends == {(old[0], *now) for old, now in EARLIER_ENDS.items() if now}
