"""Every attack listed in SECURITY.md has tests, and tests that any page names are there."""

import re
from pathlib import Path

from case_loops import each_case

ROOT = Path(__file__).parents[1]


def named_in(page: Path) -> list[str]:
    return re.findall(r"`(test_\w+)`", page.read_text("utf-8"))


NAMED = sorted(set(named_in(ROOT / "SECURITY.md")))
ALL_NAMED = {name for page in (ROOT / "docs").rglob("*.md") for name in named_in(page)} | {*NAMED}
TESTS = (ROOT / "tests", ROOT / "reports/interface/suite")
SOURCES = "\n".join(path.read_text("utf-8") for top in TESTS for path in top.rglob("test_*.py"))


@each_case("name", sorted(ALL_NAMED))
def test_a_test_that_is_named_is_there(name: str) -> None:
    assert f"def {name}(" in SOURCES


def test_every_attack_names_a_test() -> None:
    text = (ROOT / "SECURITY.md").read_text("utf-8")
    table = text.partition("| attack or accident |")[2].partition("\n\n")[0]
    rows = [row for row in table.splitlines()[2:] if not row.endswith("| | |")]
    assert len(rows) > 15
    assert [row for row in rows if "`test_" not in row] == []


#: Files of nothing but attacks.
OF_ATTACKS = ("test_forged_result_files", "test_full_disks", "test_machine_faults")


@each_case("file", OF_ATTACKS)
def test_every_test_of_an_attack_is_named(file: str) -> None:
    (path,) = (ROOT / "tests").rglob(f"{file}.py")
    assert set(re.findall(r"^def (test_\w+)", path.read_text("utf-8"), re.M)) <= set(NAMED)
