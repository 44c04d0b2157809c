"""The folders that versions of engines are installed into, under the user's cache."""

import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ..user_cache import user_cache

#: Wheels are of one minor version of Python.
_PYTHON = f"cp{sys.version_info.major}{sys.version_info.minor}"
#: What a version may look like (PEP 440, without epochs and local versions).
_VERSION = re.compile(r"\d+(\.\d+)*([a-z]+\d*)?(\.(post|dev)\d+)?")
#: s that pip may take.
_PATIENCE = 600


class VersionError(Exception):
    """A version that cannot be had, and why."""


@dataclass(frozen=True)
class Installed:
    """A version that is there.

    Attributes
    ----------
    name : engine@version
    folder : where
    megabytes : that it takes
    """

    name: str
    folder: Path
    megabytes: float


def folder_of(name: str) -> Path:
    """Where an engine@version is, or would be."""
    return _folders() / f"{name}-{_PYTHON}"


def installed() -> list[Installed]:
    """All that are there, for this Python."""
    found = []
    for folder in sorted(_folders().glob(f"*@*-{_PYTHON}")):
        size = sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())
        name = folder.name.removesuffix(f"-{_PYTHON}")
        found.append(Installed(name, folder, size / 1e6))
    return found


def install(name: str, requirements: Sequence[str]) -> Path:
    """Install an engine@version with pip, unless it is there: then nothing is downloaded.

    Raises
    ------
    VersionError
        If pip cannot; with its last words.
    """
    folder = folder_of(name)
    version = name.partition("@")[2]
    if not _VERSION.fullmatch(version):
        raise VersionError(f"a version must be like 3.1.6, got '{version}'")
    if folder.is_dir():
        return folder
    _folders().mkdir(parents=True, exist_ok=True)
    # Beside it, and moved when complete: a folder that is there is whole.
    with tempfile.TemporaryDirectory(dir=_folders(), prefix=".new-") as made:
        target = Path(made, "site")
        command = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps"]
        command += ["--only-binary", ":all:", "--disable-pip-version-check"]
        command += ["--target", str(target), *requirements]
        try:
            done = subprocess.run(
                command, capture_output=True, text=True, timeout=_PATIENCE, check=False
            )
        except subprocess.TimeoutExpired:
            raise VersionError(f"{name}: pip did not finish within {_PATIENCE} s") from None
        if done.returncode:
            errors = [line for line in done.stderr.splitlines() if line.startswith("ERROR")]
            said = (errors or done.stderr.splitlines() or ["it said nothing"])[-1]
            raise VersionError(
                f"{name} is not installed, and pip cannot install {' '.join(requirements)}: "
                f"{said.removeprefix('ERROR: ')}"
            )
        try:
            target.replace(folder)
        except OSError:
            # Somebody else was faster.
            if not folder.is_dir():
                raise
    return folder


def remove(name: str) -> Path:
    """Remove an engine@version.

    Raises
    ------
    VersionError
        If it is not there.
    """
    for one in installed():
        if one.name == name:
            shutil.rmtree(one.folder)
            return one.folder
    there = ", ".join(one.name for one in installed()) or "none"
    raise VersionError(f"'{name}' is not installed; there: {there}")


def _folders() -> Path:
    return user_cache() / "engines"
