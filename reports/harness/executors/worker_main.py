"""What a worker process runs: it takes calls and sends answers until its parent is gone.

Started by `worker_process` as a program of its own. It imports only the standard library, so that
it starts at once; what a call needs is imported by the call.
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
#: Errors of the operating system that are not the engine's fault and may pass.
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
    mark : bytes printed at the end of each call, so that the parent knows that all output is there
    """
    # The parent decides what Ctrl-C does, should it reach this process.
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
    """Write a message, preceded by its length."""
    parts = memoryview(LENGTH.pack(len(message)) + message)
    while parts:
        parts = parts[stream.write(parts) :]


def receive(stream: IO[bytes]) -> bytes:
    """Read a message that `send` has written.

    Raises
    ------
    EOFError
        If the stream ends before the message does.
    """
    (length,) = LENGTH.unpack(_read(stream, LENGTH.size))
    return _read(stream, length)


def _read(stream: IO[bytes], length: int) -> bytes:
    """Read `length` bytes; raise `EOFError` if the stream ends before."""
    parts = bytearray()
    while len(parts) < length:
        part = stream.read(length - len(parts))
        if not part:
            raise EOFError
        parts += part
    return bytes(parts)


def _answer(request: bytes) -> bytes:
    """Make a pickled call and return, pickled, three values.

    They are whether the call returned; what it returned, or what it raised in words; and the cause
    of a failure.
    """
    try:
        call = pickle.loads(request)
        return pickle.dumps((True, call(), ""))
    # `sys.exit` in a call is a failure of the call, not the end of the worker.
    except (Exception, SystemExit) as error:
        return pickle.dumps((False, error_in_words(error), cause_of(error)))


def error_in_words(error: BaseException) -> str:
    """Return the class of an error and its message; the class alone if there is no message."""
    return f"{type(error).__name__}: {error}".removesuffix(": ")


def cause_of(error: BaseException) -> "Cause":
    """Return, in one word, why a call raised an error.

    It is `environment` if the machine is to blame, `killed` if a child process was, else `bug`.
    """
    # An `EngineError` has its own cause, as its child may have been killed.
    if getattr(error, "cause", "") == "killed":
        return "killed"
    at: BaseException | None = error
    while at is not None:
        if _is_passing(at):
            return "environment"
        at = at.__cause__ or at.__context__
    return "bug"


def _is_passing(error: BaseException) -> bool:
    """Whether the machine, and not the engine, is to blame for an error, which may then pass."""
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
    """Whether a limit from outside allows this process less memory than `MEMORY_SHARE`."""
    if sys.platform == "win32":
        return False
    import resource

    limits = [resource.getrlimit(kind)[0] for kind in (resource.RLIMIT_DATA, resource.RLIMIT_AS)]
    return any(0 <= limit < own_bound() for limit in limits if limit != resource.RLIM_INFINITY)


def _pipes_of_its_own() -> tuple[IO[bytes], IO[bytes], int]:
    """Move calls and answers away from the standard streams, where an engine may read or print.

    Returns
    -------
    The streams of calls, of answers, and of output: a copy of standard error, as a call may close
    the original.
    """
    calls, answers = os.fdopen(os.dup(0), "rb", 0), os.fdopen(os.dup(1), "wb", 0)
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.close(nothing)
    os.dup2(2, 1)
    return calls, answers, os.dup(2)


def _bound_memory() -> None:
    """Limit the memory of this process, so that an engine that leaks does not take all of it."""
    if sys.platform == "win32":
        return
    import resource

    bound = own_bound()
    lower, most = resource.getrlimit(resource.RLIMIT_DATA)
    for limit in (lower, most):
        bound = bound if limit == resource.RLIM_INFINITY else min(bound, limit)
    resource.setrlimit(resource.RLIMIT_DATA, (bound, most))


def own_bound() -> int:
    """Return the number of bytes that a worker may use."""
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
    # It is None for another Python, which has its own library.
    sys.path[:] = json.loads(search_path) or sys.path
    serve(bytes.fromhex(mark_hex))
