"""A scene made of another's file: other tables, without what holds of the first scene alone.

It goes through the same checks as a file.
"""

import tomllib
from collections.abc import Mapping
from copy import deepcopy
from typing import Any

from .load import loads
from .scenario import OF_THE_SCENE_ALONE, Scenario
from .write import to_toml


def own_tables(scenario: Scenario) -> dict[str, Any]:
    """A scene file's tables, to be changed, without what holds of this very scene alone."""
    tables = tomllib.loads(scenario.text)
    return {key: value for key, value in tables.items() if key not in OF_THE_SCENE_ALONE}


def rewritten(scenario: Scenario, tables: Mapping[str, Any], changes: str) -> Scenario:
    """A scene made of other tables, under the same name; its title says what is different.

    Raises
    ------
    ScenarioError
        If there is no such scene.
    """
    changed = deepcopy(dict(tables))
    if changes:
        changed["title"] = f"{scenario.title}, with {changes}"
    return loads(to_toml(changed), scenario.name)
