"""Sweeps on a Dask cluster: the same points to the last bit, whatever happens to its workers."""

import os
import signal
import socket
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from box import BOX
from in_process import InProcess
from planted import HeunSession, SegfaultSession, planted
from spincheck.reports.cli.terminal import BAD_INPUT, NOT_RUN, Complaint
from spincheck.reports.harness.choice import Choice
from spincheck.reports.harness.executors import dask_cluster as cluster
from spincheck.reports.harness.executors.dask_cluster import CONNECT_LIMIT, Cluster
from spincheck.reports.harness.executors.worker_slot import CallFailed
from spincheck.reports.harness.sweep import carry_out_sweep, plan_sweep
from spincheck.reports.results.store import open_store
from spincheck.reports.results.sweep_records import Axis, Ensemble, Map, PointResult
from spincheck.scenarios import loads

distributed = pytest.importorskip("distributed")

SCENE = loads(BOX, "box")
STEPS = Axis("timestep", (0.01, 0.02, 0.04), logarithmic=True)
SPIN = Axis("start.omega_body[1]", tuple(0.5 + k / 8 for k in range(8)), logarithmic=False)
MAP = Map("box", (SPIN, STEPS), None)
ENSEMBLE = Ensemble("box", 6, seed=5, timestep=None)
FAULTLESS = Choice((planted(HeunSession),), timed=False)
CRASHING = Choice((planted(HeunSession), planted(SegfaultSession)), timed=False)
#: s; what is to be told promptly takes no longer, on a machine that is busy with other tests.
PATIENCE = 4 * CONNECT_LIMIT


@pytest.fixture(scope="module")
def scheduler():
    """A scheduler with two worker processes, each under a nanny that replaces it if it dies."""
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, dashboard_address=":0", silence_logs=True
    ) as started:
        yield started


def sweep(
    path: Path, asked, executor, choice=FAULTLESS, progress: Callable[[str], None] = len
) -> tuple[PointResult, ...]:
    with open_store(path, create=True) as store, executor:
        plan = plan_sweep(asked, SCENE, choice, store)
        carry_out_sweep(plan, SCENE, store, executor, progress)
        return store.sweeps.points(asked)


def workers_of(scheduler) -> list[int]:
    with distributed.Client(scheduler.scheduler_address, set_as_default=False) as client:
        return list(client.run(os.getpid).values())


@pytest.mark.parametrize("asked", [MAP, ENSEMBLE], ids=["map", "ensemble"])
def test_the_points_are_those_of_this_computer_to_the_last_bit(tmp_path, scheduler, asked):
    there = sweep(tmp_path / "there.sqlite", asked, Cluster(scheduler.scheduler_address))
    assert there == sweep(tmp_path / "here.sqlite", asked, InProcess())


def test_a_worker_killed_in_the_midst_loses_nothing_and_makes_nothing_twice(tmp_path, scheduler):
    told: list[str] = []

    def kill_one(said: str) -> None:
        told.append(said)
        if len(told) == 3:
            os.kill(workers_of(scheduler)[0], signal.SIGKILL)

    disturbed = sweep(
        tmp_path / "there.sqlite", MAP, Cluster(scheduler.scheduler_address), progress=kill_one
    )
    assert len(set(told)) == len(told) == len(SPIN.values) * len(STEPS.values)
    assert disturbed == sweep(tmp_path / "here.sqlite", MAP, InProcess())


def test_an_engine_that_crashes_costs_its_point_and_no_worker(tmp_path, scheduler):
    before = set(workers_of(scheduler))
    asked = replace(MAP, axes=(SPIN, replace(STEPS, values=(0.02,))))
    asked = replace(asked, axes=(replace(SPIN, values=(2.0,)), asked.axes[1]))
    points = sweep(tmp_path / "there.sqlite", asked, Cluster(scheduler.scheduler_address), CRASHING)
    assert [(p.key.engine, p.outcome, p.cause) for p in points] == [
        ("Heun", "ok", ""),
        ("Segfault", "failed", "crash"),
    ]
    assert set(workers_of(scheduler)) == before


def test_what_a_call_raises_there_is_told_here(scheduler):
    with (
        Cluster(scheduler.scheduler_address) as there,
        pytest.raises(CallFailed, match="SystemExit: 3"),
    ):
        there.submit(sys.exit, 3).result()


def test_workers_with_the_same_program_pass(scheduler):
    with Cluster(scheduler.scheduler_address) as there:
        there.check_alike()


def test_workers_with_another_program_are_refused(scheduler, monkeypatch):
    with Cluster(scheduler.scheduler_address) as there:
        monkeypatch.setattr(cluster, "program", lambda: b"another")
        with pytest.raises(Complaint, match="runs another spincheck or numpy") as told:
            there.check_alike()
    assert told.value.exit_code == NOT_RUN


def test_a_cluster_that_goes_away_ends_the_sweep_and_keeps_what_was_finished(tmp_path):
    path = tmp_path / "there.sqlite"
    local = distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, dashboard_address=":0", silence_logs=True
    )
    there = Cluster(local.scheduler_address)
    with pytest.raises(Complaint, match="gave up"):
        sweep(path, MAP, there, progress=lambda _: local.close())
    with open_store(path) as store:
        assert len(store.sweeps.points(MAP)) >= 1
    assert sweep(path, MAP, InProcess()) == sweep(tmp_path / "here.sqlite", MAP, InProcess())


def test_where_no_scheduler_answers_it_is_told_promptly():
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    began = time.monotonic()
    with pytest.raises(Complaint, match=f"no scheduler answers at 127.0.0.1:{port}") as told:
        Cluster(f"127.0.0.1:{port}")
    assert told.value.exit_code == NOT_RUN
    assert time.monotonic() - began < PATIENCE


@pytest.mark.parametrize("address", ["", "localhost", "nonsense://here:1"])
def test_what_is_no_address_is_bad_input(address):
    with pytest.raises(Complaint, match="'--dask' must be a scheduler's address") as told:
        Cluster(address)
    assert told.value.exit_code == BAD_INPUT


def test_without_the_package_it_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(Complaint, match=r"pip install 'spincheck\[dask\]'") as told:
        Cluster("127.0.0.1:8786")
    assert told.value.exit_code == NOT_RUN
