"""Records of what results depend on: the computer, the engines, and digests of all else."""

from dataclasses import dataclass

from ...engines import Engine, Method
from .records import Name, Record, SceneName, Size


@dataclass(frozen=True)
class EnvironmentEntry(Record):
    """Name and value of something that results may depend on, such as the version of a package."""

    name: str
    value: str


@dataclass(frozen=True)
class DeclaredEngine(Record):
    """What an adapter declares, stored so that a report needs no engine.

    Attributes
    ----------
    methods : the engine's methods
    stock_timestep : s; None where users have to set a timestep
    single_precision : whether the engine holds its state in floats of 24 bits
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
    scenario : name of the scene
    engine : name of the engine whose results depend on the part; empty if all engines' results do
    kind : name of the part: `engine`, for the engine and its adapter; or a kind of result (a key of
        `fingerprints.DECIDING`), for the modules, and the scene, that determine such results
    digest : SHA-256, hexadecimal
    """

    scenario: SceneName
    engine: str
    kind: str
    digest: str
