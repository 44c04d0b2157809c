"""What the command line prints: tables, JSON, progress, complaints, errors of the system."""

import codecs
import errno
import json
import math
import shlex
import sys
import textwrap
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from io import TextIOWrapper
from pathlib import Path
from typing import Any, TextIO

from .stopping import STDERR, STDOUT, print_nowhere

#: Exit codes: everything agrees; something disagrees; bad input or usage; nothing could be run.
AGREES, DISAGREES, BAD_INPUT, NOT_RUN = 0, 1, 2, 3


#: Width, characters, to which longer names may be wrapped if a table is too wide for the terminal.
NAME = 12


class Complaint(Exception):
    """An error that ends a command: a message for the user, and the program's exit code."""

    def __init__(self, message: str, exit_code: int = BAD_INPUT) -> None:
        super().__init__(message)
        self.exit_code = exit_code


def command(name: str, path: Path) -> str:
    """Return the command line `spincheck NAME PATH`, quoted as a shell needs it."""
    return shlex.join(["spincheck", name, str(path)])


@contextmanager
def as_complaint(
    *errors: type[Exception], before: str = "", exit_code: int = BAD_INPUT
) -> Iterator[None]:
    """Raise a `Complaint` in place of some errors that the block raises.

    Parameters
    ----------
    errors : classes of these errors
    before : text that is put before the error's message
    exit_code : exit code with which the complaint ends the program
    """
    try:
        yield
    except errors as error:
        raise Complaint(f"{before}{error}", exit_code) from None


def say(text: str) -> None:
    """Print a message on stderr; control characters are printed as escapes."""
    from ...scenarios import printable

    try:
        print("\n".join(printable(line) for line in text.split("\n")), file=sys.stderr, flush=True)
    except OSError:
        # On a full disk or a closed pipe the message is lost, which does not end the program.
        print_nowhere(STDERR)


def escape_what_turns_text(stream: TextIO) -> None:
    """Replace a stream's `write`, so that invisible and text-reversing characters become escapes.

    ASCII characters are kept: tables and progress bars are drawn with control sequences of them.
    """
    write = stream.write

    def escaped(text: str) -> int:
        if text.isascii():
            return write(text)
        from ...scenarios import printable

        return write("".join(c if c.isascii() else printable(c) for c in text))

    stream.write = escaped  # type: ignore[method-assign]


def to_json(value: Any) -> str:
    """Return a value as JSON: numbers with all digits, null for inf and NaN.

    Characters that cannot be printed are written as escapes of JSON. So are all that are not ASCII
    if standard output is not in UTF-8: JSON has no other encoding.
    """
    in_utf8 = codecs.lookup(sys.stdout.encoding or "utf-8").name == "utf-8"
    text = json.dumps(_finite(value), indent=1, ensure_ascii=not in_utf8, allow_nan=False)
    return "\n".join(map(_escaped, text.split("\n")))


def _escaped(line: str) -> str:
    """Return a line in which JSON's escapes replace the characters that cannot be printed."""
    if line.isprintable():
        return line
    return "".join(c if c.isprintable() else json.dumps(c)[1:-1] for c in line)


def _finite(value: Any) -> Any:
    """Return a value for JSON with None in place of each inf and NaN, nested ones too."""
    if isinstance(value, Mapping):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def print_file(text: str) -> None:
    """Print the text of a file, in UTF-8 unless it goes to a terminal, which has its encoding."""
    if isinstance(sys.stdout, TextIOWrapper) and not sys.stdout.isatty():
        sys.stdout.reconfigure(encoding="utf-8", errors="backslashreplace")
    print(text, end="")


def table(rows: Sequence[Mapping[str, object]]) -> None:
    """Print records as a table with their keys as headings.

    In a file or a pipe, each record is one line. On a terminal that is too narrow, texts are
    wrapped; if the table is still too wide, each record is printed as a paragraph. No number is
    ever cut.
    """
    from rich import box
    from rich.console import Console
    from rich.table import Column, Table

    if not rows:
        return
    lines = [[*rows[0]], *([cell(value) for value in row.values()] for row in rows)]
    console = Console(highlight=False, markup=False)
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    if console.is_terminal:
        words = [max(map(_least_width, column)) for column in zip(*lines, strict=True)]
        if sum(words) + _beside(words) > console.width:
            _print_paragraphs(lines, console.width)
            return
        widths = _narrowed(widths, words, console.width - _beside(words))
    else:
        console.width = sum(widths) + _beside(widths)
    columns = (
        Column(h, width=width, overflow="fold") for h, width in zip(lines[0], widths, strict=True)
    )
    grid = Table(*columns, box=box.SIMPLE)
    for line in lines[1:]:
        grid.add_row(*line)
    # Not printed by rich, which ends the program with 1 if nobody reads it.
    with console.capture() as drawn:
        console.print(grid)
    print(drawn.get(), end="")


def _beside(columns: Sequence[object]) -> int:
    """Return the number of characters that are borders or padding in a line with these columns."""
    return 3 * len(columns) + 1


def _least_width(text: str) -> int:
    """Return the least width of a cell, characters.

    Numbers are kept whole; other words may be wrapped after `NAME` characters.
    """
    words = text.split()
    return max((len(w) if _is_number(w) else min(len(w), NAME) for w in words), default=0)


def _is_number(word: str) -> bool:
    """Whether a word begins with a number, which may follow signs, brackets, or "≤" and the like.

    Numbers are told from names in this way, since no engine's name begins with a digit.
    """
    return word.lstrip("+-±≤≥<>~([").replace(".", "", 1)[:1].isdigit()


def _narrowed(widths: list[int], least: list[int], room: int) -> list[int]:
    """Return widths of columns that fit into a table, narrowed if necessary.

    One character at a time is taken from the column that is furthest above its least width.

    Parameters
    ----------
    widths, least : widths of the columns, and their least widths, characters
    room : number of characters that all columns may take together
    """
    widths = list(widths)
    for _ in range(sum(widths) - room):
        spare = [width - needed for width, needed in zip(widths, least, strict=True)]
        widths[spare.index(max(spare))] -= 1
    return widths


def _print_paragraphs(lines: list[list[str]], width: int) -> None:
    """Print each record as a paragraph, in which each heading and value begin a line.

    Parameters
    ----------
    lines : the headings, then the cells of each record
    width : width of the terminal, characters
    """
    headings = lines[0]
    indent = " " * (max(map(len, headings)) + 2)
    for line in lines[1:]:
        print()
        for heading, text in zip(headings, line, strict=True):
            begun = f"{heading:{len(indent)}}"
            wrapped = textwrap.wrap(
                text,
                width,
                initial_indent=begun,
                subsequent_indent=indent,
                break_long_words=False,
                break_on_hyphens=False,
            )
            print("\n".join(wrapped) if wrapped else begun.rstrip())


def terminal_width() -> int | None:
    """Return the width of the terminal, characters; None if output goes to a file or a pipe."""
    from rich.console import Console

    console = Console()
    return console.width if console.is_terminal else None


def cell(value: object) -> str:
    """Return a value as the text of a table's cell: a float in three digits, empty for None."""
    if value is None:
        return ""
    from ...scenarios import printable

    return f"{value:.3g}" if isinstance(value, float) else printable(str(value))


def _left(finished: Sequence[float], total: int) -> str:
    """Return, in words, an estimate of the time until all tasks have finished.

    It is extrapolated from the later half of the finished tasks. The text is empty if fewer than
    two tasks have finished.

    Parameters
    ----------
    finished : times at which tasks finished, s
    total : number of tasks
    """
    done = len(finished)
    if done < 2:
        return ""
    since = (done - 1) // 2
    each = (finished[-1] - finished[since]) / (done - 1 - since)
    return f", {in_words(each * (total - done))} left"


def in_words(seconds: float) -> str:
    """Return an estimated time in words, such as "42 s" or "3 min"."""
    return f"{seconds:.0f} s" if seconds < 90 else f"{seconds / 60:.0f} min"


@contextmanager
def progress(total: int, lines: int | None = None) -> Iterator[Callable[[str], None]]:
    """Show progress on stderr: as a bar on a terminal, in plain lines elsewhere.

    The context yields a function. The block calls it with a text whenever a task has finished. Bar
    and lines show an estimate of the time left. It rests on the tasks that finished last, as the
    first ones may have waited for processes to start and kernels to compile.

    Parameters
    ----------
    total : number of tasks
    lines : largest number of plain lines that are printed, evenly spaced; None prints all
    """
    if not sys.stderr.isatty():
        finished: list[float] = []

        def line(text: str) -> None:
            finished.append(time.monotonic())
            done = len(finished)
            if lines is None or done * lines // total > (done - 1) * lines // total:
                say(f"[{done}/{total}{_left(finished, total)}] {text}")

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


#: Error numbers of an output that cannot be written.
_OF_OUTPUT = (errno.ENOSPC, errno.EPIPE, errno.EBADF, errno.EIO, errno.EFBIG, errno.EDQUOT)


def refusal(error: Exception) -> Complaint | None:
    """Return a `Complaint` for an error that is not a fault of the program; None for any other.

    Errors of the operating system, such as a full disk, a lack of memory, and two engines of the
    same name are no faults of the program. If standard output cannot be written, it is redirected
    to the null device.
    """
    from ...engines import NameTaken
    from ..harness.executors import cause_of

    if isinstance(error, FileNotFoundError) and error.filename is None:
        return Complaint("the current folder was deleted; change to another", NOT_RUN)
    if isinstance(error, OSError) and error.filename is not None:
        return unusable(error.filename, error)
    if isinstance(error, OSError) and error.errno in _OF_OUTPUT:
        print_nowhere(STDOUT)
        return Complaint(f"the output cannot be written: {error.strerror}", NOT_RUN)
    if isinstance(error, NameTaken):
        return Complaint(str(error), NOT_RUN)
    if isinstance(error, MemoryError):
        return Complaint("there is not enough memory", NOT_RUN)
    if cause_of(error) == "environment":
        return Complaint(f"the system does not let it go on: {error}", NOT_RUN)
    return None


@contextmanager
def written(place: Path | str) -> Iterator[None]:
    """Raise a `Complaint` in place of an `OSError` that the block raises while it writes.

    Parameters
    ----------
    place : file or folder that the complaint names if the error itself names none
    """
    try:
        yield
    except OSError as error:
        raise unusable(error.filename or place, error, "written") from None


def unusable(place: Path | str, error: OSError, purpose: str = "used") -> Complaint:
    """Return the complaint that a file or folder cannot be written, or cannot be used.

    Parameters
    ----------
    place : the file or folder
    purpose : "written" or "used"
    """
    from ...scenarios import printable

    where = printable(str(place))
    return Complaint(f"{where}: cannot be {purpose}: {error.strerror}")
