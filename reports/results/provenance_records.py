"""Records of where results come from: computer, engines, and what else they rest on."""

from dataclasses import dataclass

from ...engines import Engine, Method
from .records import Name, Record, SceneName, Size


@dataclass(frozen=True)
class EnvironmentEntry(Record):
    """Name and value of something that results may depend on."""

    name: str
    value: str


@dataclass(frozen=True)
class DeclaredEngine(Record):
    """What an adapter declares, stored so that a report needs no engine.

    Attributes
    ----------
    methods, stock_timestep, single_precision : as in `Engine`
    """

    name: Name
    methods: tuple[Method, ...]
    stock_timestep: Size | None = None
    single_precision: bool = False

    @staticmethod
    def of(engine: Engine) -> "DeclaredEngine":
        """Return what an engine's adapter declares."""
        return DeclaredEngine(
            engine.name, tuple(engine.methods), engine.stock_timestep, engine.single_precision
        )


@dataclass(frozen=True)
class Fingerprint(Record):
    """The digest of a part of what results of a scene depend on.

    Attributes
    ----------
    engine : the engine whose results depend on it; empty if those of all engines do
    kind : the part: the exact motion, the program that makes runs, the engine, …
    """

    scenario: SceneName
    engine: str
    kind: str
    digest: str
