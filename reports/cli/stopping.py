"""What stops the program from outside: Ctrl-C, SIGTERM, a terminal that closes.

The first such signal is an exception, wherever the program is, so that what it holds is put away.
It ends within a second all the same: at once where a module is being imported, which an exception
leaves half done; and by a thread that waits for it where Python does not hear of the signal, which
it does between two steps of its own, or where it takes longer to end. A second signal ends it at
once. Nothing is lost by that: workers end with their parent (`worker_process`), and a result file
is whole at any moment (`result_file`).
"""

import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from types import FrameType

STDIN, STDOUT, STDERR = 0, 1, 2
#: s, in which Python has to hear of a signal, and in which everything has to be put away then.
HEARING, ENDING = 0.4, 0.4
#: Windows has no SIGHUP.
_HANGUP: signal.Signals | None = getattr(signal, "SIGHUP", None)
_STOPPING = tuple(n for n in (signal.SIGINT, signal.SIGTERM, _HANGUP) if n is not None)
#: Exit codes of what a signal ended, as shells have it: this and the signal's number.
_BY_SIGNAL = 128
#: Where Python runs what imports modules.
_IMPORTING = "<frozen importlib._bootstrap>"
#: Brings back the cursor, which a progress bar hides, and clears the line that it is on.
_CURSOR_AND_EMPTY_LINE = "\x1b[?25h\r\x1b[K"
#: The last words' second half, while there is something to say there; who says it first knows best
#: what the command was asked for.
_besides: list[str] = []
_last_words = threading.Lock()


class Stopped(BaseException):
    """The program is to end; nobody but the command line catches it."""

    def __init__(self, number: int) -> None:
        super().__init__(f"stopped by {signal.Signals(number).name}")
        self.number = number
        self.exit_code = _BY_SIGNAL + number


@contextmanager
def saying(besides: str) -> Iterator[None]:
    """Have the program say this besides, if it is stopped in here."""
    _besides.append(besides)
    try:
        yield
    finally:
        # Not where it is stopped: its last words are still to come.
        if not isinstance(sys.exception(), Stopped):
            _besides.remove(besides)


def say_last_words(number: int) -> None:
    """Tell, once, by what the program was stopped; whoever is the first says it."""
    if not _last_words.acquire(blocking=False):
        return
    last_words = "; ".join([f"spincheck: {Stopped(number)}", *_besides[:1]])
    # Not by `print`, whose lock somebody may hold; on a terminal that has closed by nobody.
    with suppress(OSError):
        bar_away = _CURSOR_AND_EMPTY_LINE if os.isatty(STDERR) else ""
        os.write(STDERR, f"{bar_away}{last_words}\n".encode(errors="backslashreplace"))


def raise_when_stopped() -> None:
    """From now on the signals raise `Stopped`, but those that were to be ignored, as by nohup."""
    # Asked now: `isatty` is false of a terminal that has closed.
    terminals = [descriptor for descriptor in (STDOUT, STDERR) if os.isatty(descriptor)]

    heard = threading.Event()

    def stop(number: int, frame: FrameType | None) -> None:
        heard.set()
        for each in obeyed:
            signal.signal(each, _leave)
        if number == _HANGUP:
            print_nowhere(*terminals)
        if _imports(frame):
            say_last_words(number)
            _leave(number, frame)
        raise Stopped(number)

    obeyed = [each for each in _STOPPING if signal.getsignal(each) != signal.SIG_IGN]
    for each in obeyed:
        signal.signal(each, stop)
    _watch(obeyed, heard)


def _imports(frame: FrameType | None) -> bool:
    while frame is not None:
        if frame.f_code.co_filename == _IMPORTING:
            return True
        frame = frame.f_back
    return False


def _watch(obeyed: list[signal.Signals], heard: threading.Event) -> None:
    """Have a thread end the program where a signal is not heard, or ending takes too long."""
    try:
        wakes, woken = os.pipe()
    except OSError:
        # Without a descriptor to spare, a signal waits for the end of a query.
        return
    os.set_blocking(woken, False)
    signal.set_wakeup_fd(woken, warn_on_full_buffer=False)

    def watch() -> None:
        number = 0
        while number not in obeyed:
            (number,) = os.read(wakes, 1)
        if heard.wait(HEARING):
            # Ends with the program, as a rule long before.
            threading.Event().wait(ENDING)
        say_last_words(number)
        os._exit(_BY_SIGNAL + number)

    threading.Thread(target=watch, name="spincheck-stopping", daemon=True).start()


def _leave(number: int, _: FrameType | None) -> None:
    os._exit(_BY_SIGNAL + number)


def print_nowhere(*descriptors: int) -> None:
    """Point streams at the null device: nobody reads them, and writing would raise."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for descriptor in descriptors:
        os.dup2(nowhere, descriptor)
    os.close(nowhere)


def open_closed_streams() -> None:
    """Read from nowhere, and print nowhere, where a standard stream was closed from the start.

    The first file that is opened would take its number, and what is printed would go there.
    """
    for descriptor in (STDIN, STDOUT, STDERR):
        try:
            os.fstat(descriptor)
        except OSError:
            # Takes the least number that is free.
            os.open(os.devnull, os.O_RDWR)
    if sys.stdout is None:
        sys.stdout = os.fdopen(STDOUT, "w", closefd=False)
    if sys.stderr is None:
        sys.stderr = os.fdopen(STDERR, "w", closefd=False)
