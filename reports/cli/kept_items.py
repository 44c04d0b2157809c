"""Outcomes of scenes' test items, kept in pytest's cache until something they depend on changes.

Only items that passed or were skipped are kept. Items that failed are run again in every session.
"""

from collections.abc import Iterator
from hashlib import sha256
from importlib.util import find_spec
from pathlib import Path

import pytest

from ...engines import Engine, Method
from ...scenarios import Scenario
from ..results.fingerprints import fingerprints
from ..results.sources import source

_FOLDER = "spincheck"


def outcome_of(item: pytest.Item, rests_on: str) -> str | None:
    """Return the outcome of a test item, if it was kept in an earlier session of pytest.

    Parameters
    ----------
    rests_on : digest of all that the outcome depends on, from the function `rests_on`

    Returns
    -------
    Why the item was skipped; empty if it passed; None if the item must be run, because no outcome
    is kept or the digest has changed.
    """
    cache = _cache(item)
    match cache and cache.get(_place(item), None):
        case [str(digest), str(outcome)] if digest == rests_on:
            return outcome
    return None


def keep(item: pytest.Item, rests_on: str, outcome: str) -> None:
    """Store the outcome of a test item in pytest's cache, in place of an earlier outcome.

    Parameters
    ----------
    rests_on : digest of all that the outcome depends on, from the function `rests_on`
    outcome : why the item was skipped; empty if it passed
    """
    if cache := _cache(item):
        cache.set(_place(item), [rests_on, outcome])


def _cache(item: pytest.Item) -> pytest.Cache | None:
    """Return pytest's cache; None if it is switched off."""
    return getattr(item.config, "cache", None)


def rests_on(scenario: Scenario, engine: Engine, method: Method, max_steps: int) -> str:
    """Return a digest of all that the outcome of an engine's test item depends on.

    It covers the scene, the program, the adapter, the engine, the method and the ladder's length.

    Parameters
    ----------
    max_steps : largest number of steps of a run
    """
    items = Path(__file__).with_name("scene_items.py")
    parts = [one.digest for one in fingerprints(scenario, [engine]) if one.kind != "timing"]
    parts += [method.name, str(max_steps), source(items).digest, *_native_files(engine)]
    return sha256("\n".join(parts).encode()).hexdigest()


def _native_files(engine: Engine) -> Iterator[str]:
    """Yield name, size and time of change of each native library in an engine's package.

    These change when the engine is built again, even if its version does not.
    """
    package = engine.package or engine.family or engine.name
    spec = find_spec(package) if package.isidentifier() else None
    for folder in (spec and spec.submodule_search_locations) or ():
        yield from map(_stamp, sorted(Path(folder).rglob("*.so*")))
    if spec and spec.origin and not spec.submodule_search_locations:
        yield _stamp(Path(spec.origin))


def _stamp(file: Path) -> str:
    """Return, as text, a file's name, its size in bytes and its time of change in ns."""
    found = file.stat()
    return f"{file.name} {found.st_size} {found.st_mtime_ns}"


def _place(item: pytest.Item) -> str:
    """Return the key of a test item in pytest's cache.

    The key has a digest in place of the item's name: pytest stores the entry in a file of the key's
    name, and not every system allows an item's name as that of a file.
    """
    return f"{_FOLDER}/{sha256(item.nodeid.encode()).hexdigest()[:16]}"
