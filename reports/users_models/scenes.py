"""Makes scenes of a model's links, and says which links were left out.

In each scene one link tumbles, with the mass, com and tensor that the file states. Links that are
welded together are one body, and so they share one scene.
"""

import math
import os
from collections.abc import Iterator
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from ...engines.users_models import ModelFile, RigidBody, Stated, problems_of_parts, rigid_bodies
from ...scenarios import ScenarioError, loads
from ...scenarios.regular_files import file_name
from ...scenarios.write import to_toml

#: ω at the start, rad/s, along the principal axes in the order of ascending moments: about a turn a
#: second about the middle axis, which is unstable, and a twentieth of that about the others.
START = 2 * math.pi * np.array([0.05, 1.0, 0.05])
#: Duration of a scene, s, and its number of samples.
DURATION, SAMPLES = 3.0, 301


@dataclass(frozen=True)
class LinkScene:
    """A link's scene, or why it has none.

    Attributes
    ----------
    link : name of the link
    welded : names of the links that are welded to it, as parts of the same body, and for which the
        file states an inertia
    name : name of the scene: that of the link, in characters that file names may have
    text : text of the scene's file; empty if the link is left out
    left_out : why the link is left out; empty if it is not
    """

    link: str
    welded: tuple[str, ...]
    name: str
    text: str
    left_out: str


def link_scenes(model: ModelFile, folder: Path) -> Iterator[LinkScene]:
    """Yield a scene, or why there is none, for each link that is not welded to another.

    Parameters
    ----------
    folder : folder in which the scenes will be; the path of the model that they state is relative
        to it
    """
    taken: list[str] = []
    # The relative path may need `..`, which `Path.relative_to` writes only from Python 3.12 on;
    # after a symbolic link, that is the folder above the one to which the link leads.
    path = model.folders.own.resolve() / model.path.name
    file = Path(os.path.relpath(path, folder.resolve())).as_posix()
    for body in rigid_bodies(model.links):
        name, stated = file_name(body.host.name, taken), body.stated
        taken.append(name)
        left_out, text = _why_left_out(body, stated), ""
        if stated is not None and not left_out:
            text = to_toml(_tables(model, body, stated, file))
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
        for link, problem in problems_of_parts(body)
        if problem.impossible
    ]
    if impossible:
        return "; ".join(impossible)
    return body.unread or ("" if stated.is_physical else "it has no mass")


def _tables(model: ModelFile, body: RigidBody, stated: Stated, file: str) -> dict[str, Any]:
    link, welded = body.host, body.welded
    axes = np.linalg.eigh(stated.inertia_com)[1]
    kind = "link" if model.format == "urdf" else "body"
    others = f" with {', '.join(welded)}, welded to it" if welded else ""
    return {
        "spincheck": 1,
        "title": f"{link.name} of {model.path.name}: tumbles",
        "source": f"{model.path.name}, {kind} '{link.name}'{others}",
        "tags": ["free", "imported"],
        "body": {
            "mass": stated.mass,
            "inertia": stated.inertia_com.tolist(),
            "com": stated.com.tolist(),
            "model": file,
            "link": link.name,
            **({"welded": list(welded)} if welded else {}),
            "sha256": sha256(model.data).hexdigest(),
        },
        "start": {"rotation_vector_deg": [0.0, 0.0, 0.0], "omega_body": (axes @ START).tolist()},
        "window": {"duration": DURATION, "samples": SAMPLES},
    }
