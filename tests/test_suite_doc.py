"""The page about the suite lists its tests and what their failures mean."""

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from spincheck.suite import SCENES, test_adapter, test_physics

PAGE = (Path(__file__).parents[1] / "docs/how-to/suite.md").read_text(encoding="utf-8")
CHAPTERS = {"The adapter": test_adapter, "The physics": test_physics}


def row(name: str, test: Callable[..., None]) -> str:
    """The line of the page's table about a test."""
    about = vars(test)
    links = [
        f"[{repository}#{number}]({url})"
        for url in about["issues"]
        for *_, repository, _, number in [url.split("/")]
    ]
    says = (test.__doc__ or "").splitlines()[0]
    return f"| `{name}` | {says} | {about['sentence']} | {', '.join(links)} |"


def in_chapter(module: object) -> dict[str, Callable[..., None]]:
    return {name: test for name, test in vars(module).items() if name.startswith("test_")}


@pytest.mark.parametrize("chapter", CHAPTERS)
def test_the_page_lists_every_test_and_what_its_failure_means(chapter: str) -> None:
    section = PAGE.partition(f"## {chapter}\n")[2].partition("\n## ")[0]
    listed = [line for line in section.splitlines() if line.startswith("| `")]
    assert listed == [row(name, test) for name, test in in_chapter(CHAPTERS[chapter]).items()]


def test_every_scene_is_used() -> None:
    text = Path(test_physics.__file__).read_text(encoding="utf-8")
    assert {path.stem for path in SCENES.glob("*.toml")} == set(
        re.findall(r'follows\("([\w-]+)"', text)
    )
