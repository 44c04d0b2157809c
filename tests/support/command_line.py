"""The command line in this process: what it prints, and its exit code."""

import sys
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from io import StringIO
from unittest.mock import patch

from spincheck.reports.cli import app


@dataclass(frozen=True)
class Done:
    exit_code: int
    stdout: str
    stderr: str


def run(*arguments: str) -> Done:
    """Run a command; anything but an exit is a traceback, and is raised."""
    out, err = StringIO(), StringIO()
    with (
        patch.object(sys, "argv", ["spincheck", *arguments]),
        # The signals are pytest's.
        patch.object(app, "raise_when_stopped"),
        redirect_stdout(out),
        redirect_stderr(err),
    ):
        try:
            app.main()
            code = 0
        except SystemExit as ended:
            code = int(ended.code or 0)
    return Done(code, out.getvalue(), err.getvalue())
