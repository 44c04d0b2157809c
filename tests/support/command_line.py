"""The command line in this process, its runs too."""

import sys
from contextlib import chdir, redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from subprocess import CompletedProcess
from unittest.mock import patch

from spincheck.reports.cli import app, choosing
from spincheck.reports.cli.run import recommend
from spincheck.reports.harness.executors import InProcess


def spincheck(*arguments: object, cwd: Path = Path()) -> CompletedProcess[str]:
    """What `main` prints and exits with; it hears no signals, and starts no process."""
    words = [str(argument) for argument in arguments]
    out, err = StringIO(), StringIO()
    with (
        patch.object(choosing, "LocalWorkers", lambda *_: InProcess()),
        patch.object(recommend, "LocalWorkers", lambda *_: InProcess()),
        patch.object(app, "raise_when_stopped"),
        patch.object(sys, "argv", ["spincheck", *words]),
        chdir(cwd),
        redirect_stdout(out),
        redirect_stderr(err),
    ):
        try:
            app.main()
            code = 0
        except SystemExit as end:
            code = int(end.code or 0)
    return CompletedProcess(words, code, out.getvalue(), err.getvalue())


def ended(*arguments: object, cwd: Path = Path()) -> tuple[int, str, str]:
    """The exit code, and what is on stdout and stderr."""
    done = spincheck(*arguments, cwd=cwd)
    return done.returncode, done.stdout, done.stderr
