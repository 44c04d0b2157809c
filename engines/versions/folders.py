"""The folders that versions of engines are installed into, under the user's cache."""

import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

from ...scenarios import printable
from ..start_process import ISOLATED, run
from ..user_cache import user_cache

#: Wheel tag of the running Python, such as cp312: wheels are for one minor version of Python.
_PYTHON = f"cp{sys.version_info.major}{sys.version_info.minor}"
#: Program that prints the wheel tag of the Python that runs it.
_TAG = "import sys; print(f'cp{sys.version_info.major}{sys.version_info.minor}')"
#: Pattern of the tags of the Pythons that can be used, 3.11 and later.
_TAGGED = re.compile(r"cp3(1[1-9]|[2-9]\d)")
#: Pattern of a version (PEP 440, without epochs and local versions).
_VERSION = re.compile(r"\d+(\.\d+)*([a-z]+\d*)?(\.(post|dev)\d+)?")
#: Largest number of characters of a version.
LONGEST_VERSION = 40
#: Packages that a worker process under another Python needs besides the engine.
RUNS_WITH = ("numpy", "scipy", "pydantic", "mpmath", "numba", "psutil")
#: Longest time that pip may take, s.
_PATIENCE = 600
Say = Callable[[str], object]


class VersionError(Exception):
    """A version of an engine cannot be installed; the message says why.

    Attributes
    ----------
    is_usage : whether the user's command is wrong; if false, installing failed
    """

    def __init__(self, message: str, *, is_usage: bool = False) -> None:
        super().__init__(message)
        self.is_usage = is_usage


def folder_of(name: str, python: str = _PYTHON) -> Path:
    """Return the folder that a version of an engine is installed in, or would be.

    Parameters
    ----------
    name : engine@version
    python : wheel tag of the interpreter, such as cp312
    """
    return _folders() / f"{name}-{python}"


def install(
    name: str, requirements: Sequence[str], surplus: Sequence[str] = (), say: Say = len
) -> Path:
    """Install an engine at a version with pip, unless it is installed; return its folder.

    Parameters
    ----------
    name : engine@version
    requirements : distributions to install, as pip takes them
    surplus : packages that are removed after installing
    say : called with a sentence before anything is downloaded

    Raises
    ------
    VersionError
        If pip fails or does not finish in time. The message has the error that pip printed.
    PermissionError
        If others may write to the user's cache folder; see `user_cache`.
    """

    def fill(target: Path) -> None:
        command = [*_pip(sys.executable), "--no-deps", "--target", str(target), *requirements]
        _call(_not_there(name, requirements), command)
        _drop(target, surplus)

    return _made(folder_of(name), fill, say)


def install_for(
    python: str,
    name: str,
    requirements: Sequence[str],
    code: Sequence[Path],
    surplus: Sequence[str] = (),
    say: Say = len,
) -> Path:
    """Install an engine for another Python, in a virtual environment, unless it is installed.

    Return the folder of the environment.

    Parameters
    ----------
    python : command of the other Python interpreter
    name : engine@version
    requirements : distributions to install, as pip takes them
    code : folders of packages of spincheck, to which the environment gets links
    surplus : packages that are removed after installing
    say : called with a sentence before anything is downloaded

    Raises
    ------
    VersionError
        If there is no such Python, it is too old, the system is Windows, or pip fails or does not
        finish in time. The message has the error that pip printed.
    PermissionError
        If others may write to the user's cache folder; see `user_cache`.
    """
    if sys.platform == "win32":
        words = "'--python' needs an environment as Linux and macOS have it; run it in WSL"
        raise VersionError(words, is_usage=True)
    try:
        tag = _call("it fails", [python, ISOLATED, "-c", _TAG]).strip()
    except VersionError as error:
        raise VersionError(f"'--python' {printable(python)}: {error}", is_usage=True) from None
    if not _TAGGED.fullmatch(tag):
        raise VersionError(
            f"'--python' must be Python 3.11 or later, '{printable(python)}' says "
            f"'{printable(tag, 40)}'",
            is_usage=True,
        )

    def fill(target: Path) -> None:
        _call(f"'{python}' makes no environment", [python, ISOLATED, "-m", "venv", str(target)])
        needed = [*RUNS_WITH, *requirements]
        # The environment's own Python runs pip, so that pip installs into the environment.
        _call(_not_there(name, needed), [*_pip(str(interpreter_of(target))), *needed])
        packages = next(target.glob("lib/python3*/site-packages"))
        _drop(packages, surplus)
        package = packages / "spincheck"
        package.mkdir()
        for folder in code:
            (package / folder.name).symlink_to(folder)

    return _made(folder_of(name, tag), fill, say)


def interpreter_of(site: Path) -> Path:
    """Return the path that the interpreter has if the folder `site` is a virtual environment."""
    return site / "bin" / "python"


def check_version(version: str) -> None:
    """Check that a version, as the user typed it, has the form of a version.

    Raises
    ------
    VersionError
        If it has not this form.
    """
    if len(version) > LONGEST_VERSION or not _VERSION.fullmatch(version):
        raise VersionError(
            f"a version must be like 3.1.6, got '{printable(version, LONGEST_VERSION)}'",
            is_usage=True,
        )


def _pip(python: str) -> list[str]:
    """Return the command of pip that installs distributions; their names are to be appended.

    `python` is the command of the interpreter that pip runs under.
    """
    quietly = ["--quiet", "--no-input", "--only-binary", ":all:", "--disable-pip-version-check"]
    return [python, ISOLATED, "-m", "pip", "install", *quietly]


def _drop(packages: Path, surplus: Sequence[str]) -> None:
    """Remove the packages named in `surplus` from the folder `packages`, if they are there."""
    for name in surplus:
        shutil.rmtree(packages / name, ignore_errors=True)


def _made(folder: Path, fill: Callable[[Path], None], say: Say) -> Path:
    """Make and fill a folder if it does not exist; return its path.

    Parameters
    ----------
    fill : makes and fills a folder at a temporary path, which is then moved to the path `folder`
    say : called with a sentence before anything is made
    """
    if folder.is_dir():
        return folder
    say(f"Installing {folder.name}, once, into {folder.parent}")
    _folders().mkdir(parents=True, exist_ok=True)
    # Made at a temporary path and moved when complete, so that a folder that exists is complete.
    with tempfile.TemporaryDirectory(dir=_folders(), prefix=".new-") as made:
        target = Path(made, "site")
        fill(target)
        try:
            target.replace(folder)
        except OSError:
            # Another process installed the same version meanwhile.
            if not folder.is_dir():
                raise
    return folder


def _not_there(name: str, wanted: Sequence[str]) -> str:
    """Return the beginning of the message that pip cannot install an engine.

    Parameters
    ----------
    name : engine@version
    wanted : the distributions that pip was to install
    """
    return f"{name} is not installed, and pip cannot install {' '.join(wanted)}"


def _call(failing: str, command: Sequence[str]) -> str:
    """Run a command and return what it prints.

    Parameters
    ----------
    failing : beginning of the message if the command fails, which says what could not be done

    Raises
    ------
    VersionError
        If the command cannot be started, fails, or does not finish in time.
    """
    try:
        done = run(command, _PATIENCE)
    except subprocess.TimeoutExpired:
        words = f"'{command[0]}' did not finish within {_PATIENCE} s"
        raise VersionError(f"{failing}: {words}") from None
    except OSError as error:
        words = f"'{command[0]}' cannot be started: {error.strerror}"
        raise VersionError(f"{failing}: {words}") from None
    if done.returncode:
        errors = [line for line in done.stderr.splitlines() if line.startswith("ERROR")]
        last = (errors or done.stderr.splitlines() or ["it said nothing"])[-1]
        raise VersionError(f"{failing}: {last.removeprefix('ERROR: ')}")
    return done.stdout


def _folders() -> Path:
    """Return the folder that contains the folders of all versions."""
    return user_cache() / "engines"
