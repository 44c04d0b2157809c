"""Ensembles: every member is run once, whatever engines do, and stored points are not run again."""

import sqlite3
from contextlib import closing, suppress
from copy import copy
from dataclasses import replace
from pathlib import Path
from shutil import copyfile

import numpy as np
import pytest
from box import BOX
from failing_calls import FailingCalls, of_engine
from planted import METHOD, HeunSession, NotANumberSession, RaisingSession, SegfaultSession, planted
from spincheck.engines import Engine
from spincheck.engines.lost_process import KILLED
from spincheck.reports.harness.choice import Choice
from spincheck.reports.harness.executors import CallFailed, Executor
from spincheck.reports.harness.timesteps.stock import COMMON_TIMESTEP
from spincheck.reports.harness.varied import point as at_point
from spincheck.reports.harness.varied.ensemble import plan_ensemble
from spincheck.reports.results import fingerprints as fingerprints
from spincheck.reports.results.ensemble_records import (
    MAX_MEMBERS,
    Ensemble,
    EnsemblePoint,
)
from spincheck.reports.results.records import Row
from spincheck.reports.results.store import open_store
from spincheck.scenarios import Scenario, ScenarioError, loads
from spincheck.scenarios.scatter import member
from studies import numbers_of
from studies import run_members as run_members_of

pytestmark = pytest.mark.slow

SCENE = loads(BOX, "box")
TIMESTEPS = (0.01, 0.02, 0.04)
AT = Ensemble("box", 6, seed=5, timestep=0.02)
#: Two members of it, for engines that take their processes with them.
PART = replace(AT, members=2)
ENSEMBLE = Ensemble("box", 3, seed=5, timestep=None)
FAULTLESS = Choice((planted(HeunSession),), timed=False)
CRASHING = Choice((planted(HeunSession), planted(SegfaultSession)), timed=False)


def run_members(
    path: Path,
    definition=AT,
    choice: Choice = FAULTLESS,
    scene=SCENE,
    executor: Executor | None = None,
) -> tuple[Row, ...]:
    return run_members_of(path, definition, scene, choice, executor)


def at(point: Row) -> int:
    """The member's number."""
    return int(point.varied["member"])


def crashing(failure: CallFailed) -> Executor:
    """An executor on which the calls fail that the crashing engine has a part in."""
    return FailingCalls(of_engine("Segfault", failure))


def points_missing(path: Path, definition=AT, choice: Choice = FAULTLESS, scene=SCENE) -> int:
    with open_store(path, create=True) as store:
        return plan_ensemble(definition, scene, choice, store).missing


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """A file with an ensemble, and its points."""
    path = tmp_path_factory.mktemp("finished") / "results.sqlite"
    return path, run_members(path)


@pytest.fixture
def swept(path, finished):
    """A copy of it, to be written to."""
    return Path(copyfile(finished[0], path))


def test_the_method_is_of_second_order_on_every_member(path):
    """Errors of Heun's method, each against its member's own exact motion; twice the step, four."""
    runs = [run_members(path, replace(PART, timestep=timestep)) for timestep in TIMESTEPS]
    for of_member in zip(*runs, strict=True):
        assert [point.timestep for point in of_member] == [*TIMESTEPS]
        errors = [point.errors.omega for point in of_member]
        assert np.abs(np.diff(np.log2(errors)) - 2).max() < 0.25
        # With the exact motion of another member they would be as large as what is scattered.
        assert max(errors) < 1e-3


def test_what_is_read_back_is_what_was_put(finished, path):
    for file, definition, points in (
        (finished[0], AT, finished[1]),
        (path, ENSEMBLE, run_members(path, ENSEMBLE)),
    ):
        with open_store(file) as store:
            (stored,) = store.read().ensembles
        assert stored.ensemble == definition
        assert numbers_of(stored.points) == numbers_of(points)
        assert stored.scenario.text == SCENE.text


def test_nothing_that_is_there_is_run_again_unless_that_is_asked_for(swept):
    assert points_missing(swept) == 0
    assert points_missing(swept, choice=replace(FAULTLESS, again=True)) == 6


def engines_left(path: Path, choice: Choice) -> list[list[str]]:
    """Of each member that is not complete."""
    with open_store(path, create=True) as store:
        left = plan_ensemble(AT, SCENE, choice, store).left()
        return [[engine.name for engine, _ in one.to_run] for one in left]


def test_another_engine_leaves_what_is_there_and_what_rests_on_something_else_is_dropped(
    swept, monkeypatch
):
    both = Choice((*FAULTLESS.engines, planted(RaisingSession)))
    assert engines_left(swept, both) == [["Raising"]] * 6
    another = loads(BOX.replace("2.5]", "2.6]"), "box")
    assert points_missing(swept, scene=another) == AT.members
    monkeypatch.setattr(fingerprints, "program", lambda kind: f"another {kind}")
    assert points_missing(swept) == AT.members


class Stop(Exception):
    """Raised in the midst of an ensemble."""


def stop_after(path: Path, points: int) -> None:
    """Run a part of the ensemble, then stop like a program that is told to."""
    stored: list[str] = []

    def progress(line: str) -> None:
        stored.append(line)
        if len(stored) == points:
            raise Stop

    with suppress(Stop):
        run_members_of(path, AT, SCENE, FAULTLESS, progress=progress)


def test_stopped_at_any_point_it_goes_on_and_ends_the_same(path, finished):
    for points in (1, 3):
        stop_after(path, points)
    assert points_missing(path) == 2
    assert numbers_of(run_members(path)) == numbers_of(finished[1])


def test_nothing_is_stored_twice(swept):
    with closing(sqlite3.connect(swept)) as connection:
        connection.execute("DELETE FROM rows WHERE rowid % 2")
        connection.commit()
    run_members(swept)
    with closing(sqlite3.connect(swept)) as connection:
        (count,) = connection.execute("SELECT count(*) FROM rows").fetchone()
    assert count == AT.members


@pytest.mark.parametrize("cause", ["crash", "time-out", "killed", "bug"])
def test_a_method_that_is_lost_costs_its_own_point_and_says_why(path, finished, cause):
    points = run_members(path, AT, CRASHING, executor=crashing(CallFailed("so it went", cause)))
    crashed = [p for p in points if p.key.engine == "Segfault"]
    assert {(p.outcome, p.cause, p.reason) for p in crashed} == {("failed", cause, "so it went")}
    assert [(at(p), p.timestep) for p in crashed] == [(at(p), 0.02) for p in finished[1]]
    of_heun = [p for p in points if p.key.engine == "Heun"]
    assert numbers_of(of_heun) == numbers_of(finished[1])


def test_points_that_somebody_killed_or_the_machine_refused_are_tried_again(path):
    run_members(path, AT, CRASHING, executor=crashing(CallFailed(KILLED, "killed")))
    assert engines_left(path, CRASHING) == [["Segfault"]] * 6
    refused = CallFailed("no worker process could be started", "environment")
    run_members(path, ENSEMBLE, executor=FailingCalls(lambda *_: refused))
    assert points_missing(path, ENSEMBLE) == ENSEMBLE.members


def test_the_largest_ensemble_is_planned_member_by_member(path, monkeypatch):
    identities = []
    identity = EnsemblePoint.varied.fget
    monkeypatch.setattr(
        EnsemblePoint, "varied", property(lambda point: identities.append(point) or identity(point))
    )
    with open_store(path, create=True) as store:
        plan = plan_ensemble(replace(ENSEMBLE, members=MAX_MEMBERS), SCENE, FAULTLESS, store)
    assert plan.missing == MAX_MEMBERS
    assert next(plan.left()).point == EnsemblePoint(ENSEMBLE.seed, 0)
    assert len(identities) == 1


STOPPED = CallFailed("did not finish within 120 s", "time-out")
CRASHED = CallFailed("it crashed", "crash")


@pytest.mark.parametrize(
    ("failure", "time_limit", "again"),
    [(STOPPED, None, 0), (STOPPED, 120.0, 0), (STOPPED, 500.0, 6), (CRASHED, 500.0, 0)],
)
def test_one_that_was_stopped_is_tried_again_with_more_time(path, failure, time_limit, again):
    run_members(path, AT, CRASHING, executor=crashing(failure))
    assert points_missing(path, choice=replace(CRASHING, time_limit=time_limit)) == again


def test_points_of_a_place_are_made_by_one_call_and_what_diverges_says_when_and_why(path):
    executor = FailingCalls()
    both = Choice((planted(RaisingSession), planted(NotANumberSession)), timed=False)
    points = run_members(path, choice=both, executor=executor)
    assert executor.calls == AT.members
    diverged = [p for p in points if p.key.engine == "NotANumber"]
    assert {(p.outcome, p.cause) for p in diverged} == {("diverged", "not-finite")}
    assert all(0.5 < p.stopped_at <= 1.0 for p in diverged)


def test_a_member_that_is_no_scene_says_so_and_is_not_tried_again(path, monkeypatch):
    def second_is_none(base: Scenario, seed: int, number: int) -> Scenario:
        if number == 1:
            raise ScenarioError("box.toml:5: [body] inertia: one may not exceed the others")
        return member(base, seed, number)

    monkeypatch.setattr(at_point, "member", second_is_none)
    two = Choice((planted(HeunSession), planted(NotANumberSession)), timed=False)
    without = [p for p in run_members(path, ENSEMBLE, two) if at(p) == 1]
    assert [(p.outcome, p.cause) for p in without] == [("unsupported", "scene")] * 2
    assert without[0].reason == "[body] inertia: one may not exceed the others"
    assert points_missing(path, ENSEMBLE, two) == 0


def test_timesteps_beyond_the_budget_or_the_window_are_not_run_and_say_so(path):
    short, long = (
        run_members(path, replace(PART, timestep=timestep))[0] for timestep in (1e-9, 3.0)
    )
    assert (short.outcome, short.cause, short.timestep) == ("unsupported", "timestep", 1e-9)
    assert short.reason.endswith(f"a point may take {at_point.STEP_BUDGET}")
    assert long.outcome == "unsupported"
    assert "must be shorter than the window" in long.reason


def test_a_scene_that_cannot_be_solved_is_reported_of_every_method(path, monkeypatch):
    """In this process, where a reference can be replaced."""

    def unsolvable(*_: object) -> None:
        raise ArithmeticError("no series converges")

    monkeypatch.setattr(at_point, "solve_cheaply", unsolvable)
    pairs = [(planted(HeunSession), METHOD), (planted(RaisingSession), METHOD)]
    points = at_point.run_point(SCENE, next(AT.points()), pairs)
    assert [(p.outcome, p.cause) for p in points] == [("failed", "unsolved")] * 2
    assert "no series converges" in points[0].reason


def test_a_reference_that_takes_its_process_with_it_is_not_blamed_on_a_method(path):
    points = run_members(path, PART, CRASHING, executor=FailingCalls(lambda *_: CRASHED))
    assert [(p.outcome, p.cause) for p in points] == [("failed", "killed")] * 4
    assert points[0].reason == "the exact motion could not be found: it crashed"


def with_stock_timestep(name: str, timestep: float | None) -> Engine:
    engine = copy(planted(HeunSession))
    engine.name, engine.stock_timestep = name, timestep
    return engine


def test_members_are_those_of_the_seed_and_run_at_each_engines_stock_timestep(path):
    """One engine has a stock timestep of its own, of the other all engines' is taken."""
    own, common = with_stock_timestep("own", 0.004), with_stock_timestep("common", None)
    points = run_members(path, ENSEMBLE, Choice((own, common), timed=False))
    assert [at(p) for p in points] == [k for k in (0, 1, 2) for _ in (own, common)]
    timesteps = {"own": 0.004, "common": COMMON_TIMESTEP}
    assert {(p.key.engine, p.timestep) for p in points} == {*timesteps.items()}
    errors = {p.key.engine: p.errors.omega for p in points if at(p) == 0}
    # Of second order, each beside the exact motion at its own samples.
    ratio = (0.004 / COMMON_TIMESTEP) ** 2
    assert errors["own"] / errors["common"] == pytest.approx(ratio, rel=0.2)


def test_a_member_that_a_stock_timestep_does_not_resolve_is_not_run(path):
    coarse = Choice((with_stock_timestep("coarse", 10.0),), timed=False)
    points = run_members(path, ENSEMBLE, coarse)
    assert {(p.outcome, p.cause) for p in points} == {("unsupported", "timestep")}
    assert all("° a step" in p.reason or "too few" in p.reason for p in points)


def test_a_larger_ensemble_begins_with_the_same_members_and_others_share_none(path):
    first = run_members(path, ENSEMBLE)
    assert points_missing(path, replace(ENSEMBLE, seed=6)) == 3
    at_a_timestep = replace(ENSEMBLE, timestep=0.02)
    assert points_missing(path, at_a_timestep) == 3
    assert {p.timestep for p in run_members(path, at_a_timestep)} == {0.02}
    larger = replace(ENSEMBLE, members=5)
    assert points_missing(path, larger) == 2
    assert numbers_of(run_members(path, larger)[: len(first)]) == numbers_of(first)
