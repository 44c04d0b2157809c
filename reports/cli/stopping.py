"""What stops the program from outside: Ctrl-C, SIGTERM, a terminal that closes.

The first such signal is an exception, wherever the program is; a second one ends it at once, since
whatever it is doing then takes too long. So does the first one where Python does not hear of it,
which it does between two steps of its own: a query or an archive may be a single one. Workers end
with their parent (`worker_process`), and a result file is whole at any moment (`result_file`).
"""

import os
import signal
import sys
import threading
from contextlib import suppress
from types import FrameType

STDIN, STDOUT, STDERR = 0, 1, 2
#: s, in which Python has to hear of a signal, and in which everything has to be put away then.
HEARING, ENDING = 0.5, 10.0
#: Windows has no SIGHUP.
_HANGUP: signal.Signals | None = getattr(signal, "SIGHUP", None)
_STOPPING = tuple(n for n in (signal.SIGINT, signal.SIGTERM, _HANGUP) if n is not None)
#: Exit codes of what a signal ended, as shells have it: this and the signal's number.
_BY_SIGNAL = 128


class Stopped(BaseException):
    """The program is to end; nobody but the command line catches it."""

    def __init__(self, number: int) -> None:
        super().__init__(f"stopped by {signal.Signals(number).name}")
        self.exit_code = _BY_SIGNAL + number


def raise_when_stopped() -> None:
    """From now on the signals raise `Stopped`, but those that were to be ignored, as by nohup."""
    # Asked now: `isatty` is false of a terminal that has closed.
    terminals = [descriptor for descriptor in (STDOUT, STDERR) if os.isatty(descriptor)]

    heard = threading.Event()

    def stop(number: int, _: FrameType | None) -> None:
        heard.set()
        for each in obeyed:
            signal.signal(each, _leave)
        if number == _HANGUP:
            print_nowhere(*terminals)
        raise Stopped(number)

    obeyed = [each for each in _STOPPING if signal.getsignal(each) != signal.SIG_IGN]
    for each in obeyed:
        signal.signal(each, stop)
    _watch(obeyed, heard)


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
        else:
            with suppress(OSError):
                os.write(STDERR, f"spincheck: {Stopped(number)}\n".encode())
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
