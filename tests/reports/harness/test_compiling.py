"""Kernels are compiled before the first scene, and once."""

from collections.abc import Callable

import pytest
from spincheck.reference.compiled import compile_kernels
from spincheck.reports.harness import compiling
from spincheck.reports.harness.executors import Answer, InProcess


class Recording(InProcess):
    def __init__(self) -> None:
        super().__init__()
        self.called: list[Callable[..., object]] = []

    def call(self, function, /, *args, **kwargs):
        self.called.append(function)
        return Answer(None)


@pytest.mark.parametrize(
    ("there", "calls"), [(False, [*compiling.HALVES, compile_kernels]), (True, [])]
)
def test_what_is_compiled_is_not_compiled_again(
    monkeypatch, there: bool, calls: list[Callable[..., object]]
) -> None:
    monkeypatch.setattr(compiling, "is_compiled", lambda: there)
    with Recording() as executor:
        compiling.compile_side_by_side(executor)
    assert executor.called == calls


def test_without_a_place_for_machine_code_no_worker_compiles_it(monkeypatch) -> None:
    monkeypatch.setattr(compiling, "is_compiled", lambda: False)
    monkeypatch.setattr(compiling, "FOLDER", None)
    with Recording() as executor:
        compiling.compile_side_by_side(executor)
    assert executor.called == []
