"""Every cause of an outcome is documented, and no other."""

import re
from pathlib import Path
from typing import get_args

from spincheck.engines import Cause

PAGE = Path(__file__).parents[2] / "docs/explanation/outcomes.md"


def test_the_page_has_a_row_for_every_cause() -> None:
    table = PAGE.read_text(encoding="utf-8").split("## Causes")[1].split("\n##")[0]
    first_cells = [line.split("|")[1] for line in table.splitlines() if line.startswith("| `")]
    documented = {cause for cell in first_cells for cause in re.findall(r"`([^`]+)`", cell)}
    assert documented == set(get_args(Cause)) - {""}
