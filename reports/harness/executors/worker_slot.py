"""Where calls are made one after the other: a worker process, replaced whenever one dies."""

import re
import signal
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from ....engines import Cause
from .worker_process import WorkerProcess

#: A call whose worker was killed from outside is tried this often in all.
ATTEMPTS = 2
#: Characters of a worker's last line that go into the reason of its death.
LAST_WORDS = 200
#: What somebody else sends to a process that is in the way; no engine ends by these.
FROM_OUTSIDE = (signal.SIGKILL, signal.SIGTERM, signal.SIGHUP)
#: Begins the reason of a call that was lost so.
KILLED = "the worker process was killed from outside"
#: Begins the reason of a call that was stopped; its time limit follows.
_OVERDUE = "did not finish within "


class Lost(Exception):
    """A call that gave no result, and why: in words, and in a word."""

    def __init__(self, reason: str, cause: Cause = "bug") -> None:
        super().__init__(reason)
        self.reason = reason
        self.cause: Cause = cause

    @property
    def killed(self) -> bool:
        """Whether somebody else put an end to it: it may be tried again."""
        return self.reason.startswith(KILLED)


@dataclass(frozen=True, eq=False)
class Answer:
    """What comes of a call.

    Attributes
    ----------
    value : what it returned, or `Lost` if it crashed, hung or raised
    printed : what it wrote to the terminal, by Python or by C; the end of it if that is long
    """

    value: Any
    printed: str = ""


class Lane:
    """Makes calls, one at a time and all from one thread; any thread may stop it.

    Parameters
    ----------
    time_limit : s, that a call may take
    """

    def __init__(self, time_limit: float) -> None:
        self._time_limit = time_limit
        self._worker: WorkerProcess | None = None
        self._stopped = False
        self._changing = threading.Lock()

    def call(self, call: Callable[[], Any]) -> Answer:
        """What a call gives; what it is and returns is pickled."""
        answer = Answer(Lost(KILLED, "killed"))
        for _ in range(ATTEMPTS):
            answer = self._attempt(call)
            if self._stopped or not (isinstance(answer.value, Lost) and answer.value.killed):
                break
        return answer

    def stop(self) -> None:
        """Kill the process at once; what it is calling is lost."""
        with self._changing:
            self._stopped = True
            if self._worker is not None:
                self._worker.kill()

    def end(self) -> None:
        """Make an end of the process; from the thread that makes the calls."""
        with self._changing:
            self._stopped = True
            if self._worker is not None:
                self._worker.end()
                self._worker = None

    def _attempt(self, call: Callable[[], Any]) -> Answer:
        worker = self._ready()
        if worker is None:
            return Answer(Lost("it was stopped", "killed"))
        deadline = time.monotonic() + self._time_limit
        # One that dies meanwhile is found to have died when its answer is waited for.
        with suppress(OSError):
            worker.give(call)
        try:
            if not worker.has_answered(max(0.0, deadline - time.monotonic())):
                return self._overdue(worker)
            returned, value = worker.take()
        except (EOFError, OSError):
            return self._bury(worker)
        return Answer(value if returned else Lost(value), worker.printed())

    def _ready(self) -> WorkerProcess | None:
        """The process, or a new one in its place if it has died; None once this was stopped."""
        with self._changing:
            if self._stopped:
                return None
            if self._worker is not None and not self._worker.alive:
                self._worker.end()
                self._worker = None
            if self._worker is None:
                self._worker = WorkerProcess()
            return self._worker

    def _overdue(self, worker: WorkerProcess) -> Answer:
        printed = worker.printed()
        self._forget(worker)
        reason = f"{_OVERDUE}{self._time_limit:g} s{_last_words(printed)}"
        return Answer(Lost(reason, "time-out"), printed)

    def _bury(self, worker: WorkerProcess) -> Answer:
        printed = worker.printed()
        reason = _cause_of_death(self._forget(worker)) + _last_words(printed)
        cause: Cause = "killed" if reason.startswith(KILLED) else "crash"
        return Answer(Lost(reason, cause), printed)

    def _forget(self, worker: WorkerProcess) -> int:
        with self._changing:
            self._worker = None
            return worker.end()


def may_end_otherwise(reason: str, time_limit: float | None) -> bool:
    """Whether what was lost for a reason may succeed if it is called again.

    Somebody else had put an end to it, or it was stopped after less than the limit, s, that was
    chosen now.
    """
    if KILLED in reason:
        return True
    stopped = re.search(f"{_OVERDUE}([^ ]+) s", reason)
    return stopped is not None and time_limit is not None and float(stopped[1]) < time_limit


def _cause_of_death(exit_code: int) -> str:
    if exit_code >= 0:
        return f"the worker process ended with exit code {exit_code}"
    by = signal.Signals(-exit_code)
    return f"{KILLED if by in FROM_OUTSIDE else 'the worker process was killed'} by {by.name}"


def _last_words(printed: str) -> str:
    """The last line that a worker printed, to go on with the reason of its death."""
    lines = printed.strip().splitlines()
    return f"; it last printed: {lines[-1][-LAST_WORDS:]}" if lines else ""
