"""Writes a model's file for importers that take paths, with the files that it may name."""

from pathlib import Path
from xml.etree import ElementTree

from .mjcf import unnamed
from .model_file import ModelFile, Shape
from .urdf import mesh_bytes, with_meshes

#: File endings of the meshes that trimesh reads, by which these importers read them.
MESHES = frozenset((".obj", ".stl", ".dae"))


def laid_out(model: ModelFile, folder: Path) -> str:
    """Write a model into a folder, with the meshes that an inertia may come from.

    Bodies of an MJCF without a name get one by their order, as in spincheck's own reader.

    Returns
    -------
    the path of the model's file
    """
    path = folder / {"urdf": "model.urdf", "mjcf": "model.xml", "usd": "model.usda"}[model.format]
    content = {"urdf": _urdf, "mjcf": _mjcf}.get(model.format)
    path.write_bytes(content(model, folder) if content else model.checked.encode())
    return str(path)


def _urdf(model: ModelFile, folder: Path) -> bytes:
    """Write meshes, and return the file with their new names."""
    stateless = {s.span for link in model.links if link.stated is None for s in link.shapes}

    def usable(shape: Shape) -> bool:
        return shape.span in stateless and Path(shape.mesh or "").suffix.lower() in MESHES

    data, meshes = with_meshes(model, usable)
    for name, mesh in meshes.items():
        (folder / name).write_bytes(mesh)
    return data


def _mjcf(model: ModelFile, folder: Path) -> bytes:
    """Write the files that the checked file names, and return it."""
    for name, file in model.files.items():
        data = file.encode() if isinstance(file, str) else mesh_bytes(model, str(file))
        if data is not None:
            (folder / name).write_bytes(data)
    root = ElementTree.fromstring(model.checked)
    nameless = [one for one in root.iter("body") if not one.get("name")]
    for number, one in enumerate(nameless, 1):
        one.set("name", unnamed(number))
    return ElementTree.tostring(root, encoding="unicode").encode()
