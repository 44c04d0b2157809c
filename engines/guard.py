"""Kills process groups when the process that started them is gone, however it ended.

It is a program of its own, started by `start_process`. Each line of its standard input is the id of
a process group: positive if the group is to be guarded, negative if it has ended. The input ends
when the process that writes to it ends.
"""

import os
import signal
import sys
from contextlib import suppress


def main() -> None:
    """Keep a set of process groups until the standard input ends; then kill those in the set.

    A line with g > 0 adds the group with id g to the set; a line with −g removes it.
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
            # Windows has no process groups: the process itself is killed.
            getattr(os, "killpg", os.kill)(group, getattr(signal, "SIGKILL", signal.SIGTERM))


if __name__ == "__main__":
    main()
