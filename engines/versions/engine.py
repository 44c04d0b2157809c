"""An engine at another version; it runs in processes that import from its folder first."""

import inspect
from collections.abc import Collection
from importlib import import_module
from pathlib import Path
from typing import final

from ...scenarios import Scenario
from ..checks.read_back import BodyReading, Difference, EngineError, State
from ..discovery import engines
from ..engine import Engine, Method
from ..session import Session
from .folders import VersionError, install, install_for

#: What a worker of another Python imports of spincheck.
PACKAGES = tuple(f"spincheck.{part}" for part in ("engines", "reference", "reports", "scenarios"))


@final
class VersionedEngine(Engine):
    """The adapter of an engine on another version of its package.

    It opens scenes in a process in which modules are found in `site` first, and that has imported
    no other version before.
    """

    def __init__(self, base: str, version: str, methods: tuple[Method, ...], site: Path) -> None:
        newest = engines()[base]
        self.name = f"{base}@{version}"
        self.methods = methods
        self.single_precision = newest.single_precision
        self.stock_timestep = newest.stock_timestep
        self.of_file = newest.of_file
        self._slack = newest.slack
        self._base, self._version, self._site = base, version, str(site)

    @property
    def version(self) -> str:
        """As it was asked for."""
        return self._version

    @property
    def site(self) -> str:
        """The folder it is installed in."""
        return self._site

    @property
    def slack(self) -> float:
        """As of the adapter."""
        return self._slack

    @property
    def sources(self) -> tuple[Path, ...]:
        """As of the adapter."""
        file = Path(inspect.getfile(type(engines()[self._base])))
        return tuple(sorted(file.parent.glob("*.py")))

    def open(self, scenario: Scenario, method: Method, timestep: float) -> Session:
        """As the adapter opens it."""
        return self._adapter().open(scenario, method, timestep)

    def applies_to(self, scenario: Scenario) -> bool:
        """As the adapter does."""
        return engines()[self._base].applies_to(scenario)

    def differences(
        self, scenario: Scenario, method: str, body: BodyReading, state: State
    ) -> list[Difference]:
        """As the adapter tells them."""
        return self._adapter().differences(scenario, method, body, state)

    def script(self, scenario: Scenario, method: Method, timestep: float) -> str:
        """As the adapter writes it."""
        return engines()[self._base].script(scenario, method, timestep)

    def left_out(self, scenario: Scenario, method: Method) -> tuple[str, ...]:
        """Of this version."""
        return self._adapter().left_out(scenario, method)

    def open_unpruned(
        self,
        scenario: Scenario,
        method: Method,
        timestep: float,
        left_in: Collection[str] | None = None,
    ) -> Session | None:
        """As the adapter opens it."""
        return self._adapter().open_unpruned(scenario, method, timestep, left_in)

    def _adapter(self) -> Engine:
        adapter = engines().get(self._base)
        if adapter is None:
            raise EngineError(f"{self.name} cannot be imported")
        if adapter.version != self._version:
            raise EngineError(
                f"{self.name} runs in a process of its own; this one has {adapter.version}"
            )
        return adapter


def versioned(name: str, python: str = "") -> VersionedEngine:
    """An engine@version, installed if it is not there.

    Parameters
    ----------
    python : the command of another interpreter that it is to run under

    Raises
    ------
    VersionError
        If there is no such engine, it has no other versions, or pip cannot install it.
    """
    base, _, version = name.partition("@")
    if base not in engines():
        raise VersionError(f"'{base}' must be one of {', '.join(engines())}")
    release = engines()[base].at_version(version)
    if release is None:
        raise VersionError(f"'{base}' cannot be had in other versions")
    installed_as = f"{release.installed_as or base}@{version}"
    if python:
        code = [Path(next(iter(import_module(name).__path__))) for name in PACKAGES]
        site = install_for(python, installed_as, release.requirements, code)
    else:
        site = install(installed_as, release.requirements)
    return VersionedEngine(base, version, release.methods, site)
