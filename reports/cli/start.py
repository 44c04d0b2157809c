"""Starts the command line: Ctrl-C ends it from the first moment on, without a traceback."""

import os
import signal


def main() -> None:
    """Run the command line."""
    # Until the program handles signals itself, the system's default ends it at once. A signal that
    # is ignored, as by nohup, stays ignored.
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    # Set before numpy loads. Matrices are small: a second thread of linear algebra would only wait.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from .app import main as command_line

    command_line()
