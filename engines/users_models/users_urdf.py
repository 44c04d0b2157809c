"""Prepares a user's URDF for an engine: verbatim, except for meshes and visual parts."""

import re
from collections.abc import Callable, Iterable
from pathlib import Path

from ...scenarios.users_models import Link, ModelFile, RigidBody, Shape

_FILENAME = re.compile(rb"""\bfilename\s*=\s*(?:"[^"]*"|'[^']*')""")


def with_meshes(model: ModelFile, usable: Callable[[Shape], bool]) -> tuple[bytes, dict[str, Path]]:
    """The file with its meshes renamed, so that an engine finds only those.

    Parameters
    ----------
    usable : whether the mesh of a collision shape is to be read

    Returns
    -------
    data : the file without visual parts, and without collision shapes whose mesh is missing, lies
        outside the model's folders, or is not to be read
    meshes : the mesh files, by their new names
    """
    edits, meshes = _edits(model, model.links, usable)
    return _edited(model.data, edits), meshes


def body_alone(
    model: ModelFile, body: RigidBody, usable: Callable[[Shape], bool] | None = None
) -> tuple[bytes, dict[str, Path]]:
    """A URDF of one body, its links and the joints between them cut verbatim out of a model.

    Parameters
    ----------
    usable : as in `with_meshes`; if None, the links have no shapes
    """
    links = [link for link, _ in body.parts]
    edits, meshes = _edits(model, links, usable) if usable else ([], {})
    if not usable:
        edits = [(shape.span, b"") for link in links for shape in link.shapes]
    spans = [link.span for link in links] + [link.joint for link in links[1:]]
    cut = []
    for start, end in spans:
        own = [((a - start, b - start), new) for (a, b), new in edits if start <= a < end]
        cut.append(_edited(model.data[start:end], own))
    return b"".join([b'<robot name="cut">', *cut, b"</robot>"]), meshes


def _edits(
    model: ModelFile, links: Iterable[Link], usable: Callable[[Shape], bool]
) -> tuple[list[tuple[tuple[int, int], bytes]], dict[str, Path]]:
    """Replacements, as spans of bytes and new contents, and the meshes by their new names."""
    edits: list[tuple[tuple[int, int], bytes]] = []
    meshes: dict[str, Path] = {}
    for link in links:
        for shape in link.shapes:
            path = None
            if shape.collides and shape.mesh is not None and usable(shape):
                path = model.folders.find(shape.mesh)
            if path is not None:
                name = f"mesh-{len(meshes)}{path.suffix.lower()}"
                meshes[name] = path
                start, end = shape.span
                named = f'filename="{name}"'.encode()
                edits.append((shape.span, _FILENAME.sub(named, model.data[start:end])))
            elif not shape.collides or shape.mesh is not None:
                edits.append((shape.span, b""))
    return edits, meshes


def _edited(data: bytes, edits: list[tuple[tuple[int, int], bytes]]) -> bytes:
    """Replace spans, which do not overlap."""
    parts, at = [], 0
    for (start, end), new in sorted(edits):
        parts += [data[at:start], new]
        at = end
    return b"".join([*parts, data[at:]])
