"""Kills process groups when the process that started them is gone, however it ended.

It is a program of its own, started by `start_process`. Each line of its standard input is the
number of a process group, with a minus when that group has ended. The input ends when the process
that writes it does.
"""

import os
import signal
import sys
from contextlib import suppress


def main() -> None:
    """Keep a list of process groups until the standard input ends; then kill those in the list.

    Each line is a number: a positive one adds that group to the list, a negative one removes it.
    """
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        if number := getattr(signal, name, None):
            signal.signal(number, signal.SIG_IGN)
    groups: set[int] = set()
    for line in sys.stdin:
        number = int(line)
        if number > 0:
            groups.add(number)
        else:
            groups.discard(-number)
    for group in groups:
        with suppress(OSError):
            # Windows has no groups.
            getattr(os, "killpg", os.kill)(group, getattr(signal, "SIGKILL", signal.SIGTERM))


if __name__ == "__main__":
    main()
