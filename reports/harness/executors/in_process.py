"""Calls functions in this process: no process is started, and a crash ends the program."""

from collections.abc import Callable
from typing import ParamSpec, TypeVar, final

from .executor import Answer, CallFailed, Executor, ExecutorStopped
from .worker_main import cause_of, error_in_words

P = ParamSpec("P")
T = TypeVar("T")


@final
class InProcess(Executor):
    """An executor that calls functions in this process; if one crashes, this process ends.

    There is no time limit.
    """

    def __init__(self) -> None:
        super().__init__()
        self._stopped = False

    def call(self, function: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Answer[T]:
        """Call the function in this process, and return its answer.

        Raises
        ------
        ExecutorStopped
            If the executor was stopped.
        """
        if self._stopped:
            raise ExecutorStopped
        try:
            return Answer(function(*args, **kwargs))
        except (Exception, SystemExit) as error:
            return Answer(CallFailed(error_in_words(error), cause_of(error)))

    def alone(self) -> Executor:
        """Return the executor itself, as it makes one call at a time."""
        return self

    def stop(self) -> None:
        """Make no further calls; a call under way runs to its end."""
        self._stopped = True

    def close(self) -> None:
        """Do nothing, as there is nothing to free."""
