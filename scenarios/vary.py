"""Any number of a scene file by its path, varied over a range.

A varied scene goes through the same model as a file: what no file may hold, no point of a map may.
"""

import difflib
import math
import re
import tomllib
from collections.abc import Iterator, Mapping
from copy import deepcopy
from dataclasses import dataclass
from typing import Any

import numpy as np

from .float_array import FloatArray
from .load import loads
from .scenario import OF_THE_SCENE_ALONE, Scenario
from .write import to_toml

#: The one path that is no number of the scene file, s.
TIMESTEP = "timestep"
#: Values of an axis that does not say how many.
DEFAULT_COUNT = 20
#: Values of an axis, at most.
MAX_COUNT = 1000
FORM = "PATH=LO:HI[:COUNT][:log]"

#: No number to vary: it marks the file.
_MARKER = "spincheck"
_STEP = re.compile(r"([^.\[\]]+)|\[(\d+)\]")


class VaryError(ValueError):
    """A range that cannot be used; the message names path, rule and value."""


@dataclass(frozen=True)
class Axis:
    """A number that is varied.

    Attributes
    ----------
    path : where it stands in the scene file, as in `start.omega_body[2]`, or `timestep`
    values : in the scene file's units, increasing
    logarithmic : whether they are evenly spaced in their logarithms
    """

    path: str
    values: tuple[float, ...]
    logarithmic: bool


def parse_axis(text: str) -> Axis:
    """The axis that is written as ``PATH=LO:HI[:COUNT][:log]``.

    Raises
    ------
    VaryError
        If it is written otherwise, or the range is empty.
    """
    path, _, range_text = text.partition("=")
    low_text, _, rest = range_text.partition(":")
    high_text, *options = rest.split(":")
    logarithmic = options[-1:] == ["log"]
    counts = options[:-1] if logarithmic else options
    try:
        low, high = float(low_text), float(high_text)
        (count,) = map(int, counts) if counts else [DEFAULT_COUNT]
    except ValueError:
        raise VaryError(f"must be '{FORM}', got '{text}'") from None
    path = path.strip()
    if not path:
        raise VaryError(f"must be '{FORM}', got '{text}'")
    if not -math.inf < low < high < math.inf:
        raise VaryError(f"{path}: LO must be less than HI, got {low:g} and {high:g}")
    if not 2 <= count <= MAX_COUNT:
        raise VaryError(f"{path}: COUNT must be 2 to {MAX_COUNT}, got {count}")
    if low <= 0 and (logarithmic or path == TIMESTEP):
        what = "a timestep" if path == TIMESTEP else "LO of a logarithmic range"
        raise VaryError(f"{path}: {what} must be positive, got {low:g}")
    values = _spaced(low, high, count, logarithmic)
    if not (np.isfinite(values).all() and (np.diff(values) > 0).all()):
        raise VaryError(f"{path}: no {count} different doubles from {low!r} to {high!r}")
    return Axis(path, tuple(values.tolist()), logarithmic)


def check_path(scenario: Scenario, path: str) -> None:
    """See that a path names a number that a scene has, or the timestep.

    Raises
    ------
    VaryError
        If it does not.
    """
    paths = [*numbers(tomllib.loads(scenario.text)), TIMESTEP]
    if path not in paths:
        close = difflib.get_close_matches(path, paths, n=1)
        hint = f"did you mean '{close[0]}'? " if close else ""
        listed = ", ".join(paths)
        raise VaryError(f"{path}: no number of {scenario.name}; {hint}its numbers: {listed}")


def numbers(tables: Mapping[str, Any]) -> Iterator[str]:
    """The paths of a scene file's numbers, but for those that are of this scene alone."""
    for key, value in tables.items():
        if key not in (*OF_THE_SCENE_ALONE, _MARKER):
            yield from _numbers_in(value, key)


def varied(scenario: Scenario, values: Mapping[str, float]) -> Scenario:
    """The scene with other numbers, of the same name, without what holds of it alone.

    Parameters
    ----------
    values : by path; the scene has each of them

    Raises
    ------
    ScenarioError
        If there is no such scene.
    """
    changed = own_tables(scenario)
    for path, value in values.items():
        _set(changed, path, value)
    changes = ", ".join(f"{path} = {value!r}" for path, value in values.items())
    return rewritten(scenario, changed, changes)


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


def _spaced(low: float, high: float, count: int, logarithmic: bool) -> FloatArray:
    with np.errstate(all="ignore"):
        return np.asarray((np.geomspace if logarithmic else np.linspace)(low, high, count))


def _numbers_in(value: Any, path: str) -> Iterator[str]:
    if isinstance(value, Mapping):
        for key, entry in value.items():
            yield from _numbers_in(entry, f"{path}.{key}")
    elif isinstance(value, list):
        for index, entry in enumerate(value):
            yield from _numbers_in(entry, f"{path}[{index}]")
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield path


def _set(tables: dict[str, Any], path: str, value: float) -> None:
    steps: list[Any] = [key or int(index) for key, index in _STEP.findall(path)]
    place: Any = tables
    for step in steps[:-1]:
        place = place[step]
    # A whole number stays one.
    whole = isinstance(place[steps[-1]], int) and value.is_integer()
    place[steps[-1]] = int(value) if whole else value
