"""Ends the program on Ctrl-C, SIGTERM, or a terminal that closes (SIGHUP).

The first such signal raises an exception wherever the program is, so that files and processes are
closed. The program ends within a second in any case:

- while a module is being imported, it ends at once: an exception would leave the module half done;
- Python handles signals only between two of its own instructions: if native code runs for too long,
  or closing takes too long, a thread ends the program;
- a second signal ends it at once.

Nothing is lost by that: workers end with their parent (`worker_process`), and a result file is
complete at any moment (`result_file`).
"""

import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from types import FrameType

STDIN, STDOUT, STDERR = 0, 1, 2
#: Time that Python has to handle a signal, s; and time that it then has to close everything, s.
HEARING, ENDING = 0.4, 0.4
#: Windows has no SIGHUP.
_HANGUP: signal.Signals | None = getattr(signal, "SIGHUP", None)
_STOPPING = tuple(n for n in (signal.SIGINT, signal.SIGTERM, _HANGUP) if n is not None)
#: A program ended by a signal exits with this plus the signal's number, as in shells.
_BY_SIGNAL = 128
#: Python's module that imports modules: a frame of it is on the stack while one is being imported.
_IMPORTING = "<frozen importlib._bootstrap>"
#: Terminal codes that show the cursor, which a progress bar hides, and clear the line that it is
#: on.
_CURSOR_AND_EMPTY_LINE = "\x1b[?25h\r\x1b[K"
#: Sentences that `saying` adds to the message that the program was stopped, that of the outermost
#: block first; only the first is printed.
_besides: list[str] = []
_last_words = threading.Lock()
_said = threading.Event()


class Stopped(BaseException):
    """The exception that ends the program after a signal; only the command line catches it."""

    def __init__(self, number: int) -> None:
        super().__init__(f"stopped by {signal.Signals(number).name}")
        self.number = number
        self.exit_code = _BY_SIGNAL + number


@contextmanager
def saying(besides: str) -> Iterator[None]:
    """Add `besides` to the message that is printed if the program is stopped inside the block.

    If blocks are nested, only the text of the outermost one is printed.
    """
    _besides.append(besides)
    try:
        yield
    finally:
        # Kept if the program was stopped: the message is still to be printed.
        if not isinstance(sys.exception(), Stopped):
            _besides.remove(besides)


def say_last_words(number: int) -> None:
    """Print on stderr that the signal `number` stopped the program, and the text from `saying`.

    The message is printed once, even if several threads call this function.
    """
    if not _last_words.acquire(blocking=False):
        # Another thread prints the message. The caller may end the program, so wait for it.
        _said.wait(ENDING)
        return
    last_words = "; ".join([f"spincheck: {Stopped(number)}", *_besides[:1]])
    # Not by `print`, whose lock another thread may hold; and not on a terminal that has closed.
    with suppress(OSError):
        bar_away = _CURSOR_AND_EMPTY_LINE if os.isatty(STDERR) else ""
        os.write(STDERR, f"{bar_away}{last_words}\n".encode(errors="backslashreplace"))
    _said.set()


def raise_when_stopped() -> None:
    """Set handlers, so that signals that stop the program raise `Stopped` from now on.

    Signals that are ignored, as by nohup, stay ignored.
    """
    # Determined now: `isatty` is false once the terminal has closed.
    terminals = [descriptor for descriptor in (STDOUT, STDERR) if os.isatty(descriptor)]

    received = threading.Event()

    def stop(number: int, frame: FrameType | None) -> None:
        received.set()
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
    _watch(obeyed, received)


def _imports(frame: FrameType | None) -> bool:
    """Whether a module is being imported in a stack frame or a caller's; False for None."""
    while frame is not None:
        if frame.f_code.co_filename == _IMPORTING:
            return True
        frame = frame.f_back
    return False


def _watch(obeyed: list[signal.Signals], received: threading.Event) -> None:
    """Start a daemon thread that ends the program if it has not ended in time after a signal.

    Python has `HEARING` s to handle the signal. If it does, the program has another `ENDING` s to
    close everything. No thread is started if no file descriptor is free.

    Parameters
    ----------
    obeyed : the signals that stop the program
    received : an event that is set as soon as Python handles one of these signals
    """
    try:
        wakes, woken = os.pipe()
    except OSError:
        # Without a descriptor, a signal is handled only when native code that is running returns.
        return
    if sys.platform != "win32":
        os.set_blocking(woken, False)
    signal.set_wakeup_fd(woken, warn_on_full_buffer=False)

    def watch() -> None:
        number = 0
        while number not in obeyed:
            (number,) = os.read(wakes, 1)
        if received.wait(HEARING):
            # A daemon thread, so that it ends with the program.
            threading.Event().wait(ENDING)
        say_last_words(number)
        os._exit(_BY_SIGNAL + number)

    threading.Thread(target=watch, name="spincheck-stopping", daemon=True).start()


def _leave(number: int, _: FrameType | None) -> None:
    """End the program at once, with the exit code of the signal `number`.

    Python calls it as a signal handler, with the stack frame as second argument, which is not used.
    """
    os._exit(_BY_SIGNAL + number)


def print_nowhere(*descriptors: int) -> None:
    """Redirect streams, given by their file descriptors, to the null device.

    This is done when the terminal, pipe or file that they write to can no longer be written.
    """
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for descriptor in descriptors:
        os.dup2(nowhere, descriptor)
    os.close(nowhere)


def open_closed_streams() -> None:
    """Open the null device for each standard stream that was closed when the program started.

    Otherwise the next file that is opened would get the descriptor of that stream, and what the
    program prints would go into the file.
    """
    for descriptor in (STDIN, STDOUT, STDERR):
        try:
            os.fstat(descriptor)
        except OSError:
            # Opening a file takes the lowest free descriptor.
            os.open(os.devnull, os.O_RDWR)
    if sys.stdout is None:
        sys.stdout = os.fdopen(STDOUT, "w", closefd=False)
    if sys.stderr is None:
        sys.stderr = os.fdopen(STDERR, "w", closefd=False)
