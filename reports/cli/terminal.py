"""What the command line prints: tables, JSON, progress, complaints."""

import json
import math
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

from .stopping import STDERR, print_nowhere

#: Exit codes: everything agrees; something does not; bad input or usage; nothing could be run.
AGREES, DISAGREES, BAD_INPUT, NOT_RUN = 0, 1, 2, 3


class Complaint(Exception):
    """An error for the user: one message, and the exit code that goes with it."""

    def __init__(self, message: str, exit_code: int) -> None:
        super().__init__(message)
        self.exit_code = exit_code


def say(text: str) -> None:
    """Print a message on stderr; control characters are printed as escapes."""
    from ...scenarios import printable

    try:
        print("\n".join(printable(line) for line in text.split("\n")), file=sys.stderr, flush=True)
    except OSError:
        # On a full disk or a closed pipe the message is lost; that does not end the program.
        print_nowhere(STDERR)


def to_json(value: Any) -> str:
    """JSON with numbers that read back to the last bit; inf and nan, which it lacks, as null.

    Control characters are escaped, as JSON does.
    """
    text = json.dumps(_finite(value), indent=1, ensure_ascii=False, allow_nan=False)
    return "\n".join(map(_escaped, text.split("\n")))


def _escaped(line: str) -> str:
    if line.isprintable():
        return line
    return "".join(c if c.isprintable() else json.dumps(c)[1:-1] for c in line)


def _finite(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def table(rows: Sequence[Mapping[str, object]]) -> None:
    """Print records as a table with their keys as headings."""
    from rich import box
    from rich.console import Console
    from rich.table import Column, Table

    if not rows:
        return
    # If the table is too wide for the terminal, cells are wrapped: an ellipsis would hide digits.
    grid = Table(*(Column(heading, overflow="fold") for heading in rows[0]), box=box.SIMPLE)
    for row in rows:
        grid.add_row(*(cell(value) for value in row.values()))
    console = Console(highlight=False, markup=False)
    if not console.is_terminal:
        # In a file or a pipe nothing is wrapped: one record a line.
        console.width = max(console.measure(grid, options=_unbounded(console)).maximum, 1)
    console.print(grid)


def terminal_width() -> int | None:
    """Columns of the terminal that is printed on; None in a file or a pipe."""
    from rich.console import Console

    console = Console()
    return console.width if console.is_terminal else None


def cell(value: object) -> str:
    """A value as tables show it: three digits, nothing for None."""
    if value is None:
        return ""
    from ...scenarios import printable

    return f"{value:.3g}" if isinstance(value, float) else printable(str(value))


@contextmanager
def progress(total: int, lines: int | None = None) -> Iterator[Callable[[str], None]]:
    """A bar on a terminal, plain lines elsewhere; each call counts as one of `total`.

    Both show the time left, extrapolated from the time taken so far.

    Parameters
    ----------
    lines : at most so many of the plain lines are printed, evenly spaced; all of them if None
    """
    if not sys.stderr.isatty():
        done, begun = 0, time.monotonic()

        def line(text: str) -> None:
            nonlocal done
            done += 1
            if lines is None or done * lines // total > (done - 1) * lines // total:
                left = (time.monotonic() - begun) / done * (total - done)
                say(f"[{done}/{total}, {left / 60:.0f} min left] {text}")

        yield line
        return
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    columns = (
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
        TextColumn("{task.description}"),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("starting", total=total)
        yield lambda text: bar.update(task, advance=1, description=text)


def _unbounded(console: Any) -> Any:
    return console.options.update(max_width=100_000)
