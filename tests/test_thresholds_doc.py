"""The table of smallest detected faults is the same in docs and in every report."""

from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs/measured/thresholds.md").read_text(encoding="utf-8")
TEMPLATES = ROOT / "reports" / "pages" / "overview"


def test_reports_print_the_table_of_the_docs() -> None:
    assert (TEMPLATES / "thresholds.md").read_text(encoding="utf-8") == f"#{PAGE}"
    assert '{% include "thresholds.md" %}' in (TEMPLATES / "protocol.md").read_text(
        encoding="utf-8"
    )


def test_no_kind_of_fault_goes_undetected() -> None:
    assert "| never |" not in PAGE
    assert PAGE.count("| fourth order |") > 1
