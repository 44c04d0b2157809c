"""Digests of what results rest on: a result is outdated if its digest has changed since.

Of the program's modules, only those that a result can depend on are included: the modules that
compute it, and all that these import. Their docstrings, comments and layout do not matter.
"""

import inspect
from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from hashlib import sha256
from importlib import import_module
from pathlib import Path
from sysconfig import get_paths

from ...engines import Engine
from ...scenarios import Scenario
from .provenance_records import Fingerprint
from .sources import Import, source

_PROGRAM = "spincheck"
_ROOTS = {
    name: Path(import_module(f"...{name}", __package__).__path__[0])
    for name in ("scenarios", "reference", "engines", "reports")
}
#: Name of the module from which adapters import the interface of engines.
_INTERFACE = "engine"
_ROOTS[_INTERFACE] = Path(import_module(_PROGRAM).__path__[0]) / _INTERFACE
#: The folders of installed packages, whose modules change with the version of the engine.
_INSTALLED = {get_paths()[kind] for kind in ("purelib", "platlib")}
#: The modules that determine each kind of result, together with all that these import.
DECIDING = {
    "motion": ("reference.solve",),
    "run": (
        "engines.engine",
        "reports.harness.comparison.rows",
        "reports.harness.comparison.defects",
        "reports.harness.timesteps.ladder",
        "reports.harness.measuring.examine",
        "reports.harness.measuring.replay",
        "reports.harness.timesteps.stock",
        "reports.harness.varied.point",
        "reports.harness.varied.defaults",
    ),
    "timing": ("reports.harness.costs.timing",),
    "verdict": ("reports.harness.convergence_study", "reports.harness.judging.verdict"),
}
#: First parts of the names of modules that judge the numbers of runs. They also decide where a
#: ladder ends, but the numbers of a run do not depend on them: only verdicts rest on them.
JUDGING = ("reports.harness.judging", "reports.harness.convergence_study", "reports.harness.plan")
#: The package that stores results, on which no result depends; and those of its modules on which
#: verdicts depend nevertheless.
_STORING, _RULING = "reports.results", ("reports.results.verdict_words", "reports.results.evidence")


def fingerprints(scenario: Scenario, engines: Sequence[Engine]) -> Iterator[Fingerprint]:
    """Yield the digests of all that results of a scene depend on.

    There is one for each kind of result, and one for each engine. That of a kind of result is made
    from the modules that determine it; those of the exact motion and of the verdict also from the
    scene. If an engine is installed in a folder of its own, as other versions of it are, its digest
    includes the folder's name, which ends with the version of Python that it runs under; if it is a
    program, its digest includes the arguments that the program is started with.
    """
    scene = {"motion": scenario.digest, "verdict": scenario.judged_digest}
    for kind in DECIDING:
        yield Fingerprint(scenario.name, "", kind, _digest([program(kind), scene.get(kind, "")]))
    for engine in engines:
        parts = [engine.version, Path(engine.site).name, adapter(type(engine))]
        parts += [*engine.arguments, *(_content(path) for path in engine.sources)]
        yield Fingerprint(scenario.name, engine.name, "engine", _digest(parts))


@cache
def program(kind: str) -> str:
    """Return the digest of all modules on which a kind of result depends (`DECIDING`)."""
    return _digest(_content(_file(name)) for name in sorted(modules(kind)))


@cache
def modules(kind: str) -> frozenset[str]:
    """Return the names of this program's modules on which a kind of result depends.

    Parameters
    ----------
    kind : one of the keys of `DECIDING`
    """
    without = () if kind == "verdict" else JUDGING
    return _closure(DECIDING[kind], without)


@cache
def adapter(kind: type[Engine]) -> str:
    """Return the digest of an adapter's source, and of all modules of this program that it imports.

    It is empty if the class has no source file. If the adapter has a folder of its own, all Python
    files in there are its source; if it is a user's file, so are the modules beside it that it
    imports, at any depth.

    Parameters
    ----------
    kind : the adapter's class
    """
    try:
        file = Path(inspect.getfile(kind))
    except (TypeError, OSError):
        return ""
    is_package = (file.parent / "__init__.py").is_file() and kind.__module__.count(".") > 0
    own_folder = is_package and file.parent != _ROOTS["engines"] / "adapters"
    files = sorted(file.parent.rglob("*.py")) if own_folder else [file]
    package = kind.__module__.rpartition(".")[0].removeprefix(f"{_PROGRAM}.")
    found = [path for path in files if path.is_file()]
    depth = kind.__module__.count(".") + (file.name == "__init__.py")
    root = file.parents[min(depth, len(file.parents) - 1)]
    if kind.__module__.partition(".")[0] != _PROGRAM and str(root) not in _INSTALLED:
        found = _with_imported(found, root)
    imported = {name for path in found for name in _imported(path, package)}
    names = sorted(_closure(imported, ()))
    return _digest([*map(_content, found), *(_content(_file(name)) for name in names)])


def _with_imported(files: Iterable[Path], root: Path) -> list[Path]:
    """Return Python files, and the modules below a folder that they import, at any depth.

    Parameters
    ----------
    files : the files, which are below `root`
    root : the folder from which absolute imports begin
    """
    found: set[Path] = set()
    left = list(files)
    while left:
        path = left.pop()
        if path in found:
            continue
        found.add(path)
        for one in source(path).imports:
            base = [root, *path.parents][: one.level + 1][-1]
            base = base.joinpath(*filter(None, one.module.split(".")))
            modules = [base, *(base / name for name, _ in one.names)]
            left += [file for module in modules for file in _files_of(module)]
    return sorted(found)


def _files_of(module: Path) -> list[Path]:
    """Return the source of a module or package, given its path without a suffix.

    The list is empty if there is no such file.
    """
    files = module.with_name(f"{module.name}.py"), module / "__init__.py"
    return [file for file in files if file.is_file()]


def _closure(names: Iterable[str], without: tuple[str, ...]) -> frozenset[str]:
    """Return the names of modules and of all modules that they import, at any depth.

    Modules that only store results are left out.

    Parameters
    ----------
    names : names of the modules to begin with
    without : first parts of the names of further modules that are left out
    """
    found: set[str] = set()
    left = list(names)
    while left:
        name = left.pop()
        stores = name.startswith(_STORING) and name not in _RULING
        if name in found or stores or name.startswith(without):
            continue
        found.add(name)
        left += _imported_by(name)
    return frozenset(found)


@cache
def _imported_by(name: str) -> tuple[str, ...]:
    """Return the names of the modules of this program that a module imports."""
    is_package = _file(name).name == "__init__.py"
    return tuple(_imported(_file(name), name if is_package else name.rpartition(".")[0]))


def _imported(path: Path, package: str) -> Iterator[str]:
    """Yield the names of this program's modules that a file imports, even inside functions.

    Parameters
    ----------
    path : the file
    package : name of the package that the file is in
    """
    for one in source(path).imports:
        base = _base(one, package)
        if base is not None:
            for name, _ in one.names:
                yield _defining(base, name)


def _base(one: Import, package: str) -> str | None:
    """Return the name of the module or package after `from`; None if it is not of this program.

    Parameters
    ----------
    one : the import
    package : name of the package that contains the importing module
    """
    if one.level:
        parts = package.split(".")
        base = ".".join([*parts[: len(parts) + 1 - one.level], *filter(None, [one.module])])
    elif one.module.startswith(f"{_PROGRAM}."):
        base = one.module.removeprefix(f"{_PROGRAM}.")
    else:
        return None
    return base if base.partition(".")[0] in _ROOTS and _file(base).is_file() else None


@cache
def _defining(base: str, name: str) -> str:
    """Return the name of the module that defines a name imported from a module or package.

    If a package, or the interface of engines, has only imported the name itself, the module that it
    was imported from is returned.

    Parameters
    ----------
    base : name of the module or package that the name is imported from
    name : the imported name, which may be that of a module
    """
    if _file(f"{base}.{name}").is_file():
        return f"{base}.{name}"
    if base == _INTERFACE or _file(base).name == "__init__.py":
        for one in source(_file(base)).imports:
            origin = _base(one, base) if one.outside else None
            for imported, given in one.names:
                if given == name and origin is not None:
                    return _defining(origin, imported)
    return base


def _file(name: str) -> Path:
    """Return the path of a module, or the path of a package's `__init__.py`, given its name."""
    root, *parts = name.split(".")
    folder = _ROOTS[root].joinpath(*parts)
    return folder / "__init__.py" if folder.is_dir() else folder.with_name(f"{folder.name}.py")


@cache
def _content(path: Path) -> str:
    """Return the digest of a file; docstrings, comments and layout of Python are left out."""
    if path.suffix != ".py":
        return _digest([path.read_bytes().hex()])
    return source(path).digest


def _digest(parts: Iterable[str]) -> str:
    """Return the SHA-256, hexadecimal, of several texts."""
    return sha256("\n".join(parts).encode()).hexdigest()
