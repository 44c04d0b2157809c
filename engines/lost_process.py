"""Whether a process that died or does not answer failed by its own fault or by the machine's.

The limit is on CPU time, so that a busy machine fails no engine. Wall time tells what waits for
ever; time in which this process was stopped itself (Ctrl-Z, a laptop that was closed) is not
counted.
"""

import signal
import sys
import time
from typing import NamedTuple, Protocol

import psutil

from .fault import Cause

#: What ends a process that does something wrong itself; any other signal comes from outside.
_OWN_SIGNALS = frozenset(
    getattr(signal, name).value
    for name in ("SIGSEGV", "SIGABRT", "SIGFPE", "SIGILL", "SIGBUS", "SIGTRAP", "SIGSYS")
    if hasattr(signal, name)
)
#: Says of a process that somebody else ended it.
KILLED = "was killed from outside"
#: s between two readings of the CPU time of a call.
POLL = 0.5
#: What uses less than this share of the limit, of CPU time, while that goes by on the wall, hangs.
IDLE = 0.01
#: Wall time that a call may take, in time limits, however busy the machine is.
MOST_WALL = 20.0


class Watched(Protocol):
    """A process whose answer is waited for."""

    def has_answered(self, seconds: float) -> bool:
        """Wait until it has answered or is gone, so long at most."""

    def cpu_seconds(self) -> float:
        """CPU time it has used so far, s; 0 once it is gone."""

    def is_stopped(self) -> bool:
        """Whether somebody has stopped it (SIGSTOP), so that it can do nothing."""


class Overdue(NamedTuple):
    """Why an answer is waited for no longer.

    Attributes
    ----------
    words : to go on with "within "
    """

    words: str
    cause: Cause


def wait_for_answer(process: Watched, limit: float) -> Overdue | None:
    """Wait until a process has answered or is gone; None then, and otherwise why it is given up.

    Parameters
    ----------
    limit : CPU seconds that it may take
    """
    wall, begun = 0.0, None
    # When it was last seen to get on, and the CPU time that it had used by then.
    stirred, used_then = 0.0, 0.0
    poll = min(POLL, limit)
    while True:
        before = time.monotonic()
        if process.has_answered(poll):
            return None
        wall += min(time.monotonic() - before, 2 * poll)
        used = process.cpu_seconds()
        # Not before the first wait: to read it takes longer than most calls.
        begun = used if begun is None else begun
        used -= begun
        if used - used_then >= IDLE * limit:
            stirred, used_then = wall, used
        if used > limit:
            return Overdue(f"{limit:g} s of CPU time", "time-out")
        if wall - stirred > limit:
            return _idle(process, limit, used)
        if wall > MOST_WALL * limit:
            words = f"{limit:g} s: {wall:.3g} s went by, {used:.2g} s of CPU time"
            return Overdue(words, "environment")


def _idle(process: Watched, limit: float, used: float) -> Overdue:
    if process.is_stopped():
        return Overdue(f"{limit:g} s: it was stopped from outside", "environment")
    return Overdue(f"{limit:g} s: it hangs, and used {used:.2g} s of CPU time", "time-out")


def death(exit_code: int) -> tuple[str, Cause]:
    """How a process ended that was still to answer, in words and as a cause.

    Parameters
    ----------
    exit_code : as `subprocess` has it, less than zero for a signal
    """
    if exit_code >= 0 or sys.platform == "win32":
        return f"ended with exit code {exit_code}", "crash"
    number = -exit_code
    try:
        name = signal.Signals(number).name
    except ValueError:
        name = f"signal {number}"
    if number in _OWN_SIGNALS:
        return f"was killed by {name}", "crash"
    return f"{KILLED} by {name}", "killed"


def cpu_seconds(process: psutil.Process) -> float:
    """CPU time that a process has used so far, s, with its children; 0 once it is gone."""
    try:
        return sum(sum(one.cpu_times()[:2]) for one in [process, *process.children()])
    except psutil.Error:
        return 0.0


def is_stopped(process: psutil.Process) -> bool:
    """Whether somebody has stopped a process."""
    try:
        return bool(process.status() == psutil.STATUS_STOPPED)
    except psutil.Error:
        return False
