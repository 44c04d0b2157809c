"""The interface of executors, which call functions in this process or in worker processes."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from types import TracebackType
from typing import Generic, ParamSpec, Self, TypeVar, final

from ....engines import Cause

P = ParamSpec("P")
T = TypeVar("T")

#: Number of tasks that wait, for each thread: enough to keep all threads busy.
QUEUED_PER_THREAD = 1


@dataclass(frozen=True)
class CallFailed:
    """Why a call has no value: the function raised, or the process crashed, hung or was killed.

    Attributes
    ----------
    reason : what happened, in one sentence
    cause : the cause in one word
    """

    reason: str
    cause: Cause = "bug"


@dataclass(frozen=True, eq=False)
class Answer(Generic[T]):
    """The result of a call.

    Attributes
    ----------
    value : what the function returned, or why it returned nothing
    printed : what was written to stdout and stderr during the call, from Python or C; only the end
        if it is long; empty if the call was made in this process
    """

    value: T | CallFailed
    printed: str = ""


class ExecutorStopped(Exception):
    """The executor was stopped, so that a call has no result."""


class Executor(ABC):
    """Calls functions, at most one at a time for each thread; it is a context manager.

    Attributes
    ----------
    width : largest number of calls that can be under way at once
    """

    width: int = 1

    def __init__(self) -> None:
        self._threads: ThreadPoolExecutor | None = None

    @abstractmethod
    def call(self, function: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Answer[T]:
        """Call a function, wait until it has ended, and return the answer.

        Any thread may do so. The function must be at the top level of a module.

        Raises
        ------
        ExecutorStopped
            If the executor was stopped.
        """

    def call_at(
        self, site: str, function: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs
    ) -> Answer[T]:
        """Call a function in a process that looks for modules in a given folder first.

        The folder has another version of an engine. An executor that has no such processes answers
        with a `CallFailed` of the cause `refused`.

        Parameters
        ----------
        site : the folder; if empty, the call is made as by `call`
        """
        if site:
            return Answer(
                CallFailed("a version of an engine runs in local workers only", "refused")
            )
        return self.call(function, *args, **kwargs)

    @abstractmethod
    def stop(self) -> None:
        """End all calls under way, without waiting for their results; any thread may do so."""

    @abstractmethod
    def close(self) -> None:
        """Free all resources, such as processes; no call may be under way."""

    @abstractmethod
    def alone(self) -> "Executor":
        """Return an executor on this computer that makes one call at a time, for timing.

        The returned executor is closed together with this one. This one must make no call while the
        returned one is used.
        """

    @final
    def each(self, tasks: Iterable[Callable[[], T]]) -> Iterator[T]:
        """Run tasks in threads, and yield the value of each as soon as it has ended.

        A task is a function that runs in this process and makes calls by this executor; `width`
        tasks run at once. They start in the given order, and are taken from the iterable as threads
        become free. If one task raises an exception, the executor is stopped, which ends all other
        tasks, and the exception is raised again here. If `width` is 1, the calling thread runs all
        tasks one after the other, and an exception does not stop the executor.
        """
        if self.width == 1:
            yield from (task() for task in tasks)
            return
        if self._threads is None:
            self._threads = ThreadPoolExecutor(self.width, "spincheck")
        pending: set[Future[T]] = set()
        try:
            for task in tasks:
                pending.add(self._threads.submit(task))
                if len(pending) >= (1 + QUEUED_PER_THREAD) * self.width:
                    done, pending = wait(pending, return_when=FIRST_COMPLETED)
                    yield from (future.result() for future in done)
            while pending:
                done, pending = wait(pending, return_when=FIRST_COMPLETED)
                yield from (future.result() for future in done)
        except BaseException:
            for future in pending:
                future.cancel()
            self.stop()
            raise

    def __enter__(self) -> Self:
        return self

    @final
    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        try:
            if kind is not None:
                self.stop()
            if self._threads is not None:
                self._threads.shutdown(wait=True, cancel_futures=True)
        except BaseException:
            self.stop()
            raise
        finally:
            self.close()
