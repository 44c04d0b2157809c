"""Wheel and source distribution hold what is needed, and install in an empty environment."""

import os
import subprocess
import sys
import tomllib
import venv
from pathlib import Path
from zipfile import ZipFile

import pytest

ROOT = Path(__file__).parents[1]
#: Folders that packages are of, and what else their building reads.
SOURCES = ("engines", "reference", "reports", "scenarios")
FILES = ("pyproject.toml", "setup.py", "README.md", "LICENSE")
BUILD = "import setuptools.build_meta as b, sys; print(getattr(b, sys.argv[1])(sys.argv[2]))"

pytestmark = [pytest.mark.slow, pytest.mark.processes]


def run(*words: object, cwd: Path, **environment: str) -> str:
    """What a command prints; it has to end well."""
    done = subprocess.run(
        [str(word) for word in words],
        cwd=cwd,
        env=os.environ | environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-3000:]
    return done.stdout


@pytest.fixture(scope="module")
def python(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The interpreter of a new environment; this one's pip installs into it."""
    folder = tmp_path_factory.mktemp("environment")
    venv.create(folder)
    return folder / "bin/python"


def install(python: Path, *words: object) -> list[str]:
    """The command that installs into an environment."""
    return [*map(str, (sys.executable, "-m", "pip", "--python", python, "install", "-q", *words))]


@pytest.fixture(scope="module")
def checkout(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the files that git knows, without what was built beside them."""
    folder = tmp_path_factory.mktemp("checkout")
    listed = run("git", "ls-files", *SOURCES, *FILES, cwd=ROOT).splitlines()
    for name in listed:
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes((ROOT / name).read_bytes())
    return folder


@pytest.fixture(scope="module")
def wheel(checkout: Path, python: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A wheel, built from the source distribution, as installers do where there is no wheel."""
    folder = tmp_path_factory.mktemp("dist")
    needed = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["build-system"]["requires"]
    if subprocess.run(install(python, *needed), capture_output=True).returncode:
        pytest.skip(f"{needed} could not be downloaded")
    archive = run(python, "-c", BUILD, "build_sdist", folder, cwd=checkout).split()[-1]
    run("tar", "-xf", folder / archive, cwd=folder)
    unpacked = folder / archive.removesuffix(".tar.gz")
    return folder / run(python, "-c", BUILD, "build_wheel", folder, cwd=unpacked).split()[-1]


def test_the_wheel_holds_every_file_that_the_program_reads(wheel: Path, checkout: Path) -> None:
    held = set(ZipFile(wheel).namelist())
    interface = "reports/interface/"
    for top in SOURCES:
        for path in (checkout / top).rglob("*.*"):
            name = path.relative_to(checkout).as_posix()
            inside = name.removeprefix(interface) if name.startswith(interface) else name
            assert f"spincheck/{inside}" in held, name


def test_it_runs_in_an_environment_that_holds_its_dependencies_alone(
    wheel: Path, python: Path, tmp_path: Path
) -> None:
    """Packages are not downloaded: those of this environment are lent, without spincheck."""
    run(*install(python, "--no-deps", wheel), cwd=tmp_path)
    lent = os.pathsep.join(path for path in sys.path if path.endswith("site-packages"))
    inside = {"PYTHONPATH": lent, "XDG_CACHE_HOME": str(tmp_path)}
    where = run(
        python, "-c", "import spincheck.scenarios as s; print(s.__file__)", cwd=tmp_path, **inside
    )
    assert where.startswith(str(python.parents[1]))
    spincheck = python.with_name("spincheck")
    assert "fast-top" in run(spincheck, "list", cwd=tmp_path, **inside)
    printed = run(spincheck, "show", "fast-top", cwd=tmp_path, **inside)
    assert "gravity" in printed
