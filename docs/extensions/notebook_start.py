"""Gives the notebooks of these pages a `%%bash` that fails where a command fails.

IPython runs it before a page's first cell (PYTHONSTARTUP, set in conf.py). IPython's own magic
breaks lines where its pipe does, and goes on after a command that failed.
"""

import os
import subprocess

from IPython import get_ipython
from IPython.core.error import UsageError


def bash(_: str, cell: str) -> None:
    """Run commands and print what they write to standard output, as to a file: without colours."""
    environment = {name: os.environ[name] for name in os.environ if name != "FORCE_COLOR"}
    command = ["bash", "-euo", "pipefail", "-c", cell]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    print(done.stdout, end="")
    if done.returncode:
        raise UsageError(f"exit code {done.returncode}\n{done.stderr}")


get_ipython().register_magic_function(bash, "cell")
