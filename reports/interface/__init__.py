"""Exact motions of spinning bodies, and what physics engines make of them.

The Python interface: what stands in `__all__` is stable, everything else is private. Modules are
imported when a function is called, so that importing `spincheck` takes no time.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike
    from spincheck.reports.harness.recorded.judged import JudgedMotion
    from spincheck.reports.results.records import Row
    from spincheck.reports.results.store import Results
    from spincheck.scenarios import Scenario

    from .exact import ExactMotion

__all__ = ["exact", "judge", "load", "results", "run"]


def load(scene: "str | Path | Mapping[str, Any] | Scenario") -> "Scenario":
    """Return a scene: by its name in the library, its file's path, or as a dict of its tables.

    Raises
    ------
    spincheck.scenarios.ScenarioError
        If there is no such scene, or it breaks a rule of the format.
    """
    from spincheck.scenarios import Scenario, find, from_tables
    from spincheck.scenarios import load as load_file

    if isinstance(scene, Scenario):
        return scene
    if isinstance(scene, Mapping):
        return from_tables(dict(scene))
    return load_file(find([str(scene)])[0])


def exact(scene: "str | Path | Mapping[str, Any] | Scenario") -> "ExactMotion":
    """Return the exact motion of a scene; ask its method `at` for states.

    Raises
    ------
    spincheck.scenarios.ScenarioError
        As `load`.
    """
    from .exact import ExactMotion

    return ExactMotion(load(scene))
