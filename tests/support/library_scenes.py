"""Scenes of the library, each loaded once a process."""

from functools import cache
from pathlib import Path

from spincheck.scenarios import Scenario, find, load


def library_scene(name: str) -> Scenario:
    """The scene of that name."""
    (path,) = find([name])
    return _loaded(path)


@cache
def library() -> tuple[Scenario, ...]:
    """All of them."""
    return tuple(map(_loaded, find([])))


@cache
def _loaded(path: Path) -> Scenario:
    return load(path)
