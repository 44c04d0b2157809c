"""What stops the program from outside: Ctrl-C, being told to end, a terminal that closes.

The first such signal is an exception, wherever the program is; a second one ends it at once, since
whatever it is doing then takes too long. Workers end with their parent (`worker_process`), and a
result file is whole at any moment (`result_file`).
"""

import os
import signal
from types import FrameType

STDOUT, STDERR = 1, 2
_STOPPING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
#: Exit codes of what a signal ended, as shells have it: this and the signal's number.
_BY_SIGNAL = 128


class Stopped(BaseException):
    """The program is to end; nobody but the command line catches it."""

    def __init__(self, number: int) -> None:
        super().__init__(f"stopped by {signal.Signals(number).name}")
        self.exit_code = _BY_SIGNAL + number


def raise_when_stopped() -> None:
    """From now on the signals raise `Stopped`, but those that were to be ignored, as by nohup."""
    # Once it has closed, a terminal is none.
    terminals = [descriptor for descriptor in (STDOUT, STDERR) if os.isatty(descriptor)]

    def stop(number: int, _: FrameType | None) -> None:
        for each in heard:
            signal.signal(each, _leave)
        if number == signal.SIGHUP:
            _print_nowhere(terminals)
        raise Stopped(number)

    heard = [each for each in _STOPPING if signal.getsignal(each) != signal.SIG_IGN]
    for each in heard:
        signal.signal(each, stop)


def _leave(number: int, _: FrameType | None) -> None:
    os._exit(_BY_SIGNAL + number)


def _print_nowhere(descriptors: list[int]) -> None:
    """Nobody reads these any more, and writing to them is an error."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for descriptor in descriptors:
        os.dup2(nowhere, descriptor)
    os.close(nowhere)
