"""Numbers in docs/how-to/sweeps.md are right."""

from pathlib import Path

import pytest
from spincheck.reports.harness.executors.local_workers import TIME_LIMIT
from spincheck.reports.harness.stock import STEP_BUDGET
from spincheck.reports.harness.sweep_points import STEP_TURN
from spincheck.scenarios.scatter import SCATTER
from spincheck.scenarios.vary import DEFAULT_COUNT

PAGE = (Path(__file__).parents[1] / "docs/how-to/sweeps.md").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    "words",
    [
        f"({STEP_TURN:g} rad) in a step",
        f"more than {STEP_BUDGET:,} steps".replace(",", " "),
        f"{DEFAULT_COUNT} values where no count is given",
        f"hang of more than {TIME_LIMIT:g} s",
        f"times exp({SCATTER:g} n)",
    ],
)
def test_its_numbers_are_those_of_the_code(words):
    assert words in " ".join(PAGE.split())
