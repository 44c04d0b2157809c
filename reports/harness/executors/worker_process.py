"""The parent's side of a worker process, and of the three pipes to it.

Calls are sent to the worker's standard input, and answers come from its standard output, each as a
length and a pickle. All that is printed comes from its standard error. The worker is started like
any program, and gets only the paths of modules from its parent. So `__main__` is not imported a
second time, and a process that may not have children by `multiprocessing` can have a worker.
"""

import json
import os
import pickle
import secrets
import subprocess
import sys
import threading
from contextlib import suppress
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import IO, Any

import psutil

from ....engines import Cause
from ....engines.lost_process import Overdue, wait_for_answer
from ....engines.start_process import kill, start
from ....engines.versions.folders import interpreter_of
from . import worker_main
from .worker_main import receive, send

#: Number of bytes, from the end, that are kept of what a call printed.
KEPT_OUTPUT = 4096
#: Number of bytes of output read at once: as many as a pipe holds (pipe(7), Linux).
PIPE_SIZE = 1 << 16
#: Time to wait for the rest of the output after a call has answered, s.
OUTPUT_WAIT = 5.0
#: Time that a process which has closed its pipes is given to end by itself, s.
END_WAIT = 1.0
#: Environment variables that set the size of thread pools. Engines step in one thread; idle pools
#: would only spin.
THREAD_COUNTS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "RAYON_NUM_THREADS")
ONE_THREAD = dict.fromkeys(THREAD_COUNTS, "1")


class WorkerProcess:
    """The parent's side of a worker: it starts the process, sends calls and takes answers.

    Parameters
    ----------
    site : folder in which the process looks for modules first; none if empty

    Raises
    ------
    OSError
        If no process can be started.
    """

    def __init__(self, site: str = "") -> None:
        self._mark = secrets.token_bytes(16)
        program, environment = sys.executable, os.environ | ONE_THREAD
        if sys.platform == "win32":
            program, environment = _on_windows()
        path = [site] * bool(site) + sys.path
        if site and interpreter_of(Path(site)).exists():
            program, path = str(interpreter_of(Path(site))), []
        # -P: modules in the current folder do not shadow Python's own. Not -I, with which a package
        # that is installed for the user alone is not found.
        self._process = start(
            [program, "-P", worker_main.__file__, self._mark.hex(), json.dumps(path)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            bufsize=0,
            env=environment,
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
        """Whether the process has not ended yet."""
        return self._process.poll() is None

    def give(self, call: bytes) -> None:
        """Send the worker a pickled call.

        Raises
        ------
        OSError
            If the process is gone.
        """
        self._printed = b""
        self._printed_all.clear()
        send(_raw(self._process.stdin), call)

    def wait(self, limit: float) -> Overdue | None:
        """Wait until the call is answered, the process ends, or the call takes too long.

        Parameters
        ----------
        limit : CPU time that the call may take, s; limits of its wall time follow from it

        Returns
        -------
        Which limit was exceeded; None if there is an answer or the process has ended
        """
        return wait_for_answer(self._has_answered, self._of_system, limit)

    def _has_answered(self, seconds: float) -> bool:
        """Wait some seconds at most; return whether an answer, or the end of the process, came."""
        try:
            self._answer = self._answers.get(timeout=seconds)
        except Empty:
            return False
        return True

    def take(self) -> tuple[bool, Any, Cause]:
        """Return the answer that `wait` has waited for.

        Returns
        -------
        Whether the function returned; what it returned, else the error in words; and the cause of
        the error in one word, empty if there was none

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

    @property
    def is_spent(self) -> bool:
        """Whether the process holds more than half of the memory that it may use.

        An engine must have leaked it, and the process should be replaced. It is false on systems
        other than Linux, which do not tell how much memory a process holds.
        """
        try:
            count = int(getattr(self._of_system.memory_info(), "data", 0))
        except psutil.Error:
            return False
        return count > 0 and 2 * count > worker_main.own_bound()

    def printed(self) -> str:
        """Return what the call has printed; only the end if it is long."""
        return self._printed.replace(self._mark, b"").decode(errors="replace")

    def ends_by_itself(self) -> bool:
        """Wait `END_WAIT` s at most for the process to end; return whether it has ended."""
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(END_WAIT)
        return not self.alive

    def kill(self) -> None:
        """Kill the process, from any thread; `end` must still be called."""
        kill(self._process)

    def end(self) -> int:
        """Kill the process and close its pipes; return its exit code."""
        code = kill(self._process)
        for listener in getattr(self, "_listeners", []):
            if listener.ident is not None:
                listener.join()
        for stream in (self._process.stdin, self._process.stdout, self._process.stderr):
            _raw(stream).close()
        return code

    def _take_answers(self) -> None:
        """Put answers into the queue, and None when the process has ended; runs in a thread."""
        stream = _raw(self._process.stdout)
        try:
            while True:
                self._answers.put(receive(stream))
        except (EOFError, OSError):
            self._answers.put(None)

    def _take_output(self) -> None:
        """Read all that the process prints, and keep the end of it; runs in a thread."""
        descriptor = _raw(self._process.stderr).fileno()
        while received := os.read(descriptor, PIPE_SIZE):
            self._printed = (self._printed + received)[-KEPT_OUTPUT - len(self._mark) :]
            if self._mark in self._printed:
                self._printed_all.set()
        self._printed_all.set()


def _on_windows() -> tuple[str, dict[str, str]]:
    """Return the interpreter and the environment variables that start a worker on Windows.

    In a virtual environment `sys.executable` only launches the real interpreter, as a child whose
    CPU time would not be counted. So the real one is started, as `multiprocessing` does
    (`popen_spawn_win32`).
    """
    program = getattr(sys, "_base_executable", sys.executable)
    environment = os.environ | ONE_THREAD
    if program != sys.executable:
        environment |= {"__PYVENV_LAUNCHER__": sys.executable}
    return program, environment


def _raw(stream: Any) -> IO[bytes]:
    """Return a standard stream of the process, typed as the pipe that it is known to be."""
    assert stream is not None, "all three streams are pipes"
    pipe: IO[bytes] = stream
    return pipe
