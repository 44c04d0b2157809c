"""What the pages for developers name exists: files, functions, methods, make targets."""

import ast
import re
from pathlib import Path

import pytest
from spincheck.engines import Session

ROOT = Path(__file__).parents[1]
PAGES = ("architecture.md", "glossary.md", "add-an-engine.md")
NAMED = [
    (page.name, name)
    for page in (ROOT / "CONTRIBUTING.md", *(ROOT / "docs" / name for name in PAGES))
    for name in re.findall(r"`((?:\w+/)+[\w.]*(?::\w+)?)`", page.read_text(encoding="utf-8"))
]


def test_the_pages_name_files() -> None:
    assert len(NAMED) > 30


@pytest.mark.parametrize(("page", "name"), NAMED, ids=lambda value: str(value))
def test_every_file_and_function_they_name_exists(page: str, name: str) -> None:
    path, _, definition = name.partition(":")
    assert (ROOT / path).exists()
    if definition:
        tree = ast.parse((ROOT / path).read_text(encoding="utf-8"))
        defined = {n.name for n in tree.body if isinstance(n, ast.FunctionDef | ast.ClassDef)}
        assert definition in defined


def test_the_way_of_a_scene_has_at_most_fifteen_hops() -> None:
    text = (ROOT / "docs/architecture.md").read_text(encoding="utf-8")
    hops = [int(number) for number in re.findall(r"^\| (\d+) \|", text, flags=re.MULTILINE)]
    assert hops == list(range(1, len(hops) + 1))
    assert len(hops) <= 15


def test_an_engine_has_to_give_what_its_page_lists() -> None:
    text = (ROOT / "docs/add-an-engine.md").read_text(encoding="utf-8")
    listed = set(re.findall(r"^\| `(\w+)(?:\(k\))?` \|", text, flags=re.MULTILINE))
    assert listed == Session.__abstractmethods__


def test_contributing_calls_make_targets_that_exist() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    targets = set(re.findall(r"^([\w-]+):", makefile, flags=re.MULTILINE))
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    named = set(re.findall(r"(?:^|`)make ([\w-]+)", text, flags=re.MULTILINE))
    assert named
    assert named <= targets
