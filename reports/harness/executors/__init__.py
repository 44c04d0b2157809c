"""Executors, which call functions in this process or in local worker processes."""

from .executor import Answer, CallFailed, Executor, ExecutorStopped
from .in_process import InProcess
from .local_workers import LocalWorkers
from .worker_main import cause_of
from .worker_slot import TIME_LIMIT, cause_of_unsolved, is_environmental, may_succeed_if_repeated

__all__ = [
    "TIME_LIMIT",
    "Answer",
    "CallFailed",
    "Executor",
    "ExecutorStopped",
    "InProcess",
    "LocalWorkers",
    "cause_of",
    "cause_of_unsolved",
    "is_environmental",
    "may_succeed_if_repeated",
]
