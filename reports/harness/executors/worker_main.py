"""The program of a worker process: it takes calls and sends answers until its parent is gone.

`worker_process` starts it. It imports only the standard library, so that it starts quickly; other
modules are imported when a call needs them.
"""

import ctypes
import errno
import io
import json
import os
import pickle
import signal
import struct
import sys
from typing import IO, TYPE_CHECKING

if TYPE_CHECKING:
    from ....engines import Cause

#: Format of the length, in bytes, of the message that follows it.
LENGTH = struct.Struct("<Q")
#: _IONBF of <stdio.h>: no buffer, so that nothing printed before a crash is lost.
UNBUFFERED = 2
#: Fraction of the machine's memory that one worker may use (RLIMIT_DATA of getrlimit(2)).
MEMORY_SHARE = 0.5
#: Error numbers of the operating system for which the machine is to blame, and which may pass.
PASSING = frozenset(
    getattr(errno, name)
    for name in (
        *("ENOSPC", "EDQUOT", "EFBIG", "EROFS", "EIO"),
        *("EMFILE", "ENFILE", "EAGAIN", "ENOMEM", "ENOLCK"),
    )
    if hasattr(errno, name)
)
#: Python's message if the system cannot start another thread.
NO_THREAD = "can't start new thread"


def serve(mark: bytes) -> None:
    """Take calls from the parent process, and answer them, until the parent is gone.

    Parameters
    ----------
    mark : bytes written to standard error at the end of each call, which tell the parent that all
        output has come
    """
    # Ctrl-C may reach this process too; only the parent acts on it.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _bound_memory()
    calls, answers, output = _pipes_of_its_own()
    _print_at_once()
    while True:
        try:
            request = receive(calls)
        except (EOFError, OSError):
            return
        answer = _answer(request)
        os.write(output, mark)
        send(answers, answer)


def send(stream: IO[bytes], message: bytes) -> None:
    """Write a message to a stream, preceded by its length."""
    parts = memoryview(LENGTH.pack(len(message)) + message)
    while parts:
        parts = parts[stream.write(parts) :]


def receive(stream: IO[bytes]) -> bytes:
    """Return the next message in a stream, which `send` has written.

    Raises
    ------
    EOFError
        If the stream ends before the message does.
    """
    (length,) = LENGTH.unpack(_read(stream, LENGTH.size))
    return _read(stream, length)


def _read(stream: IO[bytes], length: int) -> bytes:
    """Return the next `length` bytes; raise `EOFError` if the stream has fewer."""
    parts = bytearray()
    while len(parts) < length:
        part = stream.read(length - len(parts))
        if not part:
            raise EOFError
        parts += part
    return bytes(parts)


def _answer(request: bytes) -> bytes:
    """Make a pickled call, and return three values as one pickle.

    The first is whether the function returned. The second is what it returned, else the error in
    words. The third is the cause of the error in one word, empty if there was none.
    """
    try:
        call = pickle.loads(request)
        return pickle.dumps((True, call(), ""))
    # `sys.exit`, or a panic of Rust's code, is a failure of the call, not the end of the worker. No
    # exception stops a worker: it ignores Ctrl-C.
    except BaseException as error:
        return pickle.dumps((False, error_in_words(error), cause_of(error)))


def error_in_words(error: BaseException) -> str:
    """Return the class of an error and its message; the class alone if there is no message."""
    return f"{type(error).__name__}: {error}".removesuffix(": ")


def cause_of(error: BaseException) -> "Cause":
    """Return, in one word, why a call raised an error.

    It is `killed` if a child process was killed, `environment` if the machine is to blame for the
    error or for one that led to it, else `bug`.
    """
    # The cause of an `EngineError` tells whether the engine's child process was killed.
    if getattr(error, "cause", "") == "killed":
        return "killed"
    at: BaseException | None = error
    while at is not None:
        if _is_passing(at):
            return "environment"
        at = at.__cause__ or at.__context__
    return "bug"


def _is_passing(error: BaseException) -> bool:
    """Whether the machine, not the engine, is to blame for an error, and a retry may succeed."""
    if getattr(error, "cause", "") == "environment":
        return True
    if isinstance(error, OSError):
        return error.errno in PASSING
    if isinstance(error, ImportError):
        # If a library cannot be opened, the loader gives the reason in words only.
        return any(os.strerror(number) in str(error) for number in PASSING)
    if isinstance(error, MemoryError):
        return _is_memory_limited()
    return isinstance(error, RuntimeError) and str(error) == NO_THREAD


def _is_memory_limited() -> bool:
    """Whether a resource limit allows this process less memory than `own_bound` does."""
    if sys.platform == "win32":
        return False
    import resource

    limits = [resource.getrlimit(kind)[0] for kind in (resource.RLIMIT_DATA, resource.RLIMIT_AS)]
    return any(0 <= limit < own_bound() for limit in limits if limit != resource.RLIM_INFINITY)


def _pipes_of_its_own() -> tuple[IO[bytes], IO[bytes], int]:
    """Move calls and answers away from the standard streams, which engines may read or print to.

    After that, standard input is empty, and standard output goes to standard error.

    Returns
    -------
    The stream of calls; the stream of answers; and the file descriptor of a copy of standard error,
    as a call may close the original
    """
    calls, answers = os.fdopen(os.dup(0), "rb", 0), os.fdopen(os.dup(1), "wb", 0)
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.close(nothing)
    os.dup2(2, 1)
    return calls, answers, os.dup(2)


def _bound_memory() -> None:
    """Limit the memory of this process, in case an engine leaks; nothing is done on Windows."""
    if sys.platform == "win32":
        return
    import resource

    bound = own_bound()
    lower, most = resource.getrlimit(resource.RLIMIT_DATA)
    for limit in (lower, most):
        bound = bound if limit == resource.RLIM_INFINITY else min(bound, limit)
    resource.setrlimit(resource.RLIMIT_DATA, (bound, most))


def own_bound() -> int:
    """Return the largest number of bytes of memory that a worker may use."""
    return int(MEMORY_SHARE * os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))


def _print_at_once() -> None:
    """Switch off the output buffers of Python and C, so that nothing is lost in a crash."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(write_through=True)
    if sys.platform == "linux":
        library = ctypes.CDLL(None)
        library.setvbuf(ctypes.c_void_p.in_dll(library, "stdout"), None, UNBUFFERED, 0)


if __name__ == "__main__":
    _, mark_hex, search_path = sys.argv
    # The path is empty if another Python runs this program: that has a path of its own.
    sys.path[:] = json.loads(search_path) or sys.path
    serve(bytes.fromhex(mark_hex))
