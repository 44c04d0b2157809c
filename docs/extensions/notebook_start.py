"""Gives the notebooks of these pages the cell magics `%%bash` and `%%writefile`.

IPython runs this before a page's first cell (PYTHONSTARTUP, set in conf.py). IPython's own magic
breaks lines where its pipe does, and goes on after a command that failed; it says what it writes.
"""

import os
import subprocess
import textwrap
from pathlib import Path

from IPython import get_ipython
from IPython.core.error import UsageError

#: Columns that a page is wide.
WIDTH = 96


def wrapped(line: str) -> str:
    """A sentence in lines as wide as a page; a row of a table as it is."""
    sentence = line.strip()
    indent = " " * (line.index(sentence) + 4)
    if len(line) <= WIDTH or len(indent) > 7 or "  " in sentence or "─" in sentence:
        return line
    return textwrap.fill(line, WIDTH, subsequent_indent=indent)


def bash(_: str, cell: str) -> None:
    """Run commands and print what they write to standard output, as to a file: without colours."""
    environment = {name: os.environ[name] for name in os.environ if name != "FORCE_COLOR"}
    command = ["bash", "-euo", "pipefail", "-c", cell]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    for text in done.stdout.splitlines():
        print(wrapped(text))
    if done.returncode:
        raise UsageError(f"exit code {done.returncode}\n{done.stderr}")


def writefile(line: str, cell: str) -> None:
    """Write a file, without saying so."""
    Path(line.strip()).write_text(cell, encoding="utf-8")


for magic in (bash, writefile):
    get_ipython().register_magic_function(magic, "cell")
