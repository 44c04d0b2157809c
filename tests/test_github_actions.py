"""The workflow for GitHub Actions calls existing commands with existing options."""

import re
import shlex
from pathlib import Path

import pytest
import typer
from spincheck.reports.cli.app import app

WORKFLOW = Path(__file__).parents[1] / "docs/how-to/github-actions.yml"
LINES = re.findall(r"\bspincheck [a-z]+ [^\n]*", WORKFLOW.read_text(encoding="utf-8"))
CALLS = [line for line in LINES if not line.endswith((".", ","))]


@pytest.mark.parametrize("call", CALLS)
def test_a_call_is_of_a_command_with_its_options(call: str) -> None:
    name, *words = shlex.split(call.partition(">")[0])[1:]
    commands = vars(typer.main.get_command(app))["commands"]
    options = {option for parameter in commands[name].params for option in parameter.opts}
    assert {word for word in words if word.startswith("--")} <= options


def test_it_runs_compares_and_makes_a_report() -> None:
    commands = [call.split()[1] for call in CALLS]
    assert commands == ["check", "run", "compare", "report"]
    assert "--junitxml" in WORKFLOW.read_text(encoding="utf-8")


def test_what_is_compared_and_shown_is_what_the_run_wrote() -> None:
    written = re.search(r"spincheck run .*--out (\S+)", WORKFLOW.read_text(encoding="utf-8"))
    assert written is not None
    assert all(written[1] in call for call in CALLS if call.split()[1] in ("compare", "report"))
