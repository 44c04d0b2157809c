"""What results rest on, as digests: results are made anew when it has changed, and only then."""

import inspect
from collections.abc import Sequence
from functools import cache
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path

from ... import engines as engines_package
from ... import reference, scenarios
from ...engines import Engine
from ...scenarios import Scenario

#: What decides here which runs are made, and what is said of them; the others only show it.
_DECIDING = ("workers", "runs", "costs", "study")


def digests(scenario: Scenario, engines: Sequence[Engine]) -> dict[str, str]:
    """By engine name, of its version and adapter; under "", of the scene and of this program."""
    return {"": _digest(scenario.text.encode(), program())} | {
        engine.name: _digest(engine.version.encode(), _adapter(type(engine))) for engine in engines
    }


@cache
def program() -> bytes:
    """The version, and the sources themselves: who changes them does not always count it up."""
    folders = [Path(package.__path__[0]) for package in (scenarios, reference, engines_package)]
    folders += [Path(__file__).parents[1] / name for name in _DECIDING]
    sources = [path for folder in folders for path in sorted(folder.glob("*.py"))]
    parts = (path.read_bytes() for path in sources)
    return _digest(version("spincheck").encode(), *parts).encode()


@cache
def _adapter(kind: type[Engine]) -> bytes:
    """The module that defines an engine, wherever it is; empty if it was never a file."""
    try:
        return Path(inspect.getfile(kind)).read_bytes()
    except (TypeError, OSError):
        return b""


def _digest(*parts: bytes) -> str:
    digest = sha256()
    for part in parts:
        # Of each part by itself, so that nothing depends on where one ends and the next begins.
        digest.update(sha256(part).digest())
    return digest.hexdigest()
