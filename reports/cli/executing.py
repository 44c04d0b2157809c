"""The executor that a command's options ask for."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from tempfile import gettempdir

from ..harness.executors import Executor, LocalWorkers
from .terminal import BAD_INPUT, NOT_RUN, Complaint, say


@dataclass(frozen=True)
class Where:
    """Where runs are made.

    Attributes
    ----------
    jobs : worker processes on this computer
    cluster : a Dask scheduler's address; used instead of worker processes if not empty
    """

    jobs: int
    cluster: str | None = None


@contextmanager
def executor_for(where: Where, time_limit: float | None) -> Iterator[Executor]:
    """Open the executor, and close it at the end.

    Raises
    ------
    Complaint
        If the cluster cannot be used, or goes away, or engines have no temporary folder here.
    """
    check_temporary_folder()
    if where.cluster is None:
        with LocalWorkers(where.jobs, time_limit) as executor:
            yield executor
        return
    # What talks to clusters is of no use to others, and takes long to import.
    from ..harness.executors.dask_cluster import ClusterError, DaskCluster

    try:
        with DaskCluster(where.cluster, time_limit) as executor:
            yield executor
    except ClusterError as error:
        exit_code = BAD_INPUT if error.bad_address else NOT_RUN
        raise Complaint(f"'--dask': {error}", exit_code) from None


def say_if_compiling() -> None:
    """Say that what solves exact motions is compiled next, unless it is there."""
    from ...reference.compiled import is_compiled
    from ..harness.executors.compiling import notice

    if not is_compiled():
        say(notice())


def compile_first() -> None:
    """Compile what solves exact motions, for a command that solves them in this process."""
    from ..harness.executors import compiling

    compiling.compile_first(say)


def check_temporary_folder() -> None:
    """Check that there is a temporary folder: engines read models and write output there.

    Raises
    ------
    Complaint
        If there is none that can be written.
    """
    try:
        gettempdir()
    except FileNotFoundError as error:
        raise Complaint(f"{error.strerror}; 'TMPDIR' names another", NOT_RUN) from None
