"""Finds the engines: every module in `adapters/`, and entry points of other packages."""

import importlib
import pkgutil
from dataclasses import dataclass
from functools import cache
from importlib.metadata import entry_points
from inspect import isabstract
from types import ModuleType

from . import adapters
from .engine import Engine

ENTRY_POINTS = "spincheck.engines"


@dataclass(frozen=True)
class Missing:
    """An engine whose package is not installed."""

    name: str
    package: str


@cache
def engines() -> dict[str, Engine]:
    """Every engine that can be used here, by name, sorted.

    Raises
    ------
    ValueError
        If two engines share a name.
    """
    return dict(sorted(_discover()[0].items()))


@cache
def missing() -> tuple[Missing, ...]:
    """The engines that cannot be used here because a package is not installed."""
    return _discover()[1]


@cache
def _discover() -> tuple[dict[str, Engine], tuple[Missing, ...]]:
    found: dict[str, Engine] = {}
    absent: list[Missing] = []
    names = [f"{adapters.__name__}.{info.name}" for info in pkgutil.iter_modules(adapters.__path__)]
    names += [point.value for point in entry_points(group=ENTRY_POINTS)]
    for name in names:
        try:
            module = importlib.import_module(name)
        except ModuleNotFoundError as error:
            if error.name is None or error.name.startswith("spincheck"):
                raise
            absent.append(Missing(name.rpartition(".")[2], error.name))
            continue
        for engine in _engines_in(module):
            if engine.name in found:
                raise ValueError(f"two engines are named '{engine.name}'; rename one.")
            found[engine.name] = engine
    return found, tuple(absent)


def _engines_in(module: ModuleType) -> list[Engine]:
    """One instance of each engine class that the module itself defines."""
    return [
        cls()
        for cls in vars(module).values()
        if isinstance(cls, type)
        and issubclass(cls, Engine)
        and not isabstract(cls)
        and cls.__module__ == module.__name__
    ]
