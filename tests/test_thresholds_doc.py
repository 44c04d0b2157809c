"""The table of smallest detected faults has every kind, and most as small as reports say."""

from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs/measured/thresholds.md").read_text(encoding="utf-8")
PROTOCOL = (ROOT / "reports/pages/overview/protocol.md").read_text(encoding="utf-8")


def test_reports_say_what_the_table_has() -> None:
    sizes = [line.split("|")[4].strip() for line in PAGE.splitlines() if " order |" in line]
    assert sizes.count("1e-08") > len(sizes) / 2
    assert "most are found from a relative size of 10⁻⁸ on" in PROTOCOL


def test_no_kind_of_fault_goes_undetected() -> None:
    assert "| never |" not in PAGE
    assert PAGE.count("| fourth order |") > 1
