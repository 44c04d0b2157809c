"""Finds the engines under node. Each is started once, and its description of itself is stored."""

import shutil
from collections.abc import Iterator
from contextlib import suppress
from functools import partial
from hashlib import sha256
from pathlib import Path

from spincheck.engine import Engine, EngineError, Missing

from ....scenarios.regular_files import read_regular, write_new
from ...child import ChildEngine, child_engine
from ...child.messages import Hello
from ...child.process import LONGEST_ANSWER
from ...user_cache import user_cache
from .script import script

HERE = Path(__file__).parent
#: Modules that the engines' `.mjs` files import.
PARTS = tuple(sorted((HERE / "parts").glob("*.mjs")))
LOCK = HERE / "package-lock.json"
#: Name by which users ask for all engines under node (`Engine.family`).
FAMILY = "node"
HOW = "python -m spincheck.engines.adapters.node"


def discovered() -> Iterator[Engine | Missing]:
    """Yield the engine of each `.mjs` file in this folder; a `Missing` if it cannot be used."""
    files = sorted(HERE.glob("*.mjs"))
    if shutil.which("node") is None:
        yield from (Missing(f.stem, "node", "node is not installed", FAMILY) for f in files)
        return
    modules = modules_folder()
    for path in files:
        if modules.is_dir():
            yield _engine(path, modules)
        else:
            reason = f"its npm package is not installed; '{HOW}' does it, for all of them"
            yield Missing(path.stem, path.stem, reason, FAMILY)


def modules_folder() -> Path:
    """Return the folder of the npm packages, which exists if they are installed.

    The path has a digest of `package-lock.json`, so that other versions have another folder.
    """
    digest = sha256(LOCK.read_bytes()).hexdigest()[:16]
    return user_cache() / "node" / digest / "node_modules"


def _engine(path: Path, modules: Path) -> ChildEngine | Missing:
    """Return the engine in a file, or a `Missing` with the reason if it does not start.

    The engine is started only if its description is not stored yet; the description is then stored.

    Parameters
    ----------
    path : the engine's `.mjs` file
    modules : folder of the npm packages
    """
    command = ("node", str(path), str(modules))
    hello = _said_before(path, modules)
    if hello is not None:
        return _child_engine(command, hello, path)
    try:
        engine = child_engine(command)
    except EngineError as error:
        return Missing(path.stem, "", f"it does not start: {error}", FAMILY)
    with suppress(OSError):
        write_new(_memory(path, modules), engine.hello.model_dump_json())
    return _child_engine(command, engine.hello, path)


def _child_engine(command: tuple[str, ...], hello: Hello, path: Path) -> ChildEngine:
    """Return the engine that a command starts.

    Parameters
    ----------
    hello : the engine's description of itself
    path : the engine's `.mjs` file
    """
    sources = (path, *PARTS, LOCK)
    engine = ChildEngine(command, hello, sources=sources, script=partial(script, path))
    engine.family = FAMILY
    return engine


def _said_before(path: Path, modules: Path) -> Hello | None:
    """Return an engine's stored description; None if none is stored or it cannot be read.

    Parameters
    ----------
    path : the engine's `.mjs` file
    modules : folder of the npm packages
    """
    try:
        return Hello.model_validate_json(read_regular(_memory(path, modules), LONGEST_ANSWER))
    except (OSError, ValueError):
        return None


def _memory(path: Path, modules: Path) -> Path:
    """Return the path of the file that stores an engine's description.

    It is beside the folder of npm packages, `modules`. Its name has a digest of the engine's `.mjs`
    file, `path`, and of the JavaScript modules `PARTS` that such files import.
    """
    files = (path, *PARTS)
    digest = sha256(b"".join(file.read_bytes() for file in files)).hexdigest()[:16]
    return modules.parent / f"{path.stem}-{digest}.json"
