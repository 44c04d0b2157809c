"""The command 'import': scenes of a model's links, and what was left out.

Each tumbles on its own, with the numbers that its file states; links that are welded together are
one body and make one scene.
"""

import math
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ....scenarios import ScenarioError, loads, printable
from ....scenarios.regular_files import file_name, write_new
from ....scenarios.users_models import (
    ModelFile,
    ModelFileError,
    RigidBody,
    Stated,
    digest,
    problems,
    read_model,
    rigid_bodies,
)
from ....scenarios.write import to_toml
from ...harness.users_models.findings import listed
from ..terminal import Complaint, as_complaint, written

#: rad/s along the principal axes, ascending moments: a turn a second about the middle axis, which
#: no body keeps, and a little about the others.
START = 2 * math.pi * np.array([0.05, 1.0, 0.05])
#: s, and looks at it.
DURATION, SAMPLES = 3.0, 301


@dataclass(frozen=True)
class LinkScene:
    """A link's scene, or why it has none.

    Attributes
    ----------
    link : that others may be welded to
    welded : the links with an inertia that are welded to it: parts of the same body
    name : of the scene: the link's, in characters that files may have
    text : of the file; empty if the link is left out
    left_out : why; empty if it is not
    """

    link: str
    welded: tuple[str, ...]
    name: str
    text: str
    left_out: str


def link_scenes(model: ModelFile, folder: Path) -> Iterator[LinkScene]:
    """A scene of every link, with those welded to it, whose inertia a body can have.

    Parameters
    ----------
    folder : that the scenes will be in: they name the model relative to it
    """
    taken: list[str] = []
    sha256 = digest(model.path)
    file = _relative(model.folders.own / model.path.name, folder)
    for body in rigid_bodies(model.links):
        name, stated = file_name(body.host.name, taken), body.stated
        taken.append(name)
        left_out, text = _why_left_out(body, stated), ""
        if stated is not None and not left_out:
            text = to_toml(_tables(model, body, stated, file, sha256))
            try:
                loads(text, name)
            except ScenarioError as error:
                left_out, text = str(error), ""
        yield LinkScene(body.host.name, body.welded, name, text, left_out)


def _why_left_out(body: RigidBody, stated: Stated | None) -> str:
    if stated is None:
        return "the file states no inertia of it"
    impossible = [
        f"{problem.text}{'' if link is body.host else f' (of {link.name}, welded to it)'}"
        for link, _ in body.parts
        for problem in problems(link)
        if problem.impossible
    ]
    if impossible:
        return "; ".join(impossible)
    return body.unread or ("" if stated.is_physical else "it has no mass")


def _tables(
    model: ModelFile, body: RigidBody, stated: Stated, file: str, sha256: str
) -> dict[str, Any]:
    link, welded = body.host, body.welded
    axes = np.linalg.eigh(stated.inertia)[1]
    kind = "link" if model.format == "urdf" else "body"
    others = f" with {', '.join(welded)}, welded to it" if welded else ""
    return {
        "spincheck": 1,
        "title": f"{link.name} of {model.path.name}: tumbles",
        "source": f"{model.path.name}, {kind} '{link.name}'{others}",
        "tags": ["free", "imported"],
        "body": {
            "mass": stated.mass,
            "inertia": stated.inertia.tolist(),
            "com": stated.com.tolist(),
            "model": file,
            "link": link.name,
            **({"welded": list(welded)} if welded else {}),
            "sha256": sha256,
        },
        "start": {"rotation_vector_deg": [0.0, 0.0, 0.0], "omega_body": (axes @ START).tolist()},
        "window": {"duration": DURATION, "samples": SAMPLES},
    }


def _relative(path: Path, folder: Path) -> str:
    """The path with `..` where needed; `Path.relative_to` does that from Python 3.12 on only."""
    return Path(os.path.relpath(path, folder)).as_posix()


def import_scenes(file: Path, out: Path, links: Sequence[str]) -> list[str]:
    """Write the scenes; returns one line for each, and one for each reason why links were left out.

    Parameters
    ----------
    links : only these; all if empty
    """
    with as_complaint(ModelFileError):
        model = read_model(file)
        scenes = list(link_scenes(model, out.absolute()))
    there = {link.name for link in model.links}
    if unknown := [link for link in links if link not in there]:
        raise Complaint(f"{file}: there is no link '{unknown[0]}'")
    wanted = [s for s in scenes if not links or {s.link, *s.welded}.intersection(links)]
    if not any(scene.text for scene in wanted):
        why = f"'{links[0]}' is welded to another and has no inertia of its own" if links else ""
        if wanted:
            why = f"'{wanted[0].link}' is left out: {wanted[0].left_out}"
        raise Complaint(f"{file}: no link makes a scene; {why}")
    paths = {out / f"{scene.name}.toml": scene for scene in wanted if scene.text}
    if there_already := [path for path in paths if path.exists()]:
        raise Complaint(
            f"{there_already[0]}: a scene of that name exists already; remove it, "
            "or give another '--out'"
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
        yield f"left out: {', '.join(links)}: {reason}"
