"""Writes a model file, and the files that it names, into a folder from which engines read it."""

from collections.abc import Collection, Iterable
from pathlib import Path

from .model_file import Link, ModelFile
from .urdf import mesh_bytes, with_meshes

#: File endings of the meshes that most importers read.
MESHES = frozenset((".obj", ".stl", ".dae"))


def laid_out(
    model: ModelFile,
    folder: Path,
    endings: Collection[str] = MESHES,
    links: Iterable[Link] | None = None,
) -> str:
    """Write a model into a folder, with the files from which engines may compute an inertia.

    Parameters
    ----------
    endings : file endings of those meshes of a URDF that the engine reads
    links : links of a URDF whose meshes are written; if None, those that state no inertia

    Returns
    -------
    The path of the model's file

    Raises
    ------
    EngineError
        If a mesh cannot be read or is too large.
    """
    path = folder / {"urdf": "model.urdf", "mjcf": "model.xml", "usd": "model.usda"}[model.format]
    data, files = model.checked.encode(), _named(model)
    if model.format == "urdf":
        if links is None:
            links = [link for link in model.links if link.stated is None]
        data, files = with_meshes(model, links, endings)
    for name, content in {**files, path.name: data}.items():
        (folder / name).write_bytes(content)
    return str(path)


def _named(model: ModelFile) -> dict[str, bytes]:
    """Return the contents of the files that `ModelFile.checked` names, by the names in that text.

    Meshes that are not in the model's folders are left out.
    """
    contents = {
        name: file.encode() if isinstance(file, str) else mesh_bytes(model, str(file))
        for name, file in model.files.items()
    }
    return {name: content for name, content in contents.items() if content is not None}
