"""An executor in this process in which calls chosen by a test fail."""

from collections.abc import Callable
from typing import Any

from spincheck.reports.harness.executors import Answer, CallFailed, Executor, InProcess

#: What comes of a function and its arguments: why it fails, or None where it is called.
Fault = Callable[[Callable[..., Any], tuple[Any, ...]], CallFailed | None]


class FailingCalls(Executor):
    """Returns a failure for the chosen calls; makes and counts all others.

    Attributes
    ----------
    calls : how many it was asked for
    """

    def __init__(self, fault: Fault = lambda *_: None) -> None:
        super().__init__()
        self._fault, self._within = fault, InProcess()
        self.calls = 0

    def call(self, function, /, *args, **kwargs):
        self.calls += 1
        failure = self._fault(function, args)
        return Answer(failure) if failure else self._within.call(function, *args, **kwargs)

    def alone(self) -> Executor:
        return self

    def stop(self) -> None:
        pass

    def close(self) -> None:
        pass


def of_engine(name: str, failure: CallFailed) -> Fault:
    """The calls that an engine's methods take part in, of an ensemble."""

    def fault(function: Callable[..., Any], args: tuple[Any, ...]) -> CallFailed | None:
        *_, pairs = args
        return failure if name in [engine.name for engine, _ in pairs] else None

    return fault


def of_function(failing: Callable[..., Any], failure: CallFailed) -> Fault:
    """Every call of one function."""
    return lambda function, args: failure if function is failing else None
