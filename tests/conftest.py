"""Fixtures of more than one folder, and what is skipped without PyBullet, or on Windows."""

import ctypes
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from importable_files import HAS_PYBULLET, NO_PYBULLET, why_skipped


class Skipped(pytest.Module):
    """A test file that cannot be imported here."""

    def collect(self) -> Iterator[pytest.Item]:
        pytest.skip(why_skipped(self.path), allow_module_level=True)


def pytest_pycollect_makemodule(
    module_path: Path, parent: pytest.Collector
) -> pytest.Module | None:
    """Skip files that cannot be imported here."""
    if not why_skipped(module_path):
        return None
    module: pytest.Module = Skipped.from_parent(parent, path=module_path)
    return module


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Skip marked tests without PyBullet; of parametrised ones, the cases that name it."""
    case = getattr(item, "callspec", None)
    names_it = case is None or "pybullet" in case.id
    if not HAS_PYBULLET and names_it and item.get_closest_marker("needs_pybullet"):
        pytest.skip(NO_PYBULLET)


@pytest.fixture(scope="module", autouse=True)
def memory_is_given_back() -> Iterator[None]:
    """What a file's tests have freed: XLA alone frees 600 MB for each derivative that it compiles.

    glibc keeps it, so that a worker would grow to 4 GB.
    """
    yield
    if sys.platform == "linux" and (trim := getattr(ctypes.CDLL(None), "malloc_trim", None)):
        trim(0)


@pytest.fixture
def engines_in_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """The items of scenario files run their engines in this process."""
    from spincheck.reports.cli import scene_items
    from spincheck.reports.harness.executors import InProcess

    monkeypatch.setattr(scene_items, "_worker", lambda _: InProcess())
