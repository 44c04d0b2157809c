"""Reads a model file of either format; every complaint is one message with file, line, element."""

import hashlib
from pathlib import Path

from ..errors import Misfit, printable
from ..scenario import Scenario
from .mjcf import read_mjcf
from .model_file import Folders, Link, ModelFile
from .urdf import urdf_links
from .xml_tree import Element, ModelFileError, read_bytes, read_xml, shown


def check_origin(scenario: Scenario) -> None:
    """Compare the file that `[body] model` names with the digest beside it.

    A scene without a file of its own has no folder that the name could be relative to.

    Raises
    ------
    Misfit
        If the file cannot be read, or is another one.
    """
    body = scenario.document.body
    if body.model is None or scenario.path is None:
        return
    try:
        sha256 = digest(scenario.path.parent / body.model)
    except ModelFileError as error:
        raise Misfit(str(error), "body", "model") from None
    if sha256 != body.sha256:
        raise Misfit(
            f"'{body.model}' has changed since this scene was made of it: its sha256 is {sha256}; "
            "import it again, or take 'model', 'link' and 'sha256' away",
            *("body", "sha256"),
        )


def digest(path: Path) -> str:
    """SHA-256 of a model file, hexadecimal.

    Raises
    ------
    ModelFileError
        If it cannot be read.
    """
    return hashlib.sha256(read_bytes(path)).hexdigest()


def read_model(path: str | Path, packages: tuple[tuple[str, Path], ...] = ()) -> ModelFile:
    """Read a URDF or an MJCF file.

    Parameters
    ----------
    packages : folders of its meshes by the name that `package://` gives them

    Raises
    ------
    ModelFileError
        If the file cannot be read, or engines would not read it alike.
    """
    path = Path(path)
    named = tuple((name, folder.absolute()) for name, folder in packages)
    folders = Folders(path.absolute().parent, named)
    file = read_xml(path)
    root = file.root
    if root.tag == "robot":
        _refuse_includes(root)
        links = urdf_links(root)
        notes = (*file.notes, *_scaled(root), *_missing_meshes(links, folders, path))
        return ModelFile(path, file.data, "urdf", links, notes, folders)
    if root.tag == "mujoco":
        links, notes = read_mjcf(root, folders)
        return ModelFile(path, file.data, "mjcf", links, (*file.notes, *notes), folders)
    if root.tag == "sdf":
        raise ModelFileError(f"{root.where}: SDF is not read; convert it to URDF or MJCF")
    raise ModelFileError(
        f"{root.where}: <{root.tag}> is neither URDF (<robot>) nor MJCF (<mujoco>)"
    )


def _refuse_includes(robot: Element) -> None:
    """MuJoCo follows them in a URDF too, wherever they point."""
    for element in robot.walk():
        if element.tag == "include":
            element.refuse("<include> has no place in a URDF; expand the file first")


def _scaled(robot: Element) -> list[str]:
    """Links whose tensor Bullet multiplies, by an element of its own."""
    return [
        f"{scaling.where}: Bullet multiplies the tensor of {link} by this <inertia_scaling>; no "
        "other engine does"
        for link in robot.all("link")
        for contact in link.all("contact")
        for scaling in contact.all("inertia_scaling")
    ]


def _missing_meshes(links: tuple[Link, ...], folders: Folders, path: Path) -> list[str]:
    named = {s.mesh for link in links for s in link.shapes if s.collides and s.mesh is not None}
    missing = sorted(name for name in named if folders.find(name) is None)
    if not missing:
        return []
    return [
        f"{printable(str(path))}: {len(missing)} of {len(named)} collision meshes are not inside "
        f"the model's folders, the first is {shown(missing[0])}; stated inertia needs none, what "
        "PyBullet makes up by default does; '--package-path NAME=DIR' says where they are"
    ]
