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
    """What an adapter declares, so that a report needs no engine; `Engine` explains the fields."""

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
    """The digest of what results of a scene rest on; the engine is empty if all rest on it."""

    scenario: SceneName
    engine: str
    kind: str
    digest: str
