"""Runs calls in worker processes that may crash, hang or print without harming the study.

Pebble replaces a worker that dies or overruns its time; here that is put into words.
"""

import multiprocessing
import signal
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Self

from pebble import ProcessExpired, ProcessPool

#: s; a run of the largest ladder takes a few seconds.
TIME_LIMIT = 120.0


@dataclass(frozen=True)
class Lost:
    """A call that gave no result, and why."""

    reason: str


class Workers:
    """A pool of spawned processes, each taking one call at a time."""

    def __init__(self, jobs: int) -> None:
        # Forking a process that holds engine threads is unsafe; a spawned one starts clean.
        self._pool = ProcessPool(jobs, context=multiprocessing.get_context("spawn"))
        self._time_limit = TIME_LIMIT

    def submit(self, call: Callable[..., Any], *arguments: Any) -> Future[Any]:
        """Schedule a call; its arguments and result are pickled."""
        future: Future[Any] = self._pool.schedule(call, args=arguments, timeout=self._time_limit)
        return future

    def result(self, future: Future[Any]) -> Any:
        """What a finished call returned, or `Lost` if it crashed, hung or raised."""
        try:
            return future.result()
        except TimeoutError:
            return Lost(f"did not finish within {self._time_limit:g} s")
        except ProcessExpired as error:
            return Lost(_cause_of_death(error.exitcode))
        except Exception as error:
            return Lost(f"{type(error).__name__}: {error}")

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        if error is None:
            self._pool.close()  # type: ignore[no-untyped-call]
        else:
            self._pool.stop()  # type: ignore[no-untyped-call]
        self._pool.join()


def _cause_of_death(exit_code: int) -> str:
    if exit_code >= 0:
        return f"the worker process ended with exit code {exit_code}"
    return f"the worker process was killed by {signal.Signals(-exit_code).name}"
