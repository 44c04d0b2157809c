"""Captures output at the file descriptors, because native code bypasses `sys.stdout`."""

import ctypes
import os
import sys
import tempfile
import warnings
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass

STDOUT, STDERR = 1, 2


@dataclass
class Printed:
    """The text captured from standard output, followed by that from standard error."""

    text: str = ""


@contextmanager
def native_output() -> Iterator[Printed]:
    """Capture what Python or native code prints inside the block.

    The yielded object has the text when the block has ended, not before. Blocks must not run in
    several threads at once, since the descriptors belong to the whole process.
    """
    printed = Printed()
    with ExitStack() as undo:
        streams = [undo.enter_context(_caught(descriptor)) for descriptor in (STDOUT, STDERR)]
        try:
            yield printed
        finally:
            _flush()
            printed.text = "".join(_contents(stream) for stream in streams)


@contextmanager
def silent() -> Iterator[None]:
    """Discard all output and all Python warnings of the code inside the block."""
    with native_output(), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


@contextmanager
def _caught(descriptor: int) -> Iterator[int]:
    """Redirect a descriptor to a temporary file inside the block; yield that file's descriptor."""
    _flush()
    kept = os.dup(descriptor)
    with tempfile.TemporaryFile() as file:
        os.dup2(file.fileno(), descriptor)
        try:
            yield file.fileno()
        finally:
            os.dup2(kept, descriptor)
            os.close(kept)


def _flush() -> None:
    """Flush the output buffers of Python and of the C library.

    It is called at both ends of a block whose output is captured. Otherwise text that was printed
    before the block would be captured too, and text that was printed in it would be missed.
    """
    for stream in (sys.stdout, sys.stderr):
        stream.flush()
    ctypes.CDLL(None).fflush(None)


def _contents(descriptor: int) -> str:
    """Return the whole contents, as text, of the file with a given descriptor."""
    os.lseek(descriptor, 0, os.SEEK_SET)
    with os.fdopen(os.dup(descriptor), "rb") as file:
        return file.read().decode(errors="replace")
