"""Reads a model file of any format, and finds the link of such a file that a scene names."""

from dataclasses import dataclass
from functools import lru_cache
from hashlib import sha256
from pathlib import Path

from ...scenarios import Scenario, printable
from ..checks.read_back import EngineError, UnsupportedError
from .mjcf import CHANGING_URDF, changing_options, read_mjcf
from .mjcf_files import CheckedFiles
from .model_file import Folders, Link, ModelFile, Pose, RigidBody, Stated, rigid_bodies
from .urdf import urdf_links
from .usd import ENDINGS, usd_links
from .xml_tree import Element, ModelFileError, read_bytes, read_xml, shown

#: Number of models that are kept, as all runs of a ladder need the same one.
KEPT = 16


def read_model(path: str | Path, packages: tuple[tuple[str, Path], ...] = ()) -> ModelFile:
    """Read a URDF, an MJCF or, where OpenUSD is installed, a USD file.

    Parameters
    ----------
    packages : names of packages, as `package://` URLs have them, and the folders of these packages,
        in which meshes are looked for

    Raises
    ------
    ModelFileError
        If the file cannot be read, or engines would read different values from it.
    """
    path = Path(path)
    named = tuple((name, folder.absolute()) for name, folder in packages)
    folders = Folders(path.absolute().parent, named)
    if path.suffix.lower() in ENDINGS:
        data = read_bytes(path)
        bodies, unread = usd_links(path, data)
        return ModelFile(path, data, "usd", bodies, unread, folders, data.decode(errors="replace"))
    data, root, notes = read_xml(path)
    if root.tag == "robot":
        for element in root.walk():
            if element.tag == "include":
                # MuJoCo follows includes in a URDF too, wherever they point.
                element.refuse("<include> has no place in a URDF; expand the file first")
        links = urdf_links(root)
        notes += _scaled(root) + _missing_meshes(links, folders, path)
        for inner in root.all("mujoco"):
            notes += changing_options(inner, CHANGING_URDF)
        return ModelFile(path, data, "urdf", links, tuple(notes), folders)
    if root.tag == "sdf":
        root.refuse("SDF is not read; convert it to URDF or MJCF")
    if root.tag != "mujoco":
        root.refuse(f"<{root.tag}> is neither URDF (<robot>) nor MJCF (<mujoco>)")
    files = CheckedFiles(folders)
    links, unread = read_mjcf(root, files)
    notes += unread
    return ModelFile(path, data, "mjcf", links, tuple(notes), folders, root.text(), files.files)


def _scaled(robot: Element) -> list[str]:
    """Return a note for each `<inertia_scaling>`, which scales a link's tensor only in Bullet."""
    return [
        f"{scaling.where}: Bullet multiplies the tensor of {link} by this <inertia_scaling>; no "
        "other engine does"
        for link in robot.all("link")
        for contact in link.all("contact")
        for scaling in contact.all("inertia_scaling")
    ]


def _missing_meshes(links: tuple[Link, ...], folders: Folders, path: Path) -> list[str]:
    """Return a list with a note if the model's folders lack collision meshes; else an empty list.

    Parameters
    ----------
    path : path of the model's file, for the note
    """
    named = {s.mesh for link in links for s in link.shapes if s.collides and s.mesh is not None}
    missing = sorted(name for name in named if folders.find(name) is None)
    if not missing:
        return []
    return [
        f"{printable(str(path))}: {len(missing)} of {len(named)} collision meshes are not inside "
        f"the model's folders, the first is {shown(missing[0])}; stated inertia needs none, what "
        "PyBullet makes up by default does; '--package-path NAME=DIR' says where they are"
    ]


@dataclass(frozen=True, eq=False)
class UsersLink:
    """The link of a model file that a scene names, with the links welded to it.

    Attributes
    ----------
    model : the file
    body : the link, and those of the links welded to it that the scene names
    stated : mass, com and tensor that the file states for the whole body
    """

    model: ModelFile
    body: RigidBody
    stated: Stated


def users_link(scenario: Scenario) -> UsersLink:
    """Read the model file that a scene names; return the link, and links welded to it, from there.

    Raises
    ------
    UnsupportedError
        If the scene names no link, or has no file to which the model's path would be relative.
    EngineError
        If the model file cannot be read, is not the one from which the scene was made, has no such
        link, states no inertia for it, or does not weld to it all links that the scene names as
        welded.
    """
    origin = scenario.document.body
    file, link, welded = origin.model, origin.link, origin.welded or ()
    if file is None or link is None or origin.sha256 is None or scenario.path is None:
        raise UnsupportedError("the scene names no link of a model file", "effects")
    try:
        model = _read(scenario.path.absolute().parent / file, origin.sha256)
    except ModelFileError as error:
        raise EngineError(str(error), "refused") from None
    if sha256(model.data).hexdigest() != origin.sha256:
        raise EngineError(f"'{file}' has changed since the scene was made of it", "refused")
    if link not in {one.name for one in model.links}:
        raise EngineError(f"'{file}' has no link '{link}'", "refused")
    hosted = [body for body in rigid_bodies(model.links) if body.host.name == link]
    whole = hosted[0] if hosted else RigidBody(((model.link(link), Pose()),))
    if unknown := sorted({*welded} - {*whole.welded}):
        raise EngineError(
            f"in '{file}' no link '{unknown[0]}' with an inertia is welded to '{link}'", "refused"
        )
    body = whole.only(welded)
    if body.stated is None:
        raise EngineError(f"'{file}' states no inertia of '{link}'", "refused")
    return UsersLink(model, body, body.stated)


@lru_cache(maxsize=KEPT)
def _read(path: Path, digest: str) -> ModelFile:  # noqa: ARG001
    """Return the model in a file; the last `KEPT` models are kept, by path and digest.

    The digest is not checked here. It is a parameter so that a file is read again if the scene
    names another digest.
    """
    return read_model(path)
