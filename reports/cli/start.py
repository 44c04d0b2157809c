"""Starts the command line: Ctrl-C ends it from the first moment on, without a traceback."""

import os
import signal


def main() -> None:
    """Run the command line."""
    # Default handlers, until the program handles signals itself. Signals that are ignored, as by
    # nohup, stay so.
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    # Set before numpy loads. Matrices are small: a second thread of linear algebra only spins.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from .app import main as command_line

    command_line()
