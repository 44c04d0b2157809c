"""Output of native code is captured, which Python's own redirection does not do."""

import ctypes
import os
import sys
from collections.abc import Callable

import pytest
from case_loops import each_case
from spincheck.engines.native_output import native_output

C = ctypes.CDLL(None)


def next_descriptor() -> int:
    descriptor = os.dup(1)
    os.close(descriptor)
    return descriptor


def to_both_descriptors() -> None:
    os.write(1, b"one, ")
    os.write(2, b"two")


@each_case(
    ("write", "caught"),
    [
        (lambda: C.puts(b"from C"), "from C\n"),
        (to_both_descriptors, "one, two"),
        (lambda: print("from Python"), "from Python\n"),
    ],
)
def test_what_is_written_is_caught_once_and_no_descriptor_is_leaked(
    write: Callable[[], object], caught: str, capfd: pytest.CaptureFixture[str]
) -> None:
    before = next_descriptor()
    with capfd.disabled(), native_output() as printed:
        write()
    assert printed.text == caught
    assert next_descriptor() == before


def test_what_was_printed_before_and_after_goes_its_own_way(
    capfd: pytest.CaptureFixture[str],
) -> None:
    C.printf(b"before ")
    sys.stdout.write("and ")
    with native_output() as printed:
        C.printf(b"caught")
    C.printf(b"after")
    C.fflush(None)
    assert printed.text == "caught"
    assert sorted(capfd.readouterr().out.split()) == ["after", "and", "before"]


def fail() -> None:
    C.puts(b"why")
    raise KeyError


def test_an_error_inside_leaves_its_text_and_the_descriptors_in_order(
    capfd: pytest.CaptureFixture[str],
) -> None:
    printed = None
    try:
        with native_output() as printed:
            fail()
    except KeyError:
        os.write(1, b"visible")
    assert printed is not None
    assert printed.text == "why\n"
    assert capfd.readouterr().out == "visible"
