"""Makes calls in one worker process at a time, which is replaced when it dies.

The call during which the process dies fails.
"""

import pickle
import re
import threading
from collections.abc import Callable
from typing import Any

from ....engines.child.process import ANSWER_LIMIT
from ....engines.fault import ENVIRONMENTAL, Cause
from ....engines.lost_process import Overdue, death, last_line
from .executor import Answer, CallFailed, ExecutorStopped
from .worker_process import WorkerProcess

#: CPU time that a call may take, s; the longest run of a ladder takes a few seconds.
TIME_LIMIT = 120.0
#: Number of times that a call is tried if its worker is killed from outside.
ATTEMPTS = 2
#: First words of the reason of a call whose worker has died.
_WORKER = "the worker process"
#: First words of the reason of a call that exceeded its time limit; the limit follows them.
_OVERDUE = "did not finish within "


class WorkerSlot:
    """Makes calls in one worker process, one at a time and all from one thread.

    Any thread may stop it.

    Parameters
    ----------
    time_limit : CPU time that a call may take, s
    site : folder in which the worker process looks for modules first; none if empty
    """

    def __init__(self, time_limit: float, site: str = "") -> None:
        self.site = site
        self._time_limit = time_limit
        self._worker: WorkerProcess | None = None
        self._stopped = False
        self._changing = threading.Lock()

    def call(self, call: Callable[[], Any]) -> Answer[Any]:
        """Call a function in the worker process, and return the answer.

        If the call cannot be pickled, it fails. If the process is killed from outside, the call is
        made again, `ATTEMPTS` times in all at most.

        Parameters
        ----------
        call : the function; it is pickled, and so is the value that it returns

        Raises
        ------
        ExecutorStopped
            If the slot was stopped.
        """
        try:
            request = pickle.dumps(call)
        except Exception as error:
            reason = f"the call cannot be sent to a worker: {type(error).__name__}: {error}"
            return Answer(CallFailed(reason))
        for attempt in range(ATTEMPTS):
            answer = self._attempt(request)
            if self._stopped:
                raise ExecutorStopped
            killed = isinstance(answer.value, CallFailed) and answer.value.cause == "killed"
            if not killed or attempt == ATTEMPTS - 1:
                break
        return answer

    def stop(self) -> None:
        """Kill the process at once; the call under way raises `ExecutorStopped`."""
        with self._changing:
            self._stopped = True
            if self._worker is not None:
                self._worker.kill()

    def end(self) -> None:
        """End the process; this must not be done while a call is under way."""
        with self._changing:
            self._stopped = True
            if self._worker is not None:
                self._worker.end()
                self._worker = None

    def _attempt(self, request: bytes) -> Answer[Any]:
        """Make a pickled call once, and return the answer.

        Its value is `CallFailed` if the process cannot be started, dies, or exceeds the time limit.
        """
        try:
            worker = self._ready()
        except OSError as error:
            return Answer(CallFailed(f"no worker process could be started: {error}", "environment"))
        try:
            worker.give(request)
            if overdue := worker.wait(self._time_limit):
                return self._given_up(worker, overdue)
            returned, value, cause = worker.take()
        except (EOFError, OSError):
            return self._died(worker)
        answer = Answer(value if returned else CallFailed(value, cause), worker.printed())
        if worker.is_spent:
            self._forget(worker)
        return answer

    def _ready(self) -> WorkerProcess:
        """Return the running worker process; start a new one if there is none or it has died.

        Raises
        ------
        ExecutorStopped
            If the slot was stopped.
        OSError
            If no process can be started.
        """
        with self._changing:
            if self._stopped:
                raise ExecutorStopped
            if self._worker is not None and not self._worker.alive:
                self._worker.end()
                self._worker = None
            if self._worker is None:
                self._worker = WorkerProcess(self.site)
            return self._worker

    def _given_up(self, worker: WorkerProcess, overdue: Overdue) -> Answer[Any]:
        """End a worker whose call exceeded a limit, and return the answer of the call."""
        self._forget(worker)
        printed = worker.printed()
        reason = f"{_OVERDUE}{overdue.words}{last_line(printed)}"
        return Answer(CallFailed(reason, overdue.cause), printed)

    def _died(self, worker: WorkerProcess) -> Answer[Any]:
        """Return the answer of a call whose worker has died or closed its pipes; end the worker."""
        ended = worker.ends_by_itself()
        code = self._forget(worker)
        how, cause = death(code) if ended else ("closed its pipes instead of answering", "crash")
        printed = worker.printed()
        return Answer(CallFailed(f"{_WORKER} {how}{last_line(printed)}", cause), printed)

    def _forget(self, worker: WorkerProcess) -> int:
        """End the worker, so that the next call starts another; return its exit code."""
        with self._changing:
            self._worker = None
            return worker.end()


def is_environmental(cause: str) -> bool:
    """Whether the machine, and not the function that was called, is to blame for a failure.

    Parameters
    ----------
    cause : the cause of the failure, in one word
    """
    return cause in ENVIRONMENTAL


def cause_of_unsolved(failure: CallFailed) -> Cause:
    """Return the cause of a run that was not made because the exact motion could not be found.

    It is the failure's own cause if the machine is to blame. It is `killed` if the solver crashed,
    so that the run is tried again: no engine is involved. Else it is `unsolved`.

    Parameters
    ----------
    failure : why the call that should find the exact motion failed
    """
    if failure.cause in ENVIRONMENTAL:
        return failure.cause
    return "killed" if failure.cause == "crash" else "unsolved"


def may_succeed_if_repeated(cause: str, reason: str, time_limit: float | None) -> bool:
    """Whether a call that failed may succeed if it is made again.

    It may if the machine is to blame. It also may if the call, or the answer of an engine that is a
    program of its own, exceeded a limit of CPU time that was lower than the present one.

    Parameters
    ----------
    cause, reason : why the call failed, in a word and in a sentence
    time_limit : the present limit of CPU time, s; `TIME_LIMIT` if None
    """
    if is_environmental(cause):
        return True
    limit = time_limit or TIME_LIMIT
    if stopped := re.search(f"{_OVERDUE}([^ ]+) s", reason):
        return float(stopped[1]) < limit
    unanswered = re.search(r"did not answer '\w+' within ([^ ]+) s", reason)
    return unanswered is not None and float(unanswered[1]) < min(limit, ANSWER_LIMIT)
