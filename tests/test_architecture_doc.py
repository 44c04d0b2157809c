"""Files and functions named in docs/architecture.md and docs/glossary.md exist."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
NAMED = [
    (page.name, name)
    for page in (ROOT / "docs/architecture.md", ROOT / "docs/glossary.md")
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
