"""Nothing waits or measures by a clock that jumps: of the time of day there is only a date."""

import ast

import pytest
from sources import files_with

#: Reads the time of day: a result file's date.
DATED = "reports/results/environment.py"
#: Names of functions of `time` and `datetime` whose values jump when somebody sets the clock.
JUMPING = {"time", "time_ns", "now", "utcnow", "today", "localtime", "gmtime"}
CLOCKS = {"time", "datetime", "date"}


def reads_the_time_of_day(node: ast.AST) -> bool:
    """Whether it calls, or imports to call, a clock that jumps."""
    match node:
        case ast.Attribute(attr=called, value=ast.Name(id=owner) | ast.Attribute(attr=owner)):
            return called in JUMPING and owner in CLOCKS
        case ast.ImportFrom(module="time", names=names):
            return bool(JUMPING & {alias.name for alias in names})
    return False


def test_only_the_date_of_a_result_file_is_of_a_clock_that_jumps() -> None:
    assert files_with(reads_the_time_of_day) == {DATED}


@pytest.mark.parametrize(
    ("source", "jumps"),
    [
        ("end = time.time() + 5", True),
        ("from time import time", True),
        ("datetime.datetime.now()", True),
        ("end = time.monotonic() + 5", False),
    ],
)
def test_a_wait_by_such_a_clock_is_found(source: str, jumps: bool) -> None:
    assert any(map(reads_the_time_of_day, ast.walk(ast.parse(source)))) == jumps
