"""Calls functions in worker processes on this computer: a crash or a hang costs one call."""

import threading
from collections.abc import Callable
from functools import partial
from typing import ParamSpec, TypeVar, final

from .executor import Answer, Executor, ExecutorStopped
from .worker_slot import TIME_LIMIT, WorkerSlot

P = ParamSpec("P")
T = TypeVar("T")


@final
class LocalWorkers(Executor):
    """An executor with worker processes, one for each pair of a calling thread and a site.

    A site is a folder in which a process looks for modules first (`call_at`). A process is started
    by its first call.

    Parameters
    ----------
    jobs : number of calls that can be under way at once
    time_limit : CPU time that a call may take, s; `TIME_LIMIT` if None
    """

    def __init__(self, jobs: int, time_limit: float | None = None) -> None:
        super().__init__()
        self.width = jobs
        self._time_limit = TIME_LIMIT if time_limit is None else time_limit
        self._of_thread = threading.local()
        self._changing = threading.Lock()
        self._slots: list[WorkerSlot] = []
        self._stopped = False

    def call(self, function: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Answer[T]:
        """Call a function in this thread's worker, and return the answer.

        Function, arguments and returned value are pickled.

        Raises
        ------
        ExecutorStopped
            If the executor was stopped.
        """
        return self._slot("").call(partial(function, *args, **kwargs))

    def call_at(
        self, site: str, function: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs
    ) -> Answer[T]:
        """Call a function in a worker of this thread that looks for modules in `site` first.

        Raises
        ------
        ExecutorStopped
            If the executor was stopped.
        """
        return self._slot(site).call(partial(function, *args, **kwargs))

    def alone(self) -> Executor:
        """Return an executor that makes one call at a time, in one of this executor's workers.

        If there is no worker that looks for modules in the usual folders, a new one is made. The
        other workers must be idle in the meantime.
        """
        alone = LocalWorkers(1, self._time_limit)
        with self._changing:
            idle = [slot for slot in self._slots if not slot.site]
            slot = idle[0] if idle else WorkerSlot(self._time_limit)
            self._slots += [] if idle else [slot]
        alone._of_thread.slots = {"": slot}
        alone._slots.append(slot)
        return alone

    def stop(self) -> None:
        """Kill the worker processes."""
        with self._changing:
            self._stopped = True
            slots = list(self._slots)
        for slot in slots:
            slot.stop()

    def close(self) -> None:
        """End the worker processes."""
        self.stop()
        for slot in self._slots:
            slot.end()

    def _slot(self, site: str) -> WorkerSlot:
        """Return the slot of this thread's worker process for a site; make one if there is none.

        Raises
        ------
        ExecutorStopped
            If a slot must be made and the executor was stopped.
        """
        slots: dict[str, WorkerSlot] = self._of_thread.__dict__.setdefault("slots", {})
        if site not in slots:
            with self._changing:
                if self._stopped:
                    raise ExecutorStopped
                slots[site] = WorkerSlot(self._time_limit, site)
                self._slots.append(slots[site])
        return slots[site]
