"""Finds scenario files: by path, by folder, or by name in the library that comes with spincheck."""

import os
from collections.abc import Iterable, Iterator
from functools import cache
from importlib.resources import files
from pathlib import Path

from .errors import ScenarioError, did_you_mean, printable
from .load import is_scenario, is_scene_name

#: File endings of models, which users give by mistake in place of a scene.
MODELS = (".urdf", ".xml", ".mjcf", ".xacro")
LIBRARY = Path(str(files(__package__))) / "library"
#: Most files and folders looked at below a folder: a whole disk holds more, and takes minutes.
MOST_ENTRIES = 50_000


def scenario_files(folder: Path) -> list[Path]:
    """Return the paths of all scenario files in a folder and its folders, sorted.

    Other TOML files are ignored. Links to folders are not followed, and hidden folders are not
    entered.

    Raises
    ------
    ScenarioError
        If there are more than `MOST_ENTRIES` files and folders, or if two scenario files have the
        same stem, which is the scene's name.
    """
    paths = [path for path in sorted(_toml_files(folder)) if is_scenario(path)]
    _check_unique(paths)
    return paths


def hiding_the_library(names: Iterable[str]) -> list[str]:
    """Return a warning for each path in the current folder that hides a part of the library.

    A path does so if one of `names` stands for it, and the library has a scene or a folder of this
    name. `names` are those that a user types for scenes and folders of scenes.
    """
    there = {path: name for name in names for path in _of_current_folder(name)}
    known = {one for path in _library() for one in (path.stem, path.parent.name)} if there else ()
    return [
        f"{printable(str(path))}: taken from the current folder; the library has one of that name, "
        "too."
        for path, name in there.items()
        if name in known
    ]


def find(names: Iterable[str]) -> list[Path]:
    """Return the paths of the scenario files that a user names.

    A name may be that of a file, a folder, a scene of the library or a folder of the library. A
    file of the current folder may be named without its ending. Without names, the whole library is
    returned.

    Raises
    ------
    ScenarioError
        If a name is none of these or cannot be read, a folder holds no scenario or too many files,
        or two files have the same name.
    """
    names = list(names)
    paths = [path for name in names for path in _find_one(name)] if names else _library()
    unique = list(dict.fromkeys(paths))
    _check_unique(unique)
    return unique


def _toml_files(folder: Path) -> Iterator[Path]:
    """Yield the paths of the TOML files in a folder and its folders, in any order.

    Hidden folders are not entered, and links to folders are not followed.

    Raises
    ------
    ScenarioError
        If there are more than `MOST_ENTRIES` files and folders.
    """
    count = 0
    for path, folders, files_there in os.walk(folder):
        count += len(folders) + len(files_there)
        if count > MOST_ENTRIES:
            raise ScenarioError(
                f"{printable(str(folder))}: holds more than {MOST_ENTRIES} files and folders; "
                "name the folder in it that has your scenes"
            )
        folders[:] = [name for name in folders if not name.startswith(".")]
        yield from (Path(path, name) for name in files_there if name.endswith(".toml"))


@cache
def _library() -> list[Path]:
    """Return the paths of the scenario files of the library, sorted."""
    return scenario_files(LIBRARY)


def _of_current_folder(name: str) -> Iterator[Path]:
    """Yield the paths in the current folder, outside the library, that a name stands for.

    A name that ends in `.toml` stands for none of them, as it cannot be that of a library's scene.
    """
    if name.endswith(".toml"):
        return
    for path in (Path(name), Path(f"{name}.toml")):
        if path.exists() and not path.resolve().is_relative_to(LIBRARY.resolve()):
            yield path


def _find_one(name: str) -> list[Path]:
    """Return the paths of the scenario files that one name stands for.

    `ScenarioError` is raised if the name is not that of a file, a folder or a scene of the library,
    if it cannot be read, or if a folder of this name holds no scenario or too many files.
    """
    if not name:
        raise ScenarioError("a scene's name is empty; '.' is the folder you are in")
    path, file = Path(name), Path(f"{name}.toml")
    if path.suffix.lower() in MODELS:
        raise ScenarioError(
            f"{printable(name)}: a model, not a scene; 'spincheck inspect' says what engines hold "
            "of it, 'spincheck import' makes scenes of its links"
        )
    try:
        if path.exists() and not path.is_dir():
            return [path]
        # Pages and messages name a scene by the stem of its file.
        if is_scene_name(name) and file.is_file():
            return [file]
    except OSError as error:  # such as a name that is too long
        raise ScenarioError(f"{printable(name)}: cannot be read: {error.strerror}") from None
    folder = path if path.is_dir() or not name.isidentifier() else LIBRARY / name
    if folder.is_dir():
        paths = scenario_files(folder)
        if not paths:
            raise ScenarioError(f"{printable(name)}: no scenario in this folder")
        return paths
    matches = [path for path in _library() if path.stem == name]
    if not matches:
        raise ScenarioError(
            f"{printable(name)}: neither a file, a folder, nor a scene of the library; "
            f"'spincheck list' shows the library{did_you_mean(name, (p.stem for p in _library()))}"
        )
    return matches


def _check_unique(paths: Iterable[Path]) -> None:
    """Raise `ScenarioError` if two files have the same stem."""
    first: dict[str, Path] = {}
    for path in paths:
        if path.stem in first:
            raise ScenarioError(
                f"{printable(str(path))}: another scene has the same name, "
                f"{printable(str(first[path.stem]))}; rename one"
            )
        first[path.stem] = path
