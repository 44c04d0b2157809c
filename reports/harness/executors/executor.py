"""The interface of executors: each makes calls, in this process or in workers."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from types import TracebackType
from typing import Generic, ParamSpec, Self, TypeVar, final

from ....engines import Cause

P = ParamSpec("P")
T = TypeVar("T")

#: Number of tasks waiting for a thread, for each running task: enough to keep all threads busy.
QUEUED_PER_THREAD = 1


@dataclass(frozen=True)
class CallFailed:
    """The answer of a call that returned nothing: it raised, crashed, hung, or was killed.

    Attributes
    ----------
    reason : why, in one sentence
    cause : the cause in one word
    """

    reason: str
    cause: Cause = "bug"


@dataclass(frozen=True, eq=False)
class Answer(Generic[T]):
    """The result of a call.

    Attributes
    ----------
    value : what the call returned, or why it returned nothing
    printed : what the call wrote to stdout and stderr, from Python or C; only the end if it is long
    """

    value: T | CallFailed
    printed: str = ""


class ExecutorStopped(Exception):
    """The executor was stopped: the call under way, or any later call, has no result."""


class Executor(ABC):
    """Makes calls, several at a time from several threads; it is a context manager.

    Attributes
    ----------
    width : number of calls that can be under way at once
    """

    width: int = 1

    def __init__(self) -> None:
        self._threads: ThreadPoolExecutor | None = None

    @abstractmethod
    def call(self, function: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Answer[T]:
        """Call a function of a module, wait, and return the answer. May be called from any thread.

        Raises
        ------
        ExecutorStopped
            If the executor was stopped.
        """

    def call_at(
        self, site: str, function: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs
    ) -> Answer[T]:
        """Call a function in a process that imports modules from a folder first.

        This is for an engine at another version. An executor that cannot do it answers
        `CallFailed`, with the cause `refused`.

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
        """End all calls under way at once. May be called from any thread."""

    @abstractmethod
    def close(self) -> None:
        """Free processes and connections, once no call is under way."""

    @abstractmethod
    def alone(self) -> "Executor":
        """Return an executor on this computer that makes one call at a time, for timing.

        The returned executor is closed together with this one. This one must make no call while the
        returned one is used.
        """

    @final
    def each(self, tasks: Iterable[Callable[[], T]]) -> Iterator[T]:
        """Run tasks in threads, started in their order, and yield what they return as they end.

        A task is a function that runs in this process and makes calls by this executor; `width`
        tasks run at once. Tasks are taken from the iterable as threads become free. An exception in
        one task stops the executor, and with it all other tasks, and is raised. If `width` is 1,
        the calling thread runs all tasks one after the other, and an exception is only raised.
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
