"""Kernels are compiled before the first scene, and once."""

from collections.abc import Callable
from pathlib import Path

import pytest
from spincheck.reference.compiled import compile_kernels
from spincheck.reports.harness.executors import Answer, InProcess, compiling


class Recording(InProcess):
    def __init__(self) -> None:
        super().__init__()
        self.called: list[Callable[..., object]] = []

    def call(self, function, /, *args, **kwargs):
        self.called.append(function)
        return Answer(None)


@pytest.mark.parametrize(
    ("there", "changed", "calls"),
    [
        (False, {}, [*compiling.HALVES, compile_kernels]),
        (True, {}, []),
        # Without a place for machine code no worker compiles it.
        (False, {"FOLDER": None}, []),
    ],
)
def test_what_is_compiled_is_not_compiled_again(monkeypatch, there, changed, calls) -> None:
    monkeypatch.setattr(compiling, "is_compiled", lambda: there)
    for name, value in changed.items():
        monkeypatch.setattr(compiling, name, value)
    with Recording() as executor:
        compiling.compile_side_by_side(executor)
    assert executor.called == calls


def test_where_nothing_can_be_kept_it_is_said_that_it_is_compiled_each_time(monkeypatch) -> None:
    for folder, when in ((Path("folder"), "once: "), (None, "each time, as no folder can be")):
        monkeypatch.setattr(compiling, "FOLDER", folder)
        assert compiling.notice().startswith(f"First, {when}")
