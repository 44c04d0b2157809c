"""Makes a new scene from the file of a given scene, with some tables changed.

Tables that hold only for the original scene are left out. The new scene passes the same checks as
one that is read from a file.
"""

import tomllib
from collections.abc import Mapping
from copy import deepcopy
from typing import Any

from .load import loads
from .scenario import OF_THE_SCENE_ALONE, Scenario
from .write import to_toml


def own_tables(scenario: Scenario) -> dict[str, Any]:
    """Return the TOML tables of a scene's file, without those that hold only for this scene.

    Left out are `published`, `expect` and `known`. The tables are a copy, which the caller may
    change.
    """
    tables = tomllib.loads(scenario.text)
    return {key: value for key, value in tables.items() if key not in OF_THE_SCENE_ALONE}


def rewritten(scenario: Scenario, tables: Mapping[str, Any], changes: str) -> Scenario:
    """Return the scene that given TOML tables describe, under the name of `scenario`.

    Parameters
    ----------
    tables : the tables of the new scene's file
    changes : words for what differs from `scenario`, which are added to its title; if empty, the
        title is the one in `tables`

    Raises
    ------
    ScenarioError
        If the tables do not make a valid scene.
    """
    changed = deepcopy(dict(tables))
    if changes:
        changed["title"] = f"{scenario.title}, with {changes}"
    return loads(to_toml(changed), scenario.name)
