"""Scenes of the library by name."""

from spincheck.scenarios import Scenario, find, load


def library_scene(name: str) -> Scenario:
    """The scene of that name."""
    (path,) = find([name])
    return load(path)
