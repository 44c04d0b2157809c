"""An engine at another version: it runs in worker processes that import from its folder first."""

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

#: The packages of spincheck that a worker process under another Python imports.
PACKAGES = tuple(f"spincheck.{part}" for part in ("engines", "reference", "reports", "scenarios"))


#: Functions of the adapter that do not use the engine's package: any process may call them.
WITHOUT_PACKAGE = frozenset({"applies_to", "at_version", "defaults", "left_out", "script"})


@final
class VersionedEngine(Engine):
    """An engine at another version of its package, driven by the same adapter.

    It opens scenes only in a process that imports modules from the folder `site` first, so that the
    adapter uses this version. All members of `Engine` that this class does not define are forwarded
    to the adapter.

    Parameters
    ----------
    base : name of the engine, without a version
    version : the version, such as "3.1.6"
    methods : the methods, with their orders in this version
    site : the folder that the version is installed in
    """

    def __init__(self, base: str, version: str, methods: tuple[Method, ...], site: Path) -> None:
        self.name = f"{base}@{version}"
        self.methods = methods
        self._base, self._version, self._site = base, version, str(site)

    @property
    def version(self) -> str:
        """The version, such as "3.1.6"."""
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
        """Open a scene by the adapter; return the session.

        `EngineError` is raised in a process that has not imported this version.
        """
        return self._adapter().open(scenario, method, timestep)

    def _adapter(self) -> Engine:
        """Return the adapter; raise `EngineError` if it uses another version in this process."""
        adapter = engines().get(self._base)
        if adapter is None:
            raise EngineError(f"{self.name} cannot be imported")
        if adapter.version != self._version:
            raise EngineError(
                f"{self.name} runs in a process of its own; this one has {adapter.version}"
            )
        return adapter


def _forwarded(name: str) -> Callable[..., Any]:
    """Return a function that calls the adapter's function of the given name.

    `EngineError` is raised if the adapter uses another version in this process, unless the
    function does not use the engine's package (`WITHOUT_PACKAGE`).
    """

    def forward(self: VersionedEngine, *args: Any, **kwargs: Any) -> Any:
        adapter = engines()[self._base] if name in WITHOUT_PACKAGE else self._adapter()
        return getattr(adapter, name)(*args, **kwargs)

    return forward


def _shared(name: str) -> property:
    """Return a property that is the adapter's attribute `name`, the same in any version."""
    return property(lambda self: getattr(engines()[self._base], name))


for _name, _member in vars(Engine).items():
    if _name.startswith("_") or _name in vars(VersionedEngine) or hasattr(_member, "__final__"):
        continue
    setattr(VersionedEngine, _name, (_forwarded if callable(_member) else _shared)(_name))


def versioned(name: str, python: str = "", say: Say = len) -> VersionedEngine:
    """Return an engine at another version, which is installed first if it is not yet.

    Parameters
    ----------
    name : engine@version, such as mujoco@3.1.6
    python : command of the Python interpreter that the engine is to run under; empty for this one
    say : called with a sentence before anything is downloaded

    Raises
    ------
    VersionError
        If there is no such engine, its adapter supports no other versions, the version has not the
        form of one, the interpreter cannot be used, or pip cannot install the version.
    PermissionError
        If others may write to the user's cache folder; see `user_cache`.
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
