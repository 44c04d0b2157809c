"""What a worker process runs: it takes calls and sends answers until its parent is gone.

Started by `worker_process` as a program by itself. It imports nothing but the standard library, so
that it is there at once; what a call needs is imported with the call.
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

#: Length of the message that follows, bytes.
LENGTH = struct.Struct("<Q")
#: <stdio.h>, _IONBF: nothing that was printed before a crash is lost in a buffer.
UNBUFFERED = 2
#: <sys/prctl.h>, Linux: choose the signal to be sent when the parent is gone.
PR_SET_PDEATHSIG = 1
#: Of the machine's memory, what one worker may hold (RLIMIT_DATA of getrlimit(2)).
MEMORY_SHARE = 0.5
#: Errors of the operating system that are the machine's fault and pass.
PASSING = frozenset(
    getattr(errno, name)
    for name in (
        *("ENOSPC", "EDQUOT", "EFBIG", "EROFS", "EIO"),
        *("EMFILE", "ENFILE", "EAGAIN", "ENOMEM", "ENOLCK"),
    )
    if hasattr(errno, name)
)


def serve(mark: bytes, parent: int) -> None:
    """Take calls until the parent is gone.

    Parameters
    ----------
    mark : is printed when a call has answered
    parent : its process id
    """
    # Ctrl-C is the parent's to decide on, should it reach this process after all.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _die_with(parent)
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
    """Write a message and its length, whole."""
    parts = memoryview(LENGTH.pack(len(message)) + message)
    while parts:
        parts = parts[stream.write(parts) :]


def receive(stream: IO[bytes]) -> bytes:
    """Read a message that `send` has written.

    Raises
    ------
    EOFError
        If the stream ends before it does.
    """
    (length,) = LENGTH.unpack(_read(stream, LENGTH.size))
    return _read(stream, length)


def _read(stream: IO[bytes], length: int) -> bytes:
    parts = bytearray()
    while len(parts) < length:
        part = stream.read(length - len(parts))
        if not part:
            raise EOFError
        parts += part
    return bytes(parts)


def _answer(request: bytes) -> bytes:
    """Whether a call has returned, what it returned or raised, and the cause, pickled."""
    try:
        call = pickle.loads(request)
        return pickle.dumps((True, call(), ""))
    # A call that exits is a call that failed, not the end of the worker.
    except (Exception, SystemExit) as error:
        return pickle.dumps((False, f"{type(error).__name__}: {error}", cause_of(error)))


def cause_of(error: BaseException) -> "Cause":
    """The cause, one word, of a call that raised."""
    passing = isinstance(error, OSError) and error.errno in PASSING
    return "environment" if passing else "bug"


def _pipes_of_its_own() -> tuple[IO[bytes], IO[bytes], int]:
    """Move calls and answers off the standard streams, where an engine may read or print.

    Returns
    -------
    Calls, answers, and what is printed: the same as standard error, which a call may close.
    """
    calls, answers = os.fdopen(os.dup(0), "rb", 0), os.fdopen(os.dup(1), "wb", 0)
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.close(nothing)
    os.dup2(2, 1)
    return calls, answers, os.dup(2)


def _die_with(parent: int) -> None:
    """Have the system kill this process as soon as its parent's thread is gone, whatever it does.

    See prctl(2), on Linux: the parent is the thread that started this process. Elsewhere it ends
    when its standard input does, once its call has returned.
    """
    if sys.platform != "linux":
        return
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


if __name__ == "__main__":
    _, mark_hex, parent_id, search_path = sys.argv
    sys.path[:] = json.loads(search_path)
    serve(bytes.fromhex(mark_hex), int(parent_id))
