"""Makes calls on a Dask cluster, each in a process of its own there: a crash costs one call.

If a worker of the cluster dies, no result is lost: Dask gives its calls to another worker, and each
result is returned once (https://distributed.dask.org/en/stable/resilience.html).
"""

import asyncio
import logging
import threading
import weakref
from collections.abc import Callable
from functools import partial
from typing import Any, ParamSpec, TypeVar, final

import numpy as np

from ....engines.lost_process import KILLED
from ...results.fingerprints import DECIDING, program
from .executor import Answer, CallFailed, Executor, ExecutorStopped
from .local_workers import LocalWorkers
from .worker_slot import TIME_LIMIT, WorkerSlot

P = ParamSpec("P")
T = TypeVar("T")

#: s, to wait for a scheduler; one that runs answers in a fraction of a second.
CONNECT_LIMIT = 5.0
#: Dask's logs on the side of a client; the second has a level of its own.
LOGGERS = ("distributed", "distributed.client")
#: Calls submitted for each thread of the cluster: one runs, the next is being sent.
CALLS_PER_THREAD = 2

_of_this_thread = threading.local()


class ClusterError(Exception):
    """The cluster cannot be used, in one sentence.

    Attributes
    ----------
    bad_address : whether the address itself is malformed
    """

    def __init__(self, reason: str, *, bad_address: bool = False) -> None:
        super().__init__(reason)
        self.bad_address = bad_address


@final
class DaskCluster(Executor):
    """The workers of a Dask scheduler.

    Parameters
    ----------
    address : the scheduler's
    time_limit : CPU seconds that a call may take; `TIME_LIMIT` if None

    Raises
    ------
    ClusterError
        If Dask is not installed, no scheduler answers, it has no worker, or a worker runs another
        spincheck or numpy.
    """

    def __init__(self, address: str, time_limit: float | None = None) -> None:
        super().__init__()
        self._address = address
        self._time_limit = TIME_LIMIT if time_limit is None else time_limit
        self._stopped = False
        #: For what is timed: times taken on several computers are not to be compared.
        self._here = LocalWorkers(1, self._time_limit)
        self._client = _connected(address)
        threads = sum(self._client.nthreads().values())
        if not threads:
            self._client.close()
            raise ClusterError(
                f"the scheduler at {address} has no worker; 'dask worker {address}' starts one"
            )
        self._check_alike()
        self.width = CALLS_PER_THREAD * threads

    def call(self, function: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Answer[T]:
        """Call a function on the cluster; what it takes and returns is pickled.

        Raises
        ------
        ClusterError
            If the cluster is gone.
        """
        from distributed.scheduler import KilledWorker

        if self._stopped:
            raise ExecutorStopped
        call = partial(function, *args, **kwargs)
        try:
            answer: Answer[T] = self._client.submit(
                isolated, call, self._time_limit, pure=False
            ).result()
        except KilledWorker as error:
            reason = f"the worker process {KILLED}, and others after it: {error}"
            return Answer(CallFailed(reason, "killed"))
        except (Exception, asyncio.CancelledError) as error:
            if self._stopped:
                raise ExecutorStopped from None
            words = " ".join(str(error).split())
            raise ClusterError(f"the cluster at {self._address} is gone: {words}") from error
        return answer

    def alone(self) -> Executor:
        """A worker process on this computer."""
        return self._here

    def stop(self) -> None:
        """Disconnect from the cluster, which drops the calls under way."""
        self._stopped = True
        self._client.close()
        self._here.stop()

    def close(self) -> None:
        """Disconnect from the cluster, which keeps running."""
        self._client.close()
        self._here.close()

    def _check_alike(self) -> None:
        """Check that the cluster's workers run the same program."""
        try:
            versions = self._client.run(program_and_numpy)
        except Exception as error:
            self._client.close()
            raise ClusterError(
                f"a worker of {self._address} cannot run spincheck: {error}"
            ) from None
        for worker, theirs in versions.items():
            if theirs != program_and_numpy():
                self._client.close()
                raise ClusterError(
                    f"{worker} runs another spincheck or numpy than this computer; "
                    "install the same on both"
                )


def isolated(call: Callable[[], Any], time_limit: float) -> Answer[Any]:
    """Make a call on a cluster's worker, in a process of its own that ends with this thread."""
    slots: dict[float, WorkerSlot] = _of_this_thread.__dict__.setdefault("slots", {})
    if time_limit not in slots:
        # Of another run; this one has a process of its own.
        for slot in slots.values():
            slot.end()
        slots.clear()
        slots[time_limit] = WorkerSlot(time_limit)
        weakref.finalize(threading.current_thread(), slots[time_limit].end)
    return slots[time_limit].call(call)


def program_and_numpy() -> tuple[str, str]:
    """What results depend on besides scene and engine: digest of spincheck, version of numpy."""
    return " ".join(map(program, DECIDING)), np.__version__


def _connected(address: str) -> Any:
    try:
        from distributed import Client
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] not in ("distributed", "dask"):
            raise
        raise ClusterError(
            f"needs the package '{error.name}', which is not installed: "
            "pip install 'spincheck[dask]'"
        ) from None
    # What goes wrong is raised as an error; Dask logs its traceback besides, at any later time.
    for name in LOGGERS:
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    try:
        # Before a client is made: closing one that cannot connect takes long.
        asyncio.run(_greet(address))
        return Client(address, timeout=CONNECT_LIMIT, set_as_default=False)  # type: ignore[no-untyped-call]
    except (OSError, TimeoutError):
        raise ClusterError(f"no scheduler answers at {address}") from None
    except ValueError as error:
        raise ClusterError(f"must be a scheduler's address: {error}", bad_address=True) from None


async def _greet(address: str) -> None:
    from distributed.comm.core import connect

    scheduler = await asyncio.wait_for(connect(address), CONNECT_LIMIT)  # type: ignore[no-untyped-call]
    await scheduler.close()
