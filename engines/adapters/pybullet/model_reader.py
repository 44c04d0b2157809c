"""Reads a user's URDF with PyBullet."""

import re
import tempfile
from pathlib import Path
from typing import final

import numpy as np
import pybullet as p
from scipy.spatial.transform import Rotation
from spincheck.engine import BodyReading, EngineError

from ...native_output import native_output
from ...users_models import Advice, Configuration, ModelFile, ModelReader, laid_out
from .engine import installed_version
from .world import BASE

UNSTATED = {"nothing stated": Advice("PyBullet then fixes a root in the world")}
#: Names of the two ways to load a URDF.
DEFAULT, FROM_FILE = "default", "inertia-from-file"
#: Pattern of the beginning of PyBullet's messages, which has file and line of its source.
_HEAD = re.compile(r"b3(?:Warning|Error|Printf)\[[^\]]*\]:\n?")
#: Index of the link's name, as bytes, in the tuple that `getJointInfo` returns.
LINK_NAME = 12


@final
class PyBulletModelReader(ModelReader):
    """A reader of URDF by `loadURDF`, with or without the flag that makes it use stated tensors."""

    name = "pybullet"
    formats = frozenset({"urdf"})
    configurations = (
        Configuration(
            DEFAULT,
            "loadURDF without a flag",
            "made up from the collision shapes",
            UNSTATED
            | {"made up": Advice("load it with flags=pybullet.URDF_USE_INERTIA_FROM_FILE")},
        ),
        Configuration(FROM_FILE, "loadURDF with URDF_USE_INERTIA_FROM_FILE", advice=UNSTATED),
    )

    @property
    def version(self) -> str:
        """The version of the installed package; the module reports only that of its API."""
        return installed_version()

    def read(self, model: ModelFile, configuration: str) -> dict[str, BodyReading]:
        """Load a file; return its bodies, by the names of their links.

        `configuration` is the name of one of the reader's `configurations`. Shapes are loaded only
        in `DEFAULT`, in which PyBullet computes tensors from them.
        """
        asks_shapes = configuration == DEFAULT
        flags = p.URDF_IGNORE_VISUAL_SHAPES
        if not asks_shapes:
            flags |= p.URDF_USE_INERTIA_FROM_FILE | p.URDF_IGNORE_COLLISION_SHAPES
        client = p.connect(p.DIRECT)
        try:
            with tempfile.TemporaryDirectory() as folder, native_output() as printed:
                links = model.links if asks_shapes else ()
                body = _load(client, laid_out(model, Path(folder), links=links), flags)
            if body is None:
                raise EngineError(f"PyBullet refuses the file: {_last_line(printed.text)}")
            return _bodies(client, body)
        finally:
            p.disconnect(client)


def _load(client: int, file: str, flags: int) -> int | None:
    """Load a file; return PyBullet's number of the body, or None if PyBullet refuses the file.

    `client` is PyBullet's number of the world; `flags` are those of `loadURDF`.
    """
    try:
        return int(p.loadURDF(file, flags=flags, physicsClientId=client))
    except p.error:
        return None


def _bodies(client: int, body: int) -> dict[str, BodyReading]:
    """Return the links of a loaded body, each as a body in its own axes, by their names."""
    bodies = {}
    for link in range(BASE, p.getNumJoints(body, client)):
        if link == BASE:
            name = p.getBodyInfo(body, client)[0]
        else:
            name = p.getJointInfo(body, link, client)[LINK_NAME]
        mass, _, moments, com, q_body_principal_xyzw, *_ = p.getDynamicsInfo(body, link, client)
        R = Rotation.from_quat(q_body_principal_xyzw).as_matrix()
        reading = BodyReading(mass, np.array(com), R @ np.diag(moments) @ R.T)
        bodies[name.decode(errors="replace")] = reading
    return bodies


def _last_line(printed: str) -> str:
    """Return the last line that PyBullet printed, without file and line of its source.

    If it printed nothing, the words "it does not say why" are returned.
    """
    lines = [line.strip() for line in _HEAD.sub("", printed).splitlines() if line.strip()]
    return lines[-1] if lines else "it does not say why"
