"""An engine at another version, which runs in processes that import from its folder first."""

import inspect
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any, final

from ...scenarios import Scenario, printable
from ..checks.read_back import EngineError
from ..discovery import engines
from ..engine import Engine
from ..method import Method
from ..session import Session
from .folders import Say, VersionError, check_version, install, install_for

#: Packages that a worker of another Python imports of spincheck.
PACKAGES = tuple(f"spincheck.{part}" for part in ("engines", "reference", "reports", "scenarios"))


#: Methods of the adapter that do not use the engine's package, so that any process may call them.
WITHOUT_PACKAGE = frozenset({"applies_to", "at_version", "defaults", "left_out", "script"})


@final
class VersionedEngine(Engine):
    """The adapter of an engine on another version of its package.

    It opens scenes in a process that imports modules from the folder `site` first and has imported
    no other version before. All members of `Engine` that this class does not define are forwarded
    to the adapter.

    Parameters
    ----------
    base : the engine's name
    version : the version, such as "3.1.6"
    methods : the methods, with their orders in that version
    site : the folder that the version is installed in
    """

    def __init__(self, base: str, version: str, methods: tuple[Method, ...], site: Path) -> None:
        self.name = f"{base}@{version}"
        self.methods = methods
        self._base, self._version, self._site = base, version, str(site)

    @property
    def version(self) -> str:
        """The version that was asked for, such as "3.1.6"."""
        return self._version

    @property
    def site(self) -> str:
        """The folder that the version is installed in."""
        return self._site

    @property
    def sources(self) -> tuple[Path, ...]:
        """The source files of the adapter."""
        file = Path(inspect.getfile(type(engines()[self._base])))
        return tuple(sorted(file.parent.glob("*.py")))

    def open(self, scenario: Scenario, method: Method, timestep: float) -> Session:
        """Open a scene as the adapter does, in the process of this version.

        In any other process it raises `EngineError`.
        """
        return self._adapter().open(scenario, method, timestep)

    def _adapter(self) -> Engine:
        """Return the adapter; raise `EngineError` unless this process has the version."""
        adapter = engines().get(self._base)
        if adapter is None:
            raise EngineError(f"{self.name} cannot be imported")
        if adapter.version != self._version:
            raise EngineError(
                f"{self.name} runs in a process of its own; this one has {adapter.version}"
            )
        return adapter


def _forwarded(name: str) -> Callable[..., Any]:
    """Return a method that calls the adapter's method of the same name.

    If that method uses the engine's package, the installed version is checked first.
    """

    def forward(self: VersionedEngine, *args: Any, **kwargs: Any) -> Any:
        adapter = engines()[self._base] if name in WITHOUT_PACKAGE else self._adapter()
        return getattr(adapter, name)(*args, **kwargs)

    return forward


def _shared(name: str) -> property:
    """Return a property with the value of the adapter's attribute, the same in any version."""
    return property(lambda self: getattr(engines()[self._base], name))


for _name, _member in vars(Engine).items():
    if _name.startswith("_") or _name in vars(VersionedEngine) or hasattr(_member, "__final__"):
        continue
    setattr(VersionedEngine, _name, (_forwarded if callable(_member) else _shared)(_name))


def versioned(name: str, python: str = "", say: Say = len) -> VersionedEngine:
    """Return an engine at another version, which is installed unless it is already.

    Parameters
    ----------
    name : engine@version, such as mujoco@3.1.6
    python : the command of another interpreter that it is to run under; empty for this one
    say : called with a sentence before anything is downloaded

    Raises
    ------
    VersionError
        If there is no such engine, it has no other versions, the version is not of the form of one,
        the other interpreter cannot be used, or pip cannot install the version.
    PermissionError
        If the user's cache folder is not safe, as for `user_cache`.
    """
    base, _, version = name.partition("@")
    there = [one for one, engine in engines().items() if engine.at_version("1") is not None]
    if base not in there:
        words = f"'{printable(base)}' cannot be had in other versions, only {', '.join(there)}"
        raise VersionError(words, is_usage=True)
    check_version(version)
    release = engines()[base].at_version(version)
    assert release is not None, "it can be had in other versions"
    installed_as = f"{release.installed_as or base}@{version}"
    if python:
        code = [Path(next(iter(import_module(name).__path__))) for name in PACKAGES]
        site = install_for(python, installed_as, release.requirements, code, release.surplus, say)
    else:
        site = install(installed_as, release.requirements, release.surplus, say)
    return VersionedEngine(base, version, release.methods, site)
