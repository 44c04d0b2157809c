"""Output of native code is captured, which Python's own redirection does not do."""

import ctypes
import os
import sys

import pytest
from spincheck.engines.native_output import native_output

C = ctypes.CDLL(None)


def test_what_c_prints_is_caught() -> None:
    with native_output() as printed:
        C.puts(b"from C")
    assert printed.text == "from C\n"


def test_what_is_written_to_either_descriptor_is_caught() -> None:
    with native_output() as printed:
        os.write(1, b"one, ")
        os.write(2, b"two")
    assert printed.text == "one, two"


def test_what_python_prints_is_caught_once(capfd: pytest.CaptureFixture[str]) -> None:
    with capfd.disabled(), native_output() as printed:
        print("from Python")
    assert printed.text == "from Python\n"


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


def next_descriptor() -> int:
    descriptor = os.dup(1)
    os.close(descriptor)
    return descriptor


def test_catching_leaks_no_descriptor() -> None:
    before = next_descriptor()
    with native_output():
        pass
    assert next_descriptor() == before
