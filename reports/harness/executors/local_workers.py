"""Runs calls in worker processes that may crash, hang or print without harming the study.

An executor like those of `concurrent.futures`. Each process has a thread that waits for it, and
one socket; nothing else is shared, so a process that is killed at any instruction takes no other
down.
"""

import heapq
import threading
from collections.abc import Callable
from concurrent.futures import Executor, Future
from dataclasses import dataclass
from functools import partial
from itertools import count
from types import TracebackType
from typing import Any, ParamSpec, TypeVar

from .worker_slot import Lane, Lost

P = ParamSpec("P")
T = TypeVar("T")

#: s; a run of the largest ladder takes a few seconds.
TIME_LIMIT = 120.0


class Call(Future[T]):
    """A call on its way through the workers.

    Attributes
    ----------
    printed : what it wrote to the terminal, by Python or by C; the end of it if that is long
    """

    printed: str = ""

    def outcome(self) -> T | Lost:
        """What the call returned, as soon as it has, or why it gave no result."""
        try:
            return self.result()
        except Lost as lost:
            return lost


@dataclass(eq=False)
class _Waiting:
    priority: tuple[int, int]
    call: Callable[[], Any]
    future: Call[Any]

    def __lt__(self, other: "_Waiting") -> bool:
        return self.priority < other.priority


class Workers(Executor):
    """A number of processes, started as they are needed.

    A call that gives no result has `Lost` for its exception. Left by an exception, or by Ctrl-C,
    a ``with`` block kills the processes at once.

    Parameters
    ----------
    time_limit : s, that a call may take; `TIME_LIMIT` if None
    """

    def __init__(self, jobs: int, time_limit: float | None = None) -> None:
        self._jobs = jobs
        self._time_limit = TIME_LIMIT if time_limit is None else time_limit
        self._numbers = count()
        self._changed = threading.Condition()
        self._waiting: list[_Waiting] = []
        self._lanes: dict[threading.Thread, Lane] = {}
        self._idle = 0
        self._closed = False

    def submit(self, call: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Call[T]:
        """Schedule a call, behind those that wait; what it takes and returns is pickled."""
        return self.submit_ranked(0, call, *args, **kwargs)

    def submit_ranked(
        self, rank: int, call: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs
    ) -> Call[T]:
        """Schedule a call; of those that wait the one of least rank is called first."""
        future: Call[T] = Call()
        with self._changed:
            if self._closed:
                raise RuntimeError("'submit' must come before 'shutdown'.")
            waiting = _Waiting((rank, next(self._numbers)), partial(call, *args, **kwargs), future)
            heapq.heappush(self._waiting, waiting)
            if self._idle < len(self._waiting) and len(self._lanes) < self._jobs:
                self._start_lane()
            self._changed.notify()
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Take no more calls, and end the processes when those there are are done."""
        with self._changed:
            self._closed = True
            if cancel_futures:
                self._cancel_waiting()
            self._changed.notify_all()
        if wait:
            self._join()

    def kill(self) -> None:
        """End everything at once: what waits is cancelled, what is under way is lost."""
        with self._changed:
            self._closed = True
            self._cancel_waiting()
            self._changed.notify_all()
        for lane in self._lanes.values():
            lane.stop()
        self._join()

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        if kind is not None:
            self.kill()
            return
        try:
            self.shutdown()
        except BaseException:
            self.kill()
            raise

    def _cancel_waiting(self) -> None:
        for waiting in self._waiting:
            if waiting.future.cancel():
                # Tells those that wait for it.
                waiting.future.set_running_or_notify_cancel()
        self._waiting.clear()

    def _join(self) -> None:
        for thread in self._lanes:
            if thread.is_alive():
                thread.join()

    def _start_lane(self) -> None:
        lane = Lane(self._time_limit)
        # A program that ends without a word to its workers does not wait for them.
        thread = threading.Thread(target=self._work, args=(lane,), daemon=True)
        self._lanes[thread] = lane
        thread.start()

    def _work(self, lane: Lane) -> None:
        """A thread: make calls until there will be no more."""
        while (waiting := self._next()) is not None:
            future = waiting.future
            if not future.set_running_or_notify_cancel():
                continue
            answer = lane.call(waiting.call)
            future.printed = answer.printed
            if isinstance(answer.value, Lost):
                future.set_exception(answer.value)
            else:
                future.set_result(answer.value)
        lane.end()

    def _next(self) -> _Waiting | None:
        with self._changed:
            self._idle += 1
            while not self._waiting and not self._closed:
                self._changed.wait()
            self._idle -= 1
            return heapq.heappop(self._waiting) if self._waiting else None
