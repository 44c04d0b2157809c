"""A result file gives back what was put in, and anything else is refused in one message."""

import sqlite3
from dataclasses import asdict, replace

import numpy as np
import pytest
from spincheck.reference import Solution
from spincheck.reports.records import Key, Row, Verdict
from spincheck.reports.store import FORMAT, ResultFileError, open_store
from spincheck.scenarios import Errors, Trajectory, find, load

KEY = Key("tennis-racket", "mujoco", "RK4")
ERRORS = Errors(1e-9, 2e-9, 3e-9, 4e-9)


def motion(n: int = 5) -> Trajectory:
    q = np.tile([1.0, 0, 0, 0], (n, 1))
    omega = np.random.default_rng(7).normal(size=(n, 3))
    return Trajectory(np.arange(n) / 3, q, omega, 0 * omega, 0 * omega)


@pytest.fixture
def row() -> Row:
    return Row(
        KEY,
        "4.0.0",
        0.001,
        "diverged",
        "the state is no longer finite",
        0.5,
        ERRORS,
        {"energy": 1e-3},
        1e-15,
        500,
        1e-6,
        1e-7,
        motion(),
        "a warning",
    )


@pytest.fixture
def path(tmp_path):
    return tmp_path / "results.sqlite"


def same_motion(a: Trajectory, b: Trajectory) -> bool:
    return all(
        np.array_equal(x, y) for x, y in zip(vars(a).values(), vars(b).values(), strict=True)
    )


def test_a_row_comes_back_to_the_last_bit(path, row):
    with open_store(path, create=True) as store:
        store.put_row(row)
        (back,) = store.read().rows
    assert same_motion(back.motion, row.motion)
    plain = {"motion": None}
    assert asdict(replace(back, **plain)) == asdict(replace(row, **plain))


def test_a_verdict_comes_back(path):
    verdict = Verdict(KEY, "converges", "order 4.00", "attitude", 4.0, 1e-9, 2e-9, ("a promise",))
    with open_store(path, create=True) as store:
        store.put_verdict(verdict)
        assert store.read().verdicts == [verdict]


def test_a_scene_comes_back_with_its_truth(path):
    scenario = load(find(["tennis-racket"])[0])
    solution = Solution(motion(), "by hand", ERRORS, ERRORS, 12.5)
    with open_store(path, create=True) as store:
        store.put_scene(scenario, solution)
        back = store.read().scenes["tennis-racket"]
    assert back.scenario.digest == scenario.digest
    assert same_motion(back.solution.trajectory, solution.trajectory)
    assert (back.solution.uncertainty, back.solution.horizon) == (ERRORS, 12.5)


def test_a_cost_reaches_every_row_of_its_method(path, row):
    with open_store(path, create=True) as store:
        store.put_row(row)
        store.put_row(replace(row, timestep=0.002))
        store.put_cost(KEY, 3e-6, 1e-7)
        assert [r.seconds_per_step for r in store.read().rows] == [3e-6, 3e-6]


def test_running_a_scene_again_replaces_what_was_known_of_it(path, row):
    scenario = load(find(["tennis-racket"])[0])
    with open_store(path, create=True) as store:
        store.put_row(row)
        store.put_scene(scenario, Solution(motion(), "by hand", ERRORS, ERRORS))
        assert store.read().rows == []


def test_a_row_is_on_disk_as_soon_as_it_is_put(path, row):
    with open_store(path, create=True) as store:
        store.put_row(row)
        with open_store(path) as other:
            assert len(other.read().rows) == 1


def test_a_missing_file_is_refused(path):
    with pytest.raises(ResultFileError, match="no such result file"), open_store(path):
        pass


def test_a_file_that_is_no_database_is_refused(path):
    path.write_text("spincheck = 1\n" * 100)
    with pytest.raises(ResultFileError, match="not a usable result file"), open_store(path):
        pass


def test_a_database_of_something_else_is_refused(path):
    with sqlite3.connect(path) as connection:
        connection.execute("CREATE TABLE notes (text TEXT)")
    connection.close()
    with pytest.raises(ResultFileError, match="not a result file of spincheck"), open_store(path):
        pass


def test_a_file_of_another_format_version_is_refused(path):
    with open_store(path, create=True):
        pass
    connection = sqlite3.connect(path)
    connection.execute(f"PRAGMA user_version = {FORMAT + 1}")
    connection.close()
    with pytest.raises(ResultFileError, match=f"format {FORMAT + 1}"), open_store(path):
        pass


def test_a_damaged_record_is_told(path, row):
    with open_store(path, create=True) as store:
        store.put_row(row)
    connection = sqlite3.connect(path)
    connection.execute("UPDATE rows SET errors = 'nonsense'")
    connection.commit()
    connection.close()
    with (
        pytest.raises(ResultFileError, match="cannot be read"),
        open_store(path) as store,
    ):
        store.read()
