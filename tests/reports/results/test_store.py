"""A result file gives back what was put in, and anything else is refused in one message."""

import math
import os
from dataclasses import asdict, replace
from operator import attrgetter

import numpy as np
import pytest
import small_result_file
from library_scenes import library_scene
from same_results import same_arrays
from spincheck.reference import Solution
from spincheck.reports.results.cost_records import MethodCost, StepCost
from spincheck.reports.results.provenance_records import DeclaredEngine, Fingerprint
from spincheck.reports.results.records import Defect, Key, Row, variation
from spincheck.reports.results.result_file import ResultFileError
from spincheck.reports.results.store import open_store
from spincheck.reports.results.verdicts import Verdict
from spincheck.scenarios import Errors, Trajectory
from stepped import SteppedEngine

KEY = Key("tennis-racket", "mujoco", "RK4")
ERRORS = Errors(1e-9, 2e-9, 3e-9, 4e-9, 5e-9, 6e-9)
TIMES = ("seconds_per_step", "seconds_spread", "wall_seconds_per_step")
COST = MethodCost(KEY, "a processor", StepCost(3e-6, 1e-7, 4e-6))
EVIDENCE = replace(small_result_file.EVIDENCE, key=KEY, refusal="cannot be restarted")
COME_BACK = {
    "verdicts": Verdict(KEY, "disagrees", "it says", EVIDENCE.steps, unmet=("a promise",)),
    "evidence": EVIDENCE,
    "costs": small_result_file.WHOLE,
}


def motion(n: int = 5) -> Trajectory:
    q = np.tile([1.0, 0, 0, 0], (n, 1))
    omega = np.random.default_rng(7).normal(size=(n, 3))
    return Trajectory(np.arange(n) / 3, q, omega, 0 * omega, 0 * omega)


SOLUTION = Solution(motion(), "by hand", ERRORS, ERRORS, 12.5)


@pytest.fixture
def row() -> Row:
    return Row(
        KEY,
        "4.0.0",
        0.001,
        "ok",
        "the first steps do not obey the scene's equations",
        "law",
        0.5,
        ERRORS,
        {"energy": 1e-3},
        1e-15,
        500,
        motion=motion(),
        printed="a warning",
        stock=True,
        unasked=("damping", "joint motor"),
        defects={"omega": Defect(1e-9, 2e-9, math.inf, 0.5, 1e-15)},
    )


@pytest.fixture
def solved(path):
    """The file has the scene, without which a run is none."""
    with open_store(path, create=True) as store:
        store.put_scene(library_scene(KEY.scenario), SOLUTION)


@pytest.mark.usefixtures("solved")
def test_a_row_and_its_scene_come_back_to_the_last_bit(path, row):
    with open_store(path, create=True) as store:
        store.put(row)
        # It is on disk at once.
        with open_store(path) as other:
            results = other.read()
    (back,), scene = results.rows, results.scenes[KEY.scenario]
    assert same_arrays(back.motion, row.motion)
    assert asdict(replace(back, motion=None)) == asdict(replace(row, motion=None))
    assert scene.scenario.digest == library_scene(KEY.scenario).digest
    assert same_arrays(scene.solution.trajectory, SOLUTION.trajectory)
    assert (scene.solution.uncertainty, scene.solution.horizon) == (ERRORS, 12.5)


@pytest.mark.parametrize(("table", "record"), COME_BACK.items(), ids=COME_BACK)
def test_a_record_comes_back(path, table, record):
    with open_store(path, create=True) as store:
        store.put(record)
        assert getattr(store.read(), table) == [record]


@pytest.mark.usefixtures("solved")
def test_a_cost_reaches_every_row_of_its_method(path, row):
    with open_store(path, create=True) as store:
        store.put(COST, row, replace(row, timestep=0.002))
        times = [attrgetter(*TIMES)(row) for row in store.read().rows]
    assert times == 2 * [(3e-6, 1e-7, 4e-6)]


def test_costs_of_another_processor_are_forgotten(path):
    with open_store(path, create=True) as store:
        store.put(COST)
        store.forget_costs_of_other_processors("a processor")
        assert store.keys_with_timing() == {KEY}
        store.forget_costs_of_other_processors("another")
        assert store.keys_with_timing() == set()


def fingerprints(scenario: str = KEY.scenario, **changed: str) -> list[Fingerprint]:
    """What results of two engines rest on: all of it `one`, but for what is changed."""
    kinds = {"motion": "one", "run": "one", "timing": "one", "verdict": "one"}
    engines = {"mujoco": "one", "pybullet": "one"}
    return [
        *(Fingerprint(scenario, "", k, changed.get(k, one)) for k, one in kinds.items()),
        *(Fingerprint(scenario, e, "engine", changed.get(e, one)) for e, one in engines.items()),
    ]


@pytest.mark.parametrize(
    ("changed", "rows", "verdicts"),
    [
        ({"motion": "another"}, [], []),
        ({"run": "another"}, [], []),
        ({"pybullet": "another"}, ["mujoco"], ["mujoco"]),
        ({"verdict": "another"}, ["mujoco", "pybullet"], []),
        ({"timing": "another"}, ["mujoco", "pybullet"], ["mujoco", "pybullet"]),
    ],
)
def test_what_rests_on_something_else_does_not_count_until_that_is_back(
    path, row, changed, rows, verdicts
):
    # Without errors, so that it needs no scene.
    row = replace(row, errors=None)
    elsewhere = replace(row, key=replace(KEY, scenario="sphere"))

    def counted(store) -> tuple[list[str], list[str], int]:
        found = store.read()
        here = [r.key.engine for r in found.rows if r.key.scenario == KEY.scenario]
        return here, [v.key.engine for v in found.verdicts], len(found.rows) - len(here)

    with open_store(path, create=True) as store:
        store.rest_on(fingerprints())
        store.rest_on(fingerprints("sphere"))
        for engine in ("mujoco", "pybullet"):
            key = replace(KEY, engine=engine)
            store.put(replace(row, key=key), Verdict(key, "converges", ""))
        store.put(elsewhere)
        assert store.rest_on(fingerprints(**changed)) == 2 - len(verdicts)
        assert counted(store) == (rows, verdicts, 1)
    # Whoever reads the file, without engines and at any time, sees the same.
    with open_store(path) as store:
        assert counted(store) == (rows, verdicts, 1)
    with open_store(path, create=True) as store:
        store.rest_on(fingerprints())
        assert counted(store) == (["mujoco", "pybullet"], ["mujoco", "pybullet"], 1)
        store.rest_on(fingerprints(**changed))
        assert store.tidy() == 4 - len(rows) - len(verdicts)
        assert store.tidy() == 0
        store.rest_on(fingerprints())
        assert counted(store) == (rows, verdicts, 1)


def test_a_verdict_drops_the_samples_that_are_spent(path, row):
    fine = replace(row, timestep=0.0005)
    with open_store(path, create=True) as store:
        store.put(row, fine)
        store.put_verdict(Verdict(KEY, "converges", ""), discardable=[row.timestep])
        timesteps = [r.timestep for r in store.rows_of(KEY) if r.motion is not None]
    assert timesteps == [fine.timestep]


def test_of_several_verdicts_the_ladders_is_read(path):
    ladder = Verdict(KEY, "converges", "")
    single, another = (
        Verdict(KEY, "unresolved", "", timesteps=timesteps) for timesteps in ((0.01,), (0.02, 0.1))
    )
    with open_store(path, create=True) as store:
        store.put_verdict(single)
        assert store.read().verdicts == [single]
        store.put_verdict(ladder)
        store.put_verdict(another)
        assert store.read().verdicts == [ladder]
        assert store.read(timesteps=(0.1, 0.02)).verdicts == [another]


def test_a_verdict_cut_short_settles_nothing_longer(path):
    with open_store(path, create=True) as store:
        store.put_verdict(Verdict(KEY, "unresolved", "", step_limit=1000))
        assert len(store.settled(KEY.scenario, (), 1000)) == 1
        assert store.settled(KEY.scenario, (), 1001) == []


def pages_of(store, pragma: str) -> int:
    row = store._database._connection.execute(f"PRAGMA {pragma}").fetchone()
    return row[0]


def test_a_file_at_rest_is_one_file_without_gaps(path, row):
    """Begun with an empty one, as a run leaves it that is killed before anything else."""
    path.touch()
    with open_store(path, create=True) as store:
        assert store.read().rows == []
        store.put(replace(row, motion=motion(10_000)))
        store.put_verdict(Verdict(KEY, "converges", ""), discardable=[row.timestep])
        assert pages_of(store, "freelist_count") > 0
    assert [file.name for file in path.parent.iterdir()] == [path.name]
    with open_store(path) as store:
        assert pages_of(store, "freelist_count") == 0


def fill_the_disk(path, row) -> None:
    with open_store(path, create=True) as store:
        # As many pages as there are: what SQLite says of a page too many is what a full disk says.
        pages = pages_of(store, "page_count")
        store._database._connection.execute(f"PRAGMA max_page_count = {pages}")
        for step in range(1, 100):
            store.put(replace(row, timestep=step))


@pytest.mark.usefixtures("solved")
def test_a_disk_that_is_full_is_reported_and_what_was_stored_is_kept(path, row):
    with open_store(path, create=True) as store:
        store.put(row)
    with pytest.raises(ResultFileError, match="the disk is full"):
        fill_the_disk(path, row)
    with open_store(path) as store:
        assert row.timestep in {r.timestep for r in store.read().rows}


@pytest.mark.parametrize("what", ["file", "folder"])
def test_what_may_not_be_written_is_reported(path, row, what):
    with open_store(path, create=True) as store:
        store.put(row)
    place = path if what == "file" else path.parent
    mode = place.stat().st_mode
    place.chmod(0o555)
    try:
        if os.access(place, os.W_OK):
            pytest.skip("this user may write anything")
        with (
            pytest.raises(ResultFileError, match="cannot be"),
            open_store(path, create=True) as store,
        ):
            store.put(row)
        with open_store(path) as store:
            assert len(store.read().rows) == 1
    finally:
        place.chmod(mode)


@pytest.mark.usefixtures("solved")
def test_a_varied_run_is_no_run_of_the_scene_as_it_is_and_is_not_forgotten_with_it(path, row):
    """Else a study would take it for its own at that timestep."""
    failed = replace(row, errors=None, motion=None, outcome="failed")
    varied = replace(failed, variation=variation({"body.mass": 2.0}))
    with open_store(path, create=True) as store:
        store.put(varied, row)
        (own,) = store.rows_of(KEY)
        assert (own.variation, own.outcome) == ("", "ok")
        assert store.failed_rows(KEY.scenario) == []
        store.forget([KEY])
        assert store.rows_of(KEY) == []
        (kept,) = store.varied(KEY.scenario)
        assert kept.varied == {"body.mass": 2.0}


def test_which_engines_hold_their_state_in_24_bits_is_stored(tmp_path) -> None:
    """A record of before that was asked is one of double precision."""
    double, single = SteppedEngine(), SteppedEngine(single_precision=True)
    for engine, names in ((double, set()), (single, {single.name})):
        with open_store(tmp_path / f"{len(names)}.sqlite", create=True) as store:
            store.put_methods([engine])
            assert store.read().single_precision == names
    assert DeclaredEngine("older", ()).single_precision is False
