"""The command 'import': a model's links as scenes, and what was left out of it."""

from collections.abc import Sequence
from pathlib import Path

from ...scenarios import printable
from ...scenarios.model_files import ModelFileError, read_model
from ...scenarios.model_files.scenes import LinkScene, link_scenes
from .terminal import BAD_INPUT, Complaint


def import_scenes(file: Path, out: Path, links: Sequence[str]) -> list[str]:
    """Write the scenes; returns what was written, and what was left out and why, a line each.

    Parameters
    ----------
    links : only these; all if empty

    Raises
    ------
    Complaint
        If the file cannot be read, has no such link, none of its links makes a scene, or a scene
        is there already.
    """
    try:
        scenes = list(link_scenes(read_model(file), out.absolute()))
    except ModelFileError as error:
        raise Complaint(str(error), BAD_INPUT) from None
    there = {scene.link for scene in scenes}
    if unknown := [link for link in links if link not in there]:
        raise Complaint(f"{file}: there is no link '{unknown[0]}'", BAD_INPUT)
    wanted = [scene for scene in scenes if not links or scene.link in links]
    if not any(scene.text for scene in wanted):
        why = f"'{wanted[0].link}' is left out: {wanted[0].left_out}"
        raise Complaint(f"{file}: no link makes a scene; {why}", BAD_INPUT)
    try:
        out.mkdir(parents=True, exist_ok=True)
        return [printable(_line(scene, out)) for scene in wanted]
    except OSError as error:
        where = error.filename or out
        raise Complaint(f"{where}: cannot be written: {error.strerror}", BAD_INPUT) from None


def _line(scene: LinkScene, out: Path) -> str:
    if scene.left_out:
        return f"left out: {scene.link}: {scene.left_out}"
    path = out / f"{scene.name}.toml"
    with path.open("x", encoding="utf-8") as file:
        file.write(scene.text)
    return str(path)
