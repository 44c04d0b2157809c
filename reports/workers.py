"""Runs calls in worker processes that may crash, hang or print without harming the study.

One process, one pipe, one call at a time: nothing is shared, so a process that is killed at any
instruction takes no other down.
"""

import heapq
import signal
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from itertools import count
from multiprocessing.connection import wait
from types import TracebackType
from typing import Any, Self

from .worker_process import WorkerProcess

#: s; a run of the largest ladder takes a few seconds.
TIME_LIMIT = 120.0
#: A call whose worker was killed from outside is tried this often in all.
ATTEMPTS = 2
#: Characters of a worker's last line that go into the reason of its death.
LAST_WORDS = 200
#: What somebody else sends to a process that is in the way; no engine ends by these.
FROM_OUTSIDE = (signal.SIGKILL, signal.SIGTERM, signal.SIGHUP)
#: Begins the reason of a call that was lost so.
KILLED = "the worker process was killed from outside"


@dataclass(frozen=True)
class Lost:
    """A call that gave no result, and why."""

    reason: str

    @property
    def killed(self) -> bool:
        """Whether somebody else put an end to it: it may be tried again."""
        return self.reason.startswith(KILLED)


@dataclass(eq=False)
class Task:
    """A call on its way through the workers.

    Attributes
    ----------
    result : what it returned, or `Lost` if it crashed, hung or raised
    printed : what it wrote to the terminal, by Python or by C; the end of it if that is long
    """

    call: Callable[..., Any]
    arguments: tuple[Any, ...]
    priority: tuple[int, int]
    attempts: int = 0
    result: Any = None
    printed: str = ""
    done: bool = False

    def __lt__(self, other: "Task") -> bool:
        """Whether it is to be called before another."""
        return self.priority < other.priority


@dataclass(eq=False)
class _Busy:
    task: Task
    deadline: float


class Workers:
    """A number of processes, started as they are needed; to be used from one thread."""

    def __init__(self, jobs: int) -> None:
        self._jobs = jobs
        self._time_limit = TIME_LIMIT
        self._numbers = count()
        self._waiting: list[Task] = []
        self._idle: list[WorkerProcess] = []
        self._busy: dict[WorkerProcess, _Busy] = {}

    def submit(self, call: Callable[..., Any], *arguments: Any, rank: int = 0) -> Task:
        """Schedule a call; of those that wait the one of least rank is called first.

        What it takes and returns is pickled.
        """
        task = Task(call, arguments, (rank, next(self._numbers)))
        heapq.heappush(self._waiting, task)
        return task

    def result(self, task: Task) -> Any:
        """What a call returned, as soon as it has."""
        while not task.done:
            self.finished()
        return task.result

    def finished(self) -> list[Task]:
        """Let the workers work until a call is done, or more; empty if none is under way."""
        self._hand_out()
        done: list[Task] = []
        while self._busy and not done:
            nearest = min(busy.deadline for busy in self._busy.values())
            ready = wait(
                [worker.pipe for worker in self._busy],
                timeout=max(0.0, nearest - time.monotonic()),
            )
            for worker in list(self._busy):
                if worker.pipe in ready:
                    done += self._receive(worker)
                elif time.monotonic() >= self._busy[worker].deadline:
                    done += self._stop(worker)
            # Before the results are looked at, so that nobody waits for that.
            self._hand_out()
        return done

    def _hand_out(self) -> None:
        """Give waiting calls to idle workers, and start those that are lacking."""
        while self._waiting and len(self._busy) < self._jobs:
            worker = self._idle.pop() if self._idle else WorkerProcess()
            if not worker.alive:
                worker.end()
                continue
            task = heapq.heappop(self._waiting)
            task.attempts += 1
            self._busy[worker] = _Busy(task, time.monotonic() + self._time_limit)
            # One that dies meanwhile is found to have died when its answer is waited for.
            with suppress(OSError):
                worker.give(task.call, task.arguments)

    def _receive(self, worker: WorkerProcess) -> list[Task]:
        task = self._busy.pop(worker).task
        try:
            returned, value = worker.take()
        except (EOFError, OSError):
            return self._bury(worker, task)
        self._idle.append(worker)
        return [_settled(task, value if returned else Lost(value), worker.printed())]

    def _bury(self, worker: WorkerProcess, task: Task) -> list[Task]:
        """A worker has died: by its call, or by somebody else, when the call is tried again."""
        printed = worker.printed()
        lost = Lost(_cause_of_death(worker.end()) + _last_words(printed))
        if lost.killed and task.attempts < ATTEMPTS:
            heapq.heappush(self._waiting, task)
            return []
        return [_settled(task, lost, printed)]

    def _stop(self, worker: WorkerProcess) -> list[Task]:
        """Stop a worker whose call overruns its time."""
        task = self._busy.pop(worker).task
        printed = worker.printed()
        worker.end()
        reason = f"did not finish within {self._time_limit:g} s{_last_words(printed)}"
        return [_settled(task, Lost(reason), printed)]

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        for worker in [*self._idle, *self._busy]:
            worker.end()
        self._idle.clear()
        self._busy.clear()
        self._waiting.clear()


def _settled(task: Task, result: Any, printed: str) -> Task:
    task.result, task.printed, task.done = result, printed, True
    return task


def _cause_of_death(exit_code: int) -> str:
    if exit_code >= 0:
        return f"the worker process ended with exit code {exit_code}"
    by = signal.Signals(-exit_code)
    return f"{KILLED if by in FROM_OUTSIDE else 'the worker process was killed'} by {by.name}"


def _last_words(printed: str) -> str:
    """The last line that a worker printed, to go on with the reason of its death."""
    lines = printed.strip().splitlines()
    return f"; it last printed: {lines[-1][-LAST_WORDS:]}" if lines else ""
