"""Dask clusters of tests."""

from typing import Any

import pytest


def cluster_of_threads(threads: int, workers: int = 1) -> Any:
    """A scheduler whose workers are threads of this process: nothing is started for it.

    A context manager; the test is skipped where Dask is not installed.
    """
    distributed = pytest.importorskip("distributed")
    return distributed.LocalCluster(
        n_workers=workers,
        threads_per_worker=threads,
        processes=False,
        protocol="tcp://",
        dashboard_address=":0",
        silence_logs=True,
    )
