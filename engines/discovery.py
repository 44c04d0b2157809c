"""Finds the engines: all of `adapters/`, and the entry points of other packages."""

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
    """An adapter that cannot be imported here.

    Attributes
    ----------
    name : of the adapter
    package : the distribution that is not installed; empty where importing failed otherwise
    reason : one sentence
    """

    name: str
    package: str
    reason: str


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
    """The adapters that cannot be imported here, and why."""
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
        # An engine's package may raise anything when imported; that costs this engine alone.
        except Exception as error:
            absent.append(_missing(name.rpartition(".")[2], error))
            continue
        for engine in _engines_in(module):
            if engine.name in found:
                raise ValueError(f"two engines are named '{engine.name}'; rename one.")
            found[engine.name] = engine
    return found, tuple(absent)


def _missing(name: str, error: Exception) -> Missing:
    if isinstance(error, ModuleNotFoundError) and error.name:
        package = error.name.partition(".")[0]
        if package != "spincheck":
            return Missing(name, package, f"the package '{package}' is not installed")
    words = " ".join(str(error).split())
    return Missing(name, "", f"importing it failed: {type(error).__name__}: {words}")


def _engines_in(module: ModuleType) -> list[Engine]:
    """One instance of each engine class that the module, or a module of its package, defines."""
    return [
        cls()
        for cls in vars(module).values()
        if isinstance(cls, type)
        and issubclass(cls, Engine)
        and not isabstract(cls)
        and f"{cls.__module__}.".startswith(f"{module.__name__}.")
    ]
