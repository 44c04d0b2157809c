"""Starts a command that obeys Ctrl-C, SIGTERM and SIGHUP, however this process was started.

A shell has commands in the background ignore Ctrl-C, and what ignores a signal hands that on to
its children. A program in between undoes it: `preexec_fn` would fork, which a process that has
loaded JAX must not.

    python tests/support/default_signals.py COMMAND [ARGUMENT…]
"""

import fcntl
import os
import signal
import sys
import termios
from contextlib import suppress

#: What stands before a command that is to have the signals' default actions.
WITH_DEFAULT_SIGNALS = (sys.executable, __file__)

if __name__ == "__main__":
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)
    # Its terminal, if it has one that is of no other session, sends it SIGHUP as it closes.
    with suppress(OSError):
        fcntl.ioctl(0, termios.TIOCSCTTY, 0)
    os.execv(sys.argv[1], sys.argv[1:])
