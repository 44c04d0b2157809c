"""Functions for workers to call in tests; only the standard library is imported, to start fast."""

import ctypes
import errno
import mmap
import os
import signal
import sys
import time
from pathlib import Path


def power(base: int, *, exponent: int = 2) -> int:
    return base**exponent


def divide_by_zero() -> None:
    raise ZeroDivisionError("a bug in an adapter")


def find_the_disk_full() -> None:
    raise OSError(errno.ENOSPC, "No space left on device")


def leave_politely() -> None:
    raise SystemExit(3)


class Panic(BaseException):
    """As a panic of Rust's code is in Python."""


def throw(error: type[BaseException]) -> None:
    raise error("thrown")


def mark_and_wait(mark: Path, end: Path) -> None:
    """Make the first file, and wait until there is the second."""
    mark.touch()
    while not end.exists():
        time.sleep(0.01)


def spin() -> None:
    """Use CPU time for ever."""
    while True:
        pass


def crash() -> None:
    ctypes.string_at(0)


def abort_after_c_printed(text: str) -> None:
    ctypes.CDLL(None).printf(text.encode())
    os.abort()


def close_everything(seconds: float) -> None:
    os.closerange(0, 256)
    time.sleep(seconds)


def leave_at_once(code: int) -> None:
    os._exit(code)


def killed_by(number: int, mark: Path | None = None) -> str:
    """Sent a signal, as if from outside; where a mark is given, once."""
    if mark is None or not mark.exists():
        if mark:
            mark.touch()
        os.kill(os.getpid(), number)
    return "second attempt"


def killed_once(mark: Path) -> str:
    return killed_by(signal.SIGKILL, mark)


def unpicklable() -> object:
    return lambda: None


def say(text: str) -> int:
    if sys.platform == "linux":
        ctypes.CDLL(None).puts(b"from C")
    print(text)
    return 1


def megabytes(count: int) -> bytes:
    return bytes(count << 20)


def print_megabytes(count: int) -> None:
    for _ in range(count):
        os.write(1, bytes(1 << 20))
    os.write(1, b"the end")


def print_for_ever() -> None:
    while True:
        os.write(1, bytes(1 << 20))


def close_its_output() -> str:
    os.close(1)
    os.close(2)
    return "done"


LEAKED = []


def leak(share: float) -> int:
    """Of the machine's memory, as an engine does that frees nothing; its process's number."""
    bytes_there = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    kept = mmap.mmap(-1, int(share * bytes_there), mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
    LEAKED.append(kept)
    return os.getpid()


def hold(share: float) -> int:
    """Of the machine's memory; the system gives what is not written to on credit."""
    bytes_there = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    return len(mmap.mmap(-1, int(share * bytes_there), mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS))
