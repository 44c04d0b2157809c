"""The files that docs/how-to/add-an-effect.md lists are those whose code names one effect."""

import ast
import re
from collections.abc import Callable
from functools import cache
from pathlib import Path

from lines_of_code import DOCUMENTED

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs/how-to/add-an-effect.md").read_text(encoding="utf-8")
FOLDERS = ("scenarios", "reference", "engines", "reports")
#: Engines that take an effect have it in a form of their own.
ADAPTERS = ("engines/adapters/", "engines/models/")
#: Words by themselves, not in the names of scenes; the heading below which their files are listed.
DRAG = re.compile(r"(?<![\w-])drag(?![\w-])")
ROTORS = re.compile(r"(?<![\w-])rotors?(?![\w-])")
OF_A_PART = "## A part of the body"
#: The word is of other things too: what the table is called where it is an effect.
TABLE = re.compile(
    r"effects\.table|TableTable|effects import [\w, ]*\btable\b|tip_axes|lifts_off|lift_off|LiftOff"
    r"|ON_TABLE|\"table\""
)
OF_A_CONSTRAINT = "## A constraint: the table"
#: Where "table" is another's.
OTHERS = ("markdown", "render", "templating", "overview/first_screen", "overview/spread")
OTHER_TABLES = {f"reports/pages/{name}.py" for name in OTHERS}
OTHER_TABLES.add("scenarios/format_page.py")
#: The force of a scene that accelerates the com; the heading below which its files are listed.
GRAVITY = re.compile(r"gravity_world", re.IGNORECASE)
OF_A_FORCE = "## A force: gravity"
#: Of a constraint with a force and an end of its own: measured.
MOST_OF_A_CONSTRAINT = 12
MOST, MOST_WITH_ADAPTERS = 12, 26
#: Of a part, which adds states: measured.
MOST_OF_A_PART = 22


@cache
def code_of(path: Path) -> str:
    """A source without comments and docstrings: what these name need not be changed for a part."""
    text = path.read_text(encoding="utf-8")
    if path.suffix != ".py":
        return text
    tree = ast.parse(text)
    for node in ast.walk(tree):
        if isinstance(node, DOCUMENTED) and ast.get_docstring(node) is not None:
            node.body[0] = ast.Pass()
    return ast.unparse(tree)


def whole(path: Path) -> str:
    return path.read_text(encoding="utf-8")


def files_with(
    word: re.Pattern[str], root: Path, text_of: Callable[[Path], str] = code_of
) -> set[str]:
    """Files in whose code a word stands, relative to a folder."""
    return {
        path.relative_to(root).as_posix()
        for folder in FOLDERS
        for path in (root / folder).rglob("*.*")
        if path.suffix in (".py", ".mjs") and word.search(text_of(path))
    }


def listed_in(section: str) -> set[str]:
    return set(re.findall(r"^\| `([^`]+)` \|", section, re.MULTILINE))


def test_the_page_lists_the_files_that_name_an_effect() -> None:
    listed, named = listed_in(PAGE.split(OF_A_PART)[0]), files_with(DRAG, ROOT)
    assert listed == {path for path in named if not path.startswith(ADAPTERS)}
    assert len(listed) <= MOST
    assert len(named) <= MOST_WITH_ADAPTERS


def test_the_page_lists_the_files_that_name_a_part() -> None:
    listed, named = listed_in(PAGE.split(OF_A_PART)[1]), files_with(ROTORS, ROOT)
    assert {path for path in named if not path.startswith(ADAPTERS)} <= listed
    # Two are listed whose code has a part's spins, and only their prose its name.
    assert listed <= files_with(ROTORS, ROOT, whole)
    assert len(listed) <= MOST_OF_A_PART


def test_a_file_that_names_it_besides_would_be_found(tmp_path: Path) -> None:
    for folder in FOLDERS:
        (tmp_path / folder).mkdir()
    (tmp_path / "reports/pages.py").write_text('if "drag" in scenario.called_for: ...\n')
    (tmp_path / "reports/scenes.py").write_text('SCENES = ("book-with-drag",)\n')
    assert files_with(DRAG, tmp_path) == {"reports/pages.py"}


def test_the_page_lists_the_files_that_name_the_table() -> None:
    section = PAGE.split(OF_A_CONSTRAINT)[1].split("\n## ")[0].split("\nWhat constrains")[0]
    listed = set(re.findall(r"`([\w/]+\.py)`", section))
    named = {path for path in files_with(TABLE, ROOT) if not path.startswith(ADAPTERS)}
    assert named - OTHER_TABLES <= listed <= files_with(TABLE, ROOT, whole)
    assert len(listed) <= MOST_OF_A_CONSTRAINT


def test_the_page_lists_the_files_that_name_the_force_of_gravity() -> None:
    section = PAGE.split(OF_A_FORCE)[1].split("\n## ")[0]
    rows = "".join(re.findall(r"^\|.*$", section, re.MULTILINE))
    listed = set(re.findall(r"`([\w/]+\.py)`", rows))
    named = {path for path in files_with(GRAVITY, ROOT) if not path.startswith(ADAPTERS)}
    assert listed == named
