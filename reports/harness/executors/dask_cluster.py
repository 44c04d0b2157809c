"""Runs calls on a Dask cluster, each in a process of its own there: a crash costs the call.

A cluster's worker that dies takes no result with it: Dask gives its calls to another one, and what
comes back comes back once (https://distributed.dask.org/en/stable/resilience.html).
"""

import asyncio
import logging
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future
from contextlib import contextmanager
from functools import partial
from types import TracebackType
from typing import Any, ParamSpec, TypeVar

import numpy as np

from ...cli.terminal import BAD_INPUT, NOT_RUN, Complaint
from ...results.fingerprints import program
from .local_workers import TIME_LIMIT
from .worker_slot import KILLED, Answer, Lane, Lost

P = ParamSpec("P")
T = TypeVar("T")

#: s; a scheduler that is there answers in a fraction of one.
CONNECT_LIMIT = 5.0

_of_this_thread = threading.local()


class Cluster(Executor):
    """The workers of a Dask scheduler. A call that gives no result has `Lost` for its exception.

    Parameters
    ----------
    time_limit : s, that a call may take; `TIME_LIMIT` if None
    """

    def __init__(self, address: str, time_limit: float | None = None) -> None:
        self._address = address
        self._time_limit = TIME_LIMIT if time_limit is None else time_limit
        self._client = _connected(address)
        self._executor: Executor = self._client.get_executor(pure=False)

    def submit(self, call: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Schedule a call; what it takes and returns is pickled."""
        ours: Future[T] = Future()
        theirs = self._executor.submit(isolated, partial(call, *args, **kwargs), self._time_limit)
        theirs.add_done_callback(lambda done: self._hand_over(done, ours))
        return ours

    def check_alike(self) -> None:
        """See that the workers that are there run this very program.

        Raises
        ------
        Complaint
            If one does not.
        """
        try:
            found = self._client.run(fingerprint)
        except Exception as error:
            reason = f"a worker of {self._address} cannot run spincheck: {error}"
            raise Complaint(f"'--dask': {reason}", NOT_RUN) from None
        for worker, theirs in found.items():
            if theirs != fingerprint():
                raise Complaint(
                    f"'--dask': {worker} runs another spincheck or numpy than this computer; "
                    "install the same on both",
                    NOT_RUN,
                )

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Let go of the cluster, which goes on without us; what is under way there is dropped."""
        self._executor.shutdown(wait=wait and not cancel_futures)
        self._client.close()

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.shutdown(cancel_futures=kind is not None)

    def _hand_over(self, done: Future[Answer], ours: Future[T]) -> None:
        from distributed.scheduler import KilledWorker

        try:
            value = done.result().value
        except KilledWorker as error:
            value = Lost(f"{KILLED}, and others after it: {error}", "killed")
        except Exception as error:
            ours.set_exception(_gone(self._address, error))
            return
        if isinstance(value, Lost):
            ours.set_exception(value)
        else:
            ours.set_result(value)


def isolated(call: Callable[[], Any], time_limit: float) -> Answer:
    """Make a call on a cluster's worker, in a process beside it that belongs to this thread."""
    lanes: dict[float, Lane] = _of_this_thread.__dict__.setdefault("lanes", {})
    if time_limit not in lanes:
        # Of another sweep; this one has a process of its own.
        for lane in lanes.values():
            lane.end()
        lanes.clear()
        lanes[time_limit] = Lane(time_limit)
    return lanes[time_limit].call(call)


def fingerprint() -> tuple[bytes, str]:
    """What a point may depend on, besides its scene and its engine: spincheck and numpy."""
    return program(), np.__version__


def _connected(address: str) -> Any:
    try:
        from distributed import Client
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] not in ("distributed", "dask"):
            raise
        raise Complaint(
            f"'--dask' needs the package '{error.name}', which is not installed: "
            "pip install 'spincheck[dask]'",
            NOT_RUN,
        ) from None
    try:
        with _quiet():
            # Before there is a client: one that cannot connect takes long to go away.
            asyncio.run(_greet(address))
            return Client(address, timeout=CONNECT_LIMIT, set_as_default=False)  # type: ignore[no-untyped-call]
    except (OSError, TimeoutError):
        raise Complaint(f"'--dask': no scheduler answers at {address}", NOT_RUN) from None
    except ValueError as error:
        raise Complaint(f"'--dask' must be a scheduler's address: {error}", BAD_INPUT) from None


async def _greet(address: str) -> None:
    from distributed.comm.core import connect

    scheduler = await asyncio.wait_for(connect(address), CONNECT_LIMIT)  # type: ignore[no-untyped-call]
    await scheduler.close()


@contextmanager
def _quiet() -> Iterator[None]:
    """What goes wrong is told as a complaint, not logged besides."""
    logger = logging.getLogger("distributed")
    before = logger.level
    logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        logger.setLevel(before)


def _gone(address: str, error: BaseException) -> Complaint:
    kind = type(error).__name__
    return Complaint(f"'--dask': the cluster at {address} gave up: {kind}: {error}", NOT_RUN)
