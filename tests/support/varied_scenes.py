"""Scenes with other numbers, by their paths in the scene file."""

import re
from collections.abc import Mapping
from typing import Any

from spincheck.scenarios import Scenario
from spincheck.scenarios.vary import own_tables, rewritten


def varied(scenario: Scenario, values: Mapping[str, float]) -> Scenario:
    """The scene with other numbers, by paths such as `start.omega_body[2]`."""
    changed = own_tables(scenario)
    for path, value in values.items():
        *steps, last = [key or int(n) for key, n in re.findall(r"([^.\[\]]+)|\[(\d+)\]", path)]
        place: Any = changed
        for step in steps:
            place = place[step]
        place[last] = value
    return rewritten(scenario, changed, "")
