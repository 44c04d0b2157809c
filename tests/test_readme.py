"""Commands and examples in the README work as shown."""

import re
from pathlib import Path
from typing import get_args

import pytest
from spincheck.reports.cli.app import app
from spincheck.reports.results.verdict_words import VerdictWord
from typer.main import get_group

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```(\w+)\n(.*?)```", README, flags=re.DOTALL)


def test_every_command_it_shows_exists():
    named = {word for _, text in BLOCKS for word in re.findall(r"^spincheck (\w+)", text, re.M)}
    commands = get_group(app).list_commands(None)
    assert named
    assert named <= set(commands)


def test_every_make_target_it_shows_exists():
    named = set(re.findall(r"`make (\w+)`", README))
    targets = set(re.findall(r"^(\w+):", (ROOT / "Makefile").read_text(), flags=re.MULTILINE))
    assert named == {"report", "test", "docs"}
    assert named <= targets


@pytest.mark.parametrize("link", re.findall(r"\]\(([^)#]+)\)", README))
def test_every_link_leads_somewhere(link):
    assert (ROOT / link).exists()


def test_every_verdict_is_explained():
    explained = re.findall(r"^\| (\w+) \|", README, flags=re.MULTILINE)
    assert set(explained) - {"verdict"} == set(get_args(VerdictWord))
