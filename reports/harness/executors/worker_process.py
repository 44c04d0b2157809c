"""One worker: a process of its own, a socket to it, and a pipe that takes all it prints.

It is started like any program, by its path, and knows nothing of the program that started it but
where modules are found: no `__main__` is imported twice, and a process that may have no children
of `multiprocessing`'s, such as a worker of a cluster, may have this one.
"""

import ctypes
import io
import os
import pickle
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing import Pipe
from multiprocessing.connection import Connection, wait
from typing import Any

#: <stdio.h>, _IONBF: nothing that was printed before a crash is lost in a buffer.
UNBUFFERED = 2
#: <sys/prctl.h>, Linux: choose the signal to be sent when the parent is gone.
PR_SET_PDEATHSIG = 1
#: Bytes of what a call printed that are kept, from its end.
KEPT_OUTPUT = 4096
#: Of the machine's memory, what one worker may hold (RLIMIT_DATA of getrlimit(2)).
MEMORY_SHARE = 0.5
#: Bytes read at once of what is printed: as many as a pipe holds (pipe(7), Linux).
PIPE_SIZE = 1 << 16
#: What the process runs; its arguments are the socket's descriptor and the parent's id.
_PROGRAM = """
import pickle, sys
from multiprocessing.connection import Connection
pipe = Connection(int(sys.argv[1]))
sys.path[:] = pickle.loads(pipe.recv_bytes())
from .worker_process import serve
serve(pipe, int(sys.argv[2]))
"""


class WorkerProcess:
    """The parent's side of it. It lives no longer than the thread that starts it."""

    def __init__(self) -> None:
        # A pipe, not a file: however much is printed, nothing fills up.
        self._output, prints = os.pipe()
        os.set_blocking(self._output, False)
        self._printed = b""
        self._pipe, theirs = Pipe()
        # -P: no module of the current folder is taken for one of Python's own.
        command = [sys.executable, "-P", "-c", _PROGRAM, str(theirs.fileno()), str(os.getpid())]
        with theirs, _interrupts_held_back():
            self._process = subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=prints,
                stderr=prints,
                pass_fds=[theirs.fileno()],
            )
        os.close(prints)
        self._pipe.send_bytes(pickle.dumps(sys.path))

    @property
    def alive(self) -> bool:
        """Whether the process is there."""
        return self._process.poll() is None

    def give(self, call: Callable[[], Any]) -> None:
        """Let it call.

        Raises
        ------
        OSError
            If the process is gone.
        """
        self._listen()
        self._printed = b""
        try:
            request = pickle.dumps((call, ()))
        except Exception as error:
            # Comes back like a call that failed.
            request = pickle.dumps((_refuse, (f"{type(error).__name__}: {error}",)))
        self._pipe.send_bytes(request)

    def has_answered(self, seconds: float) -> bool:
        """Wait until it has answered or is gone, so long at most; and listen meanwhile."""
        deadline = time.monotonic() + seconds
        sources: list[Any] = [self._pipe, self._output]
        while True:
            ready = wait(sources, max(0.0, deadline - time.monotonic()))
            if self._output in ready and not self._listen():
                # It has closed its output; what is at its end is ready for ever.
                sources.remove(self._output)
            if self._pipe in ready:
                return True
            if time.monotonic() >= deadline:
                return False

    def take(self) -> tuple[bool, Any]:
        """Wait for what the call returned, after True, or what it raised, in words, after False.

        Raises
        ------
        EOFError, OSError
            If the process is gone.
        """
        answer: tuple[bool, Any] = pickle.loads(self._pipe.recv_bytes())
        return answer

    def printed(self) -> str:
        """What the call has printed, or the end of it."""
        self._listen()
        return self._printed.decode(errors="replace")

    def kill(self) -> None:
        """Put an end to it, from whichever thread; `end` is still to be called."""
        self._process.kill()

    def end(self) -> int:
        """Make an end of it; returns the exit code, its own if it had died before."""
        self._process.kill()
        code = self._process.wait()
        self._pipe.close()
        os.close(self._output)
        return code

    def _listen(self) -> bool:
        """Take what the pipe holds, and of all that was printed keep the end; False at its end."""
        try:
            heard = os.read(self._output, PIPE_SIZE)
        except BlockingIOError:
            return True
        self._printed = (self._printed + heard)[-KEPT_OUTPUT:]
        return bool(heard)


@contextmanager
def _interrupts_held_back() -> Iterator[None]:
    """Let Ctrl-C wait: a process being started inherits this, and is not hit before it is ready."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def serve(pipe: Connection, parent: int) -> None:
    """The process itself: take calls until the parent is gone."""
    # Ctrl-C reaches the whole process group; what it means is the parent's to decide.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _die_with(parent)
    _bound_memory()
    os.set_inheritable(pipe.fileno(), False)
    _print_at_once()
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
    """Have the system kill this process as soon as its parent's thread is gone, whatever it does.

    See prctl(2): the parent is the thread that started this process.
    """
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(1)


def _bound_memory() -> None:
    """Refuse an engine that leaks more memory than `MEMORY_SHARE`, before others have none."""
    bytes_there = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    _, most = resource.getrlimit(resource.RLIMIT_DATA)
    resource.setrlimit(resource.RLIMIT_DATA, (int(MEMORY_SHARE * bytes_there), most))


def _print_at_once() -> None:
    """Have both streams, Python's and C's, write each byte as soon as it is printed."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(write_through=True)
    if sys.platform == "linux":
        library = ctypes.CDLL(None)
        library.setvbuf(ctypes.c_void_p.in_dll(library, "stdout"), None, UNBUFFERED, 0)
