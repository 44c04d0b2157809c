"""Nothing waits or measures by a clock that jumps: of the time of day there is only a date."""

import ast
from pathlib import Path

ROOT = Path(__file__).parents[1]
FOLDERS = ("scenarios", "reference", "engines", "reports")
#: Reads the time of day: a result file's date.
DATED = "reports/results/environment.py"
#: Names of functions of `time` and `datetime` whose values jump when somebody sets the clock.
JUMPING = {"time", "time_ns", "now", "utcnow", "today", "localtime", "gmtime"}
CLOCKS = {"time", "datetime", "date"}


def reads_the_time_of_day(source: str) -> bool:
    """Whether it calls, or imports to call, a clock that jumps."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Attribute) and node.attr in JUMPING:
            owner = node.value
            if isinstance(owner, ast.Name | ast.Attribute):
                name = owner.id if isinstance(owner, ast.Name) else owner.attr
                if name in CLOCKS:
                    return True
        from_time = isinstance(node, ast.ImportFrom) and node.module == "time"
        if from_time and JUMPING & {alias.name for alias in node.names}:
            return True
    return False


def test_only_the_date_of_a_result_file_is_of_a_clock_that_jumps() -> None:
    paths = [path for folder in FOLDERS for path in (ROOT / folder).rglob("*.py")]
    reading = {
        path.relative_to(ROOT).as_posix()
        for path in paths
        if reads_the_time_of_day(path.read_text(encoding="utf-8"))
    }
    assert reading == {DATED}


def test_a_wait_by_such_a_clock_is_found() -> None:
    assert reads_the_time_of_day("import time\nend = time.time() + 5")
    assert reads_the_time_of_day("from time import time")
    assert reads_the_time_of_day("import datetime\ndatetime.datetime.now()")
    assert not reads_the_time_of_day("import time\nend = time.monotonic() + 5")
