"""One worker: a process of its own, and the three pipes to it.

Calls come by its standard input and answers go by its standard output, each as a length and a
pickle; all that is printed goes by its standard error. It is started like any program and knows of
the program that started it only where modules are found: no `__main__` is imported twice, and a
process that may have no children of `multiprocessing`'s, such as a worker of a cluster, may have
this one.
"""

import ctypes
import io
import json
import os
import pickle
import secrets
import signal
import struct
import subprocess
import sys
import threading
from collections.abc import Callable
from queue import Empty, SimpleQueue
from typing import IO, Any

import psutil

from ....engines import Cause
from .executor import cause_of

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
#: s that are waited for the end of what a call printed, once it has answered.
OUTPUT_WAIT = 5.0
#: What libraries start threads by. Engines step in one; others would spin beside it.
THREAD_COUNTS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "RAYON_NUM_THREADS")
_LENGTH = struct.Struct("<Q")
#: What the process runs; its arguments are the mark that ends a call's output, the parent's id, and
#: where modules are found, as JSON.
_PROGRAM = """
import json, sys
sys.path[:] = json.loads(sys.argv[3])
from spincheck.reports.harness.executors.worker_process import serve
serve(bytes.fromhex(sys.argv[1]), int(sys.argv[2]))
"""


class WorkerProcess:
    """The parent's side of it. On Linux it lives no longer than the thread that starts it.

    Raises
    ------
    OSError
        If no process can be started.
    """

    def __init__(self) -> None:
        self._mark = secrets.token_bytes(16)
        # -P: no module of the current folder is taken for one of Python's own. A process group of
        # its own: Ctrl-C is for the program that the user sees, which ends its workers.
        own_group: dict[str, Any] = {"process_group": 0}
        if sys.platform == "win32":
            own_group = {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP}
        arguments = (self._mark.hex(), os.getpid(), json.dumps(sys.path))
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-c", _PROGRAM, *map(str, arguments)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            bufsize=0,
            env=os.environ | dict.fromkeys(THREAD_COUNTS, "1"),
            **own_group,
        )
        try:
            self._of_system = psutil.Process(self._process.pid)
            self._answers: SimpleQueue[bytes | None] = SimpleQueue()
            self._answer: bytes | None = None
            self._printed = b""
            self._printed_all = threading.Event()
            self._listeners = [
                threading.Thread(target=listen, daemon=True)
                for listen in (self._take_answers, self._take_output)
            ]
            for listener in self._listeners:
                listener.start()
        except BaseException as error:
            self.end()
            if isinstance(error, psutil.Error | RuntimeError):
                raise OSError(f"{error}") from None
            raise

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
        self._printed = b""
        self._printed_all.clear()
        try:
            request = pickle.dumps((call, ()))
        except Exception as error:
            # Comes back like a call that failed.
            request = pickle.dumps((_refuse, (f"{type(error).__name__}: {error}",)))
        _send(_raw(self._process.stdin), request)

    def has_answered(self, seconds: float) -> bool:
        """Wait until it has answered or is gone, so long at most."""
        try:
            self._answer = self._answers.get(timeout=seconds)
        except Empty:
            return False
        return True

    def take(self) -> tuple[bool, Any, Cause]:
        """What the call returned, after True, or what it raised, in words, after False; its cause.

        Raises
        ------
        EOFError
            If the process is gone.
        """
        if self._answer is None:
            raise EOFError
        self._printed_all.wait(OUTPUT_WAIT)
        answer: tuple[bool, Any, Cause] = pickle.loads(self._answer)
        return answer

    def printed(self) -> str:
        """What the call has printed, or the end of it."""
        return self._printed.replace(self._mark, b"").decode(errors="replace")

    def cpu_seconds(self) -> float:
        """CPU time it has used so far, s, with its children; 0 once it is gone."""
        try:
            processes = [self._of_system, *self._of_system.children()]
            return sum(sum(process.cpu_times()[:2]) for process in processes)
        except psutil.Error:
            return 0.0

    def kill(self) -> None:
        """Kill it, from whichever thread; `end` is still to be called."""
        self._process.kill()

    def end(self) -> int:
        """Kill it and free its pipes; returns the exit code, its own if it had died before."""
        self._process.kill()
        code = self._process.wait()
        for listener in getattr(self, "_listeners", []):
            if listener.ident is not None:
                listener.join()
        for stream in (self._process.stdin, self._process.stdout, self._process.stderr):
            _raw(stream).close()
        return code

    def _take_answers(self) -> None:
        """A thread: take answers until the process is gone, which is told as None."""
        stream = _raw(self._process.stdout)
        try:
            while True:
                self._answers.put(_receive(stream))
        except (EOFError, OSError):
            self._answers.put(None)

    def _take_output(self) -> None:
        """A thread: take what is printed, however much, and keep the end of it."""
        descriptor = _raw(self._process.stderr).fileno()
        while heard := os.read(descriptor, PIPE_SIZE):
            self._printed = (self._printed + heard)[-KEPT_OUTPUT - len(self._mark) :]
            if self._mark in self._printed:
                self._printed_all.set()
        self._printed_all.set()


def _raw(stream: Any) -> IO[bytes]:
    assert stream is not None, "all three streams are pipes"
    pipe: IO[bytes] = stream
    return pipe


def _send(stream: IO[bytes], message: bytes) -> None:
    parts = memoryview(_LENGTH.pack(len(message)) + message)
    while parts:
        parts = parts[stream.write(parts) :]


def _receive(stream: IO[bytes]) -> bytes:
    (length,) = _LENGTH.unpack(_read(stream, _LENGTH.size))
    return _read(stream, length)


def _read(stream: IO[bytes], length: int) -> bytes:
    parts = bytearray()
    while len(parts) < length:
        part = stream.read(length - len(parts))
        if not part:
            raise EOFError
        parts += part
    return bytes(parts)


def serve(mark: bytes, parent: int) -> None:
    """The process itself: take calls until the parent is gone.

    Parameters
    ----------
    mark : is printed when a call has answered
    parent : its process id
    """
    # Ctrl-C is the parent's to decide on, should it reach this process after all.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _die_with(parent)
    _bound_memory()
    calls, answers = _pipes_of_its_own()
    _print_at_once()
    while True:
        try:
            request = _receive(calls)
        except (EOFError, OSError):
            return
        answer = _answer(request)
        os.write(2, mark)
        _send(answers, answer)


def _pipes_of_its_own() -> tuple[IO[bytes], IO[bytes]]:
    """Move calls and answers off the standard streams, where an engine may read or print."""
    calls, answers = os.fdopen(os.dup(0), "rb", 0), os.fdopen(os.dup(1), "wb", 0)
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.close(nothing)
    os.dup2(2, 1)
    return calls, answers


def _answer(request: bytes) -> bytes:
    try:
        call, arguments = pickle.loads(request)
        return pickle.dumps((True, call(*arguments), ""))
    # A call that exits is a call that failed, not the end of the worker.
    except (Exception, SystemExit) as error:
        return pickle.dumps((False, f"{type(error).__name__}: {error}", cause_of(error)))


def _refuse(reason: str) -> None:
    raise RuntimeError(f"the call cannot be sent to a worker: {reason}")


def _die_with(parent: int) -> None:
    """Have the system kill this process as soon as its parent's thread is gone, whatever it does.

    See prctl(2), on Linux: the parent is the thread that started this process. Elsewhere it ends
    when its standard input does, once its call has returned.
    """
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(1)


def _bound_memory() -> None:
    """Refuse an engine that leaks more memory than `MEMORY_SHARE`, before others have none."""
    if sys.platform == "win32":
        return
    import resource

    bytes_there = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    limit = int(MEMORY_SHARE * bytes_there)
    _, most = resource.getrlimit(resource.RLIMIT_DATA)
    if most != resource.RLIM_INFINITY:
        limit = min(limit, most)
    resource.setrlimit(resource.RLIMIT_DATA, (limit, most))


def _print_at_once() -> None:
    """Have both streams, Python's and C's, write each byte as soon as it is printed."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(write_through=True)
    if sys.platform == "linux":
        library = ctypes.CDLL(None)
        library.setvbuf(ctypes.c_void_p.in_dll(library, "stdout"), None, UNBUFFERED, 0)
