"""Commands and numbers in docs/how-to/sweeps.md are right."""

import re
from pathlib import Path

import pytest
from spincheck.reports.cli.app import app
from spincheck.reports.harness.executors.local_workers import TIME_LIMIT
from spincheck.reports.harness.stock import STEP_BUDGET
from spincheck.reports.harness.sweep_points import STEP_TURN
from spincheck.scenarios.scatter import SCATTER
from spincheck.scenarios.vary import DEFAULT_COUNT
from typer.main import get_group

PAGE = (Path(__file__).parents[1] / "docs/how-to/sweeps.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```sh\n(.*?)```", PAGE, flags=re.DOTALL)


def test_every_command_it_shows_has_the_options_it_shows():
    lines = re.findall(r"^spincheck (\w+)(.*)", "\n".join(BLOCKS), flags=re.MULTILINE)
    assert len(lines) >= 6
    group = get_group(app)
    for name, rest in lines:
        command = group.get_command(None, name)
        assert command is not None, name
        options = {option for parameter in command.params for option in parameter.opts}
        assert set(re.findall(r"--[\w-]+", rest)) <= options


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
