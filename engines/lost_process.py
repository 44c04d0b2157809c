"""Decides whether the process or the machine is to blame if a process dies or does not answer.

An answer may take a limited CPU time, so that no engine fails because the machine is busy. A
process that waits for ever is detected by wall time. Wall time in which this process itself was
stopped (Ctrl-Z, a closed laptop) is not counted.
"""

import signal
import sys
import time
from collections.abc import Callable
from typing import NamedTuple

import psutil

from ..scenarios import printable
from .fault import Cause

#: Signals caused by faults of the process itself; any other signal comes from outside.
_OWN_SIGNALS = frozenset(
    getattr(signal, name).value
    for name in ("SIGSEGV", "SIGABRT", "SIGFPE", "SIGILL", "SIGBUS", "SIGTRAP", "SIGSYS")
    if hasattr(signal, name)
)
#: Largest number of characters that a message quotes of the last line that a process printed.
LAST_LINE = 200
#: Beginning of the message that a process was killed by another one.
KILLED = "was killed from outside"
#: Time between two readings of the CPU time that a call has used, s.
POLL = 0.5
#: A process hangs if it uses less CPU time than this fraction of the limit, during a wall time as
#: long as the limit.
IDLE = 0.01
#: Largest wall time of a call, in multiples of its limit of CPU time, however busy the machine is.
MOST_WALL = 20.0


class Overdue(NamedTuple):
    """The reason why waiting for an answer was given up.

    Attributes
    ----------
    words : the limit that was exceeded; they complete a message "did not answer within …"
    cause : the reason in one word
    """

    words: str
    cause: Cause


def wait_for_answer(
    has_answered: Callable[[float], bool], process: psutil.Process, limit: float
) -> Overdue | None:
    """Wait until a process has answered or ended; return why, if waiting had to be given up.

    None is returned if the process has answered or ended.

    Parameters
    ----------
    has_answered : waits for the given number of seconds at most, and returns whether the process
        has answered or ended
    process : the process, whose CPU time is read
    limit : CPU time that the answer may take, s
    """
    wall, begun = 0.0, None
    # Wall time and CPU time at which the process was last seen to make progress, s.
    stirred, used_then = 0.0, 0.0
    poll = min(POLL, limit)
    while True:
        before = time.monotonic()
        if has_answered(poll):
            return None
        wall += min(time.monotonic() - before, 2 * poll)
        used = _cpu_seconds(process)
        # First read after a wait: most calls take less time than reading it.
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


def _idle(process: psutil.Process, limit: float, used: float) -> Overdue:
    """Return why a process that makes no progress is given up: it is stopped, or it hangs.

    Parameters
    ----------
    limit : CPU time that the process's answer may take, s
    used : CPU time that the process has used for this answer so far, s
    """
    if _is_stopped(process):
        return Overdue(f"{limit:g} s: it was stopped from outside", "environment")
    return Overdue(f"{limit:g} s: it hangs, and used {used:.2g} s of CPU time", "time-out")


def death(exit_code: int) -> tuple[str, Cause]:
    """Return how a process ended, in words that follow a subject ("was killed …"), and the cause.

    Parameters
    ----------
    exit_code : exit code as `subprocess` reports it: −n if signal n ended the process
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


def last_line(printed: str) -> str:
    """Return words that quote the last line that a process printed; empty if it printed nothing.

    They are to be appended to the message that says how the process ended.

    Parameters
    ----------
    printed : all that the process printed
    """
    lines = printed.strip().splitlines()
    if lines and lines[-1].startswith("Node.js v"):
        # After the error that ends it, node prints a line with its version.
        lines = [line for line in lines if "Error" in line] or lines
    return f"; it last printed: {printable(lines[-1][-LAST_LINE:])}" if lines else ""


def _cpu_seconds(process: psutil.Process) -> float:
    """Return the CPU time used by a process and its children, s; 0 if the process is gone."""
    try:
        return sum(sum(one.cpu_times()[:2]) for one in [process, *process.children()])
    except psutil.Error:
        return 0.0


def _is_stopped(process: psutil.Process) -> bool:
    """Whether a process is stopped by a signal such as SIGSTOP."""
    try:
        return bool(process.status() == psutil.STATUS_STOPPED)
    except psutil.Error:
        return False
