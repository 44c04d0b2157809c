"""Finds the engines: those in `adapters/`, and those that other packages name as entry points."""

import importlib
import pkgutil
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from importlib.metadata import entry_points
from importlib.util import find_spec
from inspect import isabstract
from types import ModuleType

from . import adapters
from .engine import Engine
from .interface import NEWEST, misfit
from .missing import Missing

ENTRY_POINTS = "spincheck.engines"
#: Name of the module from which adapters import the interface.
INTERFACE = "spincheck.engine"
#: How to get the engines that are dependencies of spincheck, by their package.
HOW = {
    "mujoco": "pip install mujoco",
    "pybullet": "pip install pybullet, which compiles it but on Linux x86-64 with Python 3.11",
}


class NameTaken(ValueError):
    """Two engines have the same name."""


@cache
def engines() -> dict[str, Engine]:
    """Return all engines that can be used in this installation, by name, sorted by name.

    Raises
    ------
    NameTaken
        If two engines share a name.
    """
    return dict(sorted(_discover()[0].items()))


def add(engine: Engine) -> None:
    """Add an engine to those of `engines()`, for the rest of this process.

    An engine of the same class and name is replaced.

    Raises
    ------
    NameTaken
        If an engine of another class has the same name.
    """
    if type(engines().setdefault(engine.name, engine)) is not type(engine):
        raise NameTaken(f"'{engine.name}' is another engine's name; rename one.")
    engines()[engine.name] = engine


@cache
def missing() -> tuple[Missing, ...]:
    """Return the engines that cannot be used in this installation, each with the reason.

    Their package is not installed, or their adapter cannot be imported, states something that is
    invalid, or is written for an unsupported version of the interface.

    Raises
    ------
    NameTaken
        If two engines share a name.
    """
    return _discover()[1]


@cache
def _discover() -> tuple[dict[str, Engine], tuple[Missing, ...]]:
    """Return the engines that can be used, by name, and those that cannot, with reasons.

    It raises `NameTaken` if two engines share a name.
    """
    engines: dict[str, Engine] = {}
    absent: list[Missing] = []
    names = [f"{adapters.__name__}.{info.name}" for info in pkgutil.iter_modules(adapters.__path__)]
    foreign = {point.value: point.name for point in entry_points(group=ENTRY_POINTS)}
    for name in (*names, *foreign):
        try:
            there = _offered(name, foreign.get(name, ""))
        # One engine that cannot be asked hides no other.
        except (Exception, SystemExit) as error:
            absent.append(_missing(name.rpartition(".")[2], error))
            continue
        for engine in there:
            if isinstance(engine, Missing):
                absent.append(engine)
            elif name in foreign and (reason := _misdeclared(engine)):
                absent.append(Missing(name.rpartition(".")[2], "", reason))
            elif engine.name in engines:
                modules = " and ".join(
                    type(one).__module__ for one in (engines[engine.name], engine)
                )
                raise NameTaken(f"two engines are named '{engine.name}', of {modules}; rename one.")
            else:
                engines[engine.name] = engine
    return engines, tuple(absent)


def _offered(value: str, point: str) -> list[Engine | Missing]:
    """Return the engines that a module defines or finds, usable or not.

    If an entry point names something else than a module with engines, the list has one `Missing`
    with this reason; if the module cannot be imported, one with that reason.

    Parameters
    ----------
    value : name of the module, or "module:object", a form of entry point that is not accepted
    point : name of the entry point; empty for an adapter of spincheck
    """
    name, _, member = value.partition(":")
    try:
        module = importlib.import_module(name)
    except KeyboardInterrupt:
        raise
    # An engine's package may raise anything when it is imported: a panic of Rust's code is no
    # `Exception`.
    except BaseException as error:
        return [_missing(value.rpartition(".")[2], error)]
    there = [*_engines_in(module), *_discovered_by(module)]
    if point and (member or not (there or "discovered" in vars(module))):
        rule = "must be a module that defines a complete subclass of spincheck.engine.Engine"
        return [Missing(point, "", f"its entry point {rule}, got '{value}'")]
    return there


def _misdeclared(engine: Engine) -> str:
    """Return why an attribute of an engine is invalid; empty if all are valid.

    The module `declared`, needed only for engines of other packages, is imported only here.
    """
    from .declared import misdeclared

    return misdeclared(engine)


def _missing(name: str, error: BaseException) -> Missing:
    """Return the `Missing` of an adapter that cannot be imported, with the reason in words.

    `name` is the adapter's name, and `error` what importing it raised.
    """
    if isinstance(error, ModuleNotFoundError) and error.name:
        package = error.name.partition(".")[0]
        if package != "spincheck":
            how = f"; {HOW[package]}" if package in HOW else ""
            return Missing(name, package, f"the package '{package}' is not installed{how}")
    words = f"{type(error).__name__}: {' '.join(str(error).split())}"
    if isinstance(error, ImportError) and error.name == INTERFACE:
        # Without the path at the end of the error's message.
        words = f"{str(error).partition(' (')[0]}: this spincheck has its version {NEWEST}"
    return Missing(name, "", f"importing it failed: {words}")


def _engines_in(module: ModuleType) -> Iterator[Engine | Missing]:
    """Yield an instance of each subclass of `Engine` without abstract methods in a module.

    A class that a package imports from its own modules counts, too. A `Missing` with the reason is
    yielded instead if the class is for an unsupported version of the interface, or if the engine's
    package is not installed.
    """
    for cls in vars(module).values():
        if (
            isinstance(cls, type)
            and issubclass(cls, Engine)
            and not isabstract(cls)
            and f"{cls.__module__}.".startswith(f"{module.__name__}.")
        ):
            name = str(getattr(cls, "name", cls.__name__))
            if reason := misfit("interface", getattr(cls, "interface", None)):
                yield Missing(name, "", reason)
                continue
            engine = cls()
            absent = engine.package and find_spec(engine.package) is None
            yield _not_installed(engine) if absent else engine


def _not_installed(engine: Engine) -> Missing:
    """Return the `Missing` of an engine whose package is not installed, with how to install it."""
    how = f"pip install 'spincheck[{engine.extra or engine.name}]'"
    reason = f"the package '{engine.package}' is not installed; {how}"
    return Missing(engine.name, engine.package, reason)


def _discovered_by(module: ModuleType) -> Iterable[Engine | Missing]:
    """Return the engines that a module's function `discovered` finds, if there is one."""
    discovered: Callable[[], Iterable[Engine | Missing]] = vars(module).get("discovered", tuple)
    return discovered()
