"""Digests of what results depend on: results are made anew when one of them has changed."""

import inspect
from collections.abc import Sequence
from functools import cache
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path

from ... import engines as engines_package
from ... import reference, scenarios
from ...engines import Engine
from ...engines import adapters as adapters_package
from ...scenarios import Scenario

#: The folder of `reports` whose sources decide about results; the others only store or show them.
_DECIDING = "harness"


def digests(scenario: Scenario, engines: Sequence[Engine]) -> dict[str, str]:
    """Digests by engine name, of its version and adapter; under "", of scene and program.

    The digest of an engine at another version includes the name of its folder, which ends with the
    Python that it runs under.
    """
    return {"": _digest(scenario.text.encode(), program())} | {
        engine.name: _digest(
            engine.version.encode(),
            Path(engine.site).name.encode(),
            _adapter(type(engine)),
            *(path.read_bytes() for path in engine.sources),
        )
        for engine in engines
    }


@cache
def program() -> bytes:
    """Digest of the program: its version and its sources, which may change without the version."""
    packages = [Path(package.__path__[0]) for package in (scenarios, reference, engines_package)]
    adapters = Path(adapters_package.__path__[0])
    sources = [
        path
        for folder in (*packages, Path(__file__).parents[1] / _DECIDING)
        for path in sorted(folder.rglob("*.py"))
        # An adapter decides about the results of its own engine only.
        if not path.is_relative_to(adapters)
    ]
    parts = (path.read_bytes() for path in sources)
    return _digest(version("spincheck").encode(), *parts).encode()


@cache
def _adapter(kind: type[Engine]) -> bytes:
    """The sources of an adapter: its module, or all of its package; empty if it has none."""
    try:
        file = Path(inspect.getfile(kind))
    except (TypeError, OSError):
        return b""
    is_package = (file.parent / "__init__.py").is_file() and kind.__module__.count(".") > 0
    own_folder = is_package and file.parent != Path(adapters_package.__path__[0])
    files = sorted(file.parent.rglob("*.py")) if own_folder else [file]
    return _digest(*(path.read_bytes() for path in files if path.is_file())).encode()


def _digest(*parts: bytes) -> str:
    digest = sha256()
    for part in parts:
        # Of each part by itself, so that nothing depends on where one ends and the next begins.
        digest.update(sha256(part).digest())
    return digest.hexdigest()
