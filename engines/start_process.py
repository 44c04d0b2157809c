"""Starts every process that spincheck starts, and makes sure that none is left behind.

Each process is in a process group of its own. Each parent has a small second child, the `guard`,
which kills the groups if the parent is gone without having ended them, as after `kill -9`: a busy
engine does not notice that its parent has died. A worker process that starts an engine has a guard
of its own, so that the engine ends with the worker.
"""

import atexit
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Sequence
from contextlib import suppress
from typing import Any

from . import guard

#: Option of Python with which neither the current folder nor environment variables add modules.
ISOLATED = "-I"
#: Time that a guard may take to end, s.
END_LIMIT = 1.0
_GROUPED: dict[str, Any] = (
    {"creationflags": getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0)}
    if sys.platform == "win32"
    else {"process_group": 0}
)
_KILL = getattr(signal, "SIGKILL", signal.SIGTERM)


def start(command: Sequence[str], **options: Any) -> "subprocess.Popen[Any]":
    """Start a process as `subprocess.Popen` does, in a process group of its own, and return it.

    The caller must pass it to `kill` in the end, even if the process has ended by itself.

    Raises
    ------
    OSError
        If the process or its guard cannot be started.
    """
    _guard.begin()
    process = subprocess.Popen(command, **_GROUPED, **options)
    try:
        _guard.tell(process.pid)
    except OSError:
        kill(process)
        raise
    return process


def kill(process: "subprocess.Popen[Any]") -> int:
    """Kill a process, and all processes left in its group; return the process's exit code."""
    _kill_group(process.pid)
    code = process.wait()
    with suppress(OSError):
        _guard.tell(-process.pid)
    return code


def _kill_group(group: int) -> None:
    """Kill all processes of a group; nothing happens if there is none."""
    with suppress(OSError):
        getattr(os, "killpg", os.kill)(group, _KILL)


def run(command: Sequence[str], limit: float, **options: Any) -> "subprocess.CompletedProcess[str]":
    """Run a command to its end; return its exit code and what it printed.

    Processes that the command has left behind are killed.

    Parameters
    ----------
    command : the program and its arguments
    limit : time that the command may take, s
    options : those of `subprocess.Popen`; by default there is no standard input, and output is
        captured as text

    Raises
    ------
    OSError
        If the command cannot be started.
    subprocess.TimeoutExpired
        If the command takes longer than `limit`.
    """
    pipes: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    pipes |= {"stdin": subprocess.DEVNULL, "text": True, "errors": "replace"} | options
    process = start(command, **pipes)
    try:
        out, err = process.communicate(timeout=limit)
    finally:
        code = kill(process)
    return subprocess.CompletedProcess(command, code, out, err)


class _Guard:
    """The guard of this process: a small process that kills the groups this one leaves behind."""

    def __init__(self) -> None:
        self._groups: set[int] = set()
        self._process: subprocess.Popen[bytes] | None = None
        self._telling = threading.Lock()

    def begin(self) -> None:
        """Start the guard if there is none; call it before starting a process to be guarded."""
        with self._telling:
            self._started()

    def tell(self, group: int) -> None:
        """Tell the guard to guard the process group with id `group` from now on.

        If `group` is −g, group g has ended and is no longer to be guarded.
        """
        with self._telling:
            self._groups = self._groups | {group} if group > 0 else self._groups - {-group}
            if not self._groups and self._process is None:
                return
            try:
                self._write(self._started(), [group])
            except BrokenPipeError:
                # The guard itself was killed: start another and tell it all groups.
                self.end()
                self._write(self._started(), sorted(self._groups))

    def end(self) -> None:
        """End the guard; before it ends, it kills the process groups that have not ended."""
        if self._process is not None:
            assert self._process.stdin is not None, "it is a pipe"
            self._process.stdin.close()
            try:
                self._process.wait(END_LIMIT)
            except subprocess.TimeoutExpired:
                # The machine is busy and the guard has just been started, or somebody has stopped
                # it.
                for group in self._groups:
                    _kill_group(group)
                self._process.kill()
                self._process.wait()
            self._process = None

    def _started(self) -> "subprocess.Popen[bytes]":
        """Return the guard's process; it is started first if there is none."""
        if self._process is None:
            self._process = subprocess.Popen(
                [sys.executable, ISOLATED, "-S", guard.__file__],
                stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                bufsize=0,
                start_new_session=True,
            )
        return self._process

    def _write(self, process: "subprocess.Popen[bytes]", groups: list[int]) -> None:
        """Write process group ids, one a line, to the guard's process; −g says that g has ended."""
        assert process.stdin is not None, "it is a pipe"
        process.stdin.write("".join(f"{group}\n" for group in groups).encode())


_guard = _Guard()
atexit.register(_guard.end)
