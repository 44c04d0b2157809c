"""The command 'import': scenes of a model's links, welded ones as one, and what was left out."""

from collections.abc import Iterator, Sequence
from pathlib import Path

from ....scenarios import printable
from ....scenarios.regular_files import write_new
from ....scenarios.users_models import ModelFileError, read_model
from ...harness.users_models import listed
from ..refusals import written
from ..terminal import BAD_INPUT, Complaint, as_complaint
from .link_scenes import LinkScene, link_scenes


def import_scenes(file: Path, out: Path, links: Sequence[str]) -> list[str]:
    """Write the scenes; returns one line for each, and one for each reason why links were left out.

    Parameters
    ----------
    links : only these; all if empty

    Raises
    ------
    Complaint
        If the file cannot be read or has no such link, if no link makes a scene, or if a scene's
        file exists already.
    """
    with as_complaint(ModelFileError):
        model = read_model(file)
        scenes = list(link_scenes(model, out.absolute()))
    there = {link.name for link in model.links}
    if unknown := [link for link in links if link not in there]:
        raise Complaint(f"{file}: there is no link '{unknown[0]}'", BAD_INPUT)
    wanted = [s for s in scenes if not links or {s.link, *s.welded}.intersection(links)]
    if not any(scene.text for scene in wanted):
        why = f"'{links[0]}' is welded to another and has no inertia of its own" if links else ""
        if wanted:
            why = f"'{wanted[0].link}' is left out: {wanted[0].left_out}"
        raise Complaint(f"{file}: no link makes a scene; {why}", BAD_INPUT)
    paths = {out / f"{scene.name}.toml": scene for scene in wanted if scene.text}
    if there_already := [path for path in paths if path.exists()]:
        raise Complaint(
            f"{there_already[0]}: a scene of that name exists already; remove it, "
            "or give another '--out'",
            BAD_INPUT,
        )
    with written(out):
        out.mkdir(parents=True, exist_ok=True)
        for path, scene in paths.items():
            write_new(path, scene.text, replace=False)
    said = (*(_path_line(path, scene) for path, scene in paths.items()), *_left_out(wanted))
    return [printable(line) for line in said]


def _path_line(path: Path, scene: LinkScene) -> str:
    others = listed(scene.welded)
    return f"{path}: {scene.link} with {others}, welded to it: one body" if others else str(path)


def _left_out(scenes: Sequence[LinkScene]) -> Iterator[str]:
    """One line for each reason, with the links it applies to."""
    by_reason: dict[str, list[str]] = {}
    for scene in scenes:
        if scene.left_out:
            by_reason.setdefault(scene.left_out, []).append(scene.link)
    for reason, links in by_reason.items():
        yield f"left out, {reason}: {', '.join(links)}"
