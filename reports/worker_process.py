"""One worker: a spawned process, a pipe to it, and a file that holds all it prints."""

import ctypes
import fcntl
import io
import multiprocessing
import os
import pickle
import signal
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing.connection import Connection
from multiprocessing.reduction import recv_handle, send_handle
from typing import Any

STDOUT, STDERR = 1, 2
#: <stdio.h>, _IONBF: nothing that was printed before a crash is lost in a buffer.
UNBUFFERED = 2
#: <sys/prctl.h>, Linux: choose the signal to be sent when the parent is gone.
PR_SET_PDEATHSIG = 1
#: Bytes of what a call printed that are kept, from its end.
KEPT_OUTPUT = 4096


class WorkerProcess:
    """The parent's side of it."""

    def __init__(self) -> None:
        self._output = tempfile.TemporaryFile(buffering=0)  # noqa: SIM115, closed by `end`
        # Appended to, so that emptying it between calls leaves no hole at its beginning.
        flags = fcntl.fcntl(self._output, fcntl.F_GETFL)
        fcntl.fcntl(self._output, fcntl.F_SETFL, flags | os.O_APPEND)
        # Forking a process that holds engine threads is unsafe; a spawned one starts clean.
        context = multiprocessing.get_context("spawn")
        self.pipe, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs, os.getpid()), daemon=True)
        with _interrupts_held_back():
            self._process.start()
        theirs.close()
        send_handle(self.pipe, self._output.fileno(), self._process.pid)

    @property
    def alive(self) -> bool:
        """Whether the process is there."""
        return self._process.is_alive()

    def give(self, call: Callable[..., Any], arguments: tuple[Any, ...]) -> None:
        """Let it call.

        Raises
        ------
        OSError
            If the process is gone.
        """
        self._output.truncate(0)
        try:
            request = pickle.dumps((call, arguments))
        except Exception as error:
            # Comes back like a call that failed.
            request = pickle.dumps((_refuse, (f"{type(error).__name__}: {error}",)))
        self.pipe.send_bytes(request)

    def take(self) -> tuple[bool, Any]:
        """Wait for what the call returned, after True, or what it raised, in words, after False.

        Raises
        ------
        EOFError, OSError
            If the process is gone.
        """
        answer: tuple[bool, Any] = pickle.loads(self.pipe.recv_bytes())
        return answer

    def printed(self) -> str:
        """What the call has printed, or the end of it."""
        size = os.fstat(self._output.fileno()).st_size
        kept = os.pread(self._output.fileno(), KEPT_OUTPUT, max(size - KEPT_OUTPUT, 0))
        return kept.decode(errors="replace")

    def end(self) -> int:
        """Make an end of it; returns the exit code, its own if it had died before."""
        self._process.kill()
        self._process.join()
        self.pipe.close()
        self._output.close()
        return self._process.exitcode or 0


@contextmanager
def _interrupts_held_back() -> Iterator[None]:
    """Let Ctrl-C wait: a process being started inherits this, and is not hit before it is ready."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _serve(pipe: Connection, parent: int) -> None:
    """The process itself: take calls until the parent is gone."""
    # Ctrl-C reaches the whole process group; what it means is the parent's to decide.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _die_with(parent)
    _print_to(recv_handle(pipe))
    while True:
        try:
            request = pipe.recv_bytes()
        except (EOFError, OSError):
            return
        pipe.send_bytes(_answer(request))


def _answer(request: bytes) -> bytes:
    try:
        call, arguments = pickle.loads(request)
        return pickle.dumps((True, call(*arguments)))
    # A call that exits is a call that failed, not the end of the worker.
    except (Exception, SystemExit) as error:
        return pickle.dumps((False, f"{type(error).__name__}: {error}"))


def _refuse(reason: str) -> None:
    raise RuntimeError(f"the call cannot be sent to a worker: {reason}")


def _die_with(parent: int) -> None:
    """Have the system kill this process as soon as its parent is gone, whatever it is doing."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(1)


def _print_to(output: int) -> None:
    """Send both streams, Python's and C's, to a file, each byte as soon as it is written."""
    for descriptor in (STDOUT, STDERR):
        os.dup2(output, descriptor)
    os.close(output)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(write_through=True)
    if sys.platform == "linux":
        library = ctypes.CDLL(None)
        library.setvbuf(ctypes.c_void_p.in_dll(library, "stdout"), None, UNBUFFERED, 0)
