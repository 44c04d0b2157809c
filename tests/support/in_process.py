"""An executor that makes its calls at once, in this process: tests of sweeps start no other."""

from collections.abc import Callable
from concurrent.futures import Executor, Future
from typing import Any

from spincheck.reports.harness.executors.worker_slot import CallFailed


class InProcess(Executor):
    """Loses the calls that an engine is in, as a worker does that the engine takes with it."""

    def __init__(self, deadly: str = "", lost: CallFailed | None = None) -> None:
        self.deadly, self.lost = deadly, lost
        self.calls = 0

    def submit(self, call: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        self.calls += 1
        future: Future[Any] = Future()
        *_, pairs = args
        if self.deadly in [engine.name for engine, _ in pairs]:
            assert self.lost is not None
            future.set_exception(self.lost)
        else:
            future.set_result(call(*args, **kwargs))
        return future
