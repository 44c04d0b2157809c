"""Fixtures of more than one folder, and what is skipped where PyBullet is not installed."""

import re
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import pytest

HAS_PYBULLET = find_spec("pybullet") is not None
NO_PYBULLET = "the package 'pybullet' is not installed"


class WithoutPyBullet(pytest.Module):
    """A test file that imports PyBullet, which is not there."""

    def collect(self) -> Iterator[pytest.Item]:
        pytest.skip(NO_PYBULLET, allow_module_level=True)


def pytest_pycollect_makemodule(
    module_path: Path, parent: pytest.Collector
) -> pytest.Module | None:
    """Skip files that import PyBullet where it is not installed."""
    text = module_path.read_text(encoding="utf-8")
    if HAS_PYBULLET or not re.search(r"^(import|from) .*pybullet", text, re.MULTILINE):
        return None
    module: pytest.Module = WithoutPyBullet.from_parent(parent, path=module_path)
    return module


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Skip marked tests without PyBullet; of parametrised ones, the cases that name it."""
    case = getattr(item, "callspec", None)
    names_it = case is None or "pybullet" in case.id
    if not HAS_PYBULLET and names_it and item.get_closest_marker("needs_pybullet"):
        pytest.skip(NO_PYBULLET)


@pytest.fixture
def engines_in_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """The items of scenario files run their engines in this process."""
    from spincheck.reports.cli import scene_items
    from spincheck.reports.harness.executors import InProcess

    monkeypatch.setattr(scene_items, "_worker", lambda _: InProcess())
