"""Calls on a Dask cluster: results to the last bit, whatever happens to its workers."""

import asyncio
import logging
import os
import signal
import socket
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import calls
import pytest
from box import BOX
from clusters import cluster_of_threads
from planted import HeunSession, planted
from same_results import differences
from spincheck.reports.harness.choice import Choice
from spincheck.reports.harness.executors import Executor, dask_cluster
from spincheck.reports.harness.executors.dask_cluster import (
    ClusterError,
    DaskCluster,
    program_and_numpy,
)
from spincheck.reports.results.records import Row
from spincheck.reports.results.store import open_store
from spincheck.reports.results.sweep_records import Axis, Map, points_of
from spincheck.scenarios import loads
from studies import numbers_of, study
from studies import sweep as sweep_of

pytestmark = pytest.mark.slow

distributed = pytest.importorskip("distributed")

SCENE = loads(BOX, "box")
STEPS = Axis("timestep", (0.01, 0.02, 0.04), logarithmic=True)
SPIN = Axis("start.omega_body[1]", (0.5, 1.0, 1.5, 2.0), logarithmic=False)
MAP = Map("box", (SPIN, STEPS), None)
FAULTLESS = Choice((planted(HeunSession),), max_steps=1 << 9, timed=False)


@pytest.fixture(scope="module")
def scheduler():
    with cluster_of_threads(2) as started:
        yield started


def sweep(path: Path, executor: Executor | None = None, progress: Callable[[str], object] = len):
    return sweep_of(path, MAP, SCENE, FAULTLESS, executor, progress)


@pytest.fixture(scope="module")
def here(tmp_path_factory) -> tuple[Row, ...]:
    """The points of this process."""
    return sweep(tmp_path_factory.mktemp("here") / "here.sqlite")


@pytest.mark.processes
def test_two_sweeps_on_one_cluster_have_the_points_of_this_process_to_the_last_bit(
    tmp_path, scheduler, here
):
    clusters = [DaskCluster(scheduler.scheduler_address) for _ in range(2)]
    with ThreadPoolExecutor(len(clusters)) as pool:
        paths = [tmp_path / f"{k}.sqlite" for k in range(len(clusters))]
        for there in pool.map(sweep, paths, clusters):
            assert numbers_of(there) == numbers_of(here)


@pytest.mark.processes
def test_so_are_the_results_of_a_study(tmp_path, scheduler):
    cluster = DaskCluster(scheduler.scheduler_address)
    made_there = study(tmp_path / "there.sqlite", [SCENE], FAULTLESS, cluster)
    made_here = study(tmp_path / "here.sqlite", [SCENE], FAULTLESS)
    assert differences(made_there, made_here) == []


@pytest.mark.processes
def test_a_cluster_that_goes_away_ends_the_sweep_and_keeps_what_was_finished(tmp_path, here):
    path = tmp_path / "there.sqlite"
    with cluster_of_threads(1) as local:
        cluster = DaskCluster(local.scheduler_address)
        with pytest.raises(ClusterError, match="is gone") as raised:
            sweep(path, cluster, progress=lambda _: local.close())
    assert "\n" not in str(raised.value)
    # Dask would log the tracebacks of a scheduler that cannot say goodbye.
    for name in dask_cluster.LOGGERS:
        assert not logging.getLogger(name).isEnabledFor(logging.CRITICAL)
    with open_store(path) as store:
        assert 1 <= len(points_of(MAP, store.varied(MAP.scenario))) < len(here)
    assert numbers_of(sweep(path)) == numbers_of(here)


def worker_processes(scheduler) -> set[int]:
    with distributed.Client(scheduler.scheduler_address, set_as_default=False) as client:
        # One that was killed is replaced in a while.
        client.wait_for_workers(2)
        return set(client.run(os.getpid).values())


@pytest.fixture(scope="module")
def scheduler_with_processes():
    """A scheduler with two worker processes, each under a nanny that replaces it if it dies."""
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, dashboard_address=":0", silence_logs=True
    ) as started:
        yield started


@pytest.mark.processes
def test_a_worker_killed_in_the_midst_loses_nothing_and_makes_nothing_twice(
    tmp_path, scheduler_with_processes, here
):
    lines: list[str] = []

    def kill_one(line: str) -> None:
        lines.append(line)
        if len(lines) == 3:
            os.kill(worker_processes(scheduler_with_processes).pop(), signal.SIGKILL)

    cluster = DaskCluster(scheduler_with_processes.scheduler_address)
    there = sweep(tmp_path / "there.sqlite", cluster, kill_one)
    assert numbers_of(there) == numbers_of(here)
    assert len(set(lines)) == len(lines) == len(here)


@pytest.mark.processes
def test_a_call_that_crashes_costs_no_worker_of_the_cluster(scheduler_with_processes):
    before = worker_processes(scheduler_with_processes)
    with DaskCluster(scheduler_with_processes.scheduler_address) as cluster:
        failed = cluster.call(calls.crash).value
    assert (failed.cause, "SIGSEGV" in failed.reason) == ("crash", True)
    assert worker_processes(scheduler_with_processes) == before


def test_workers_with_another_program_are_refused(scheduler, monkeypatch):
    monkeypatch.setattr(dask_cluster, "program_and_numpy", Another(program_and_numpy()))
    with pytest.raises(ClusterError, match="runs another spincheck or numpy"):
        DaskCluster(scheduler.scheduler_address)


class Another:
    """Returns one digest of the program here, and another one on the cluster's worker."""

    def __init__(self, exact: tuple[bytes, str]) -> None:
        self.exact, self.asked = exact, 0

    def __call__(self) -> tuple[bytes, str]:
        return self.exact

    def __reduce__(self):
        return _another, ()


def _another() -> Callable[[], tuple[bytes, str]]:
    return lambda: (b"another", "")


def test_a_scheduler_without_a_worker_is_reported():
    with (
        cluster_of_threads(1, workers=0) as started,
        pytest.raises(ClusterError, match=r"has no worker; 'dask worker tcp://.*' starts one"),
    ):
        DaskCluster(started.scheduler_address)


def test_where_no_scheduler_answers_it_is_waited_for_no_longer_than_the_limit(monkeypatch):
    monkeypatch.setattr(dask_cluster, "CONNECT_LIMIT", 0.1)
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    with pytest.raises(ClusterError, match=f"no scheduler answers at 127.0.0.1:{port}") as failed:
        DaskCluster(f"127.0.0.1:{port}")
    assert not failed.value.bad_address

    async def silent(address: str) -> None:
        await asyncio.sleep(600)

    monkeypatch.setattr("distributed.comm.core.connect", silent)
    with pytest.raises(ClusterError, match="no scheduler answers"):
        DaskCluster("127.0.0.1:8786")


def test_what_is_no_address_is_bad_input_and_without_the_package_it_says_what_to_install(
    monkeypatch,
):
    for address in ("", "localhost", "nonsense://here:1"):
        with pytest.raises(ClusterError, match="must be a scheduler's address") as failed:
            DaskCluster(address)
        assert failed.value.bad_address
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(ClusterError, match=r"pip install 'spincheck\[dask\]'"):
        DaskCluster("127.0.0.1:8786")
