"""A model as its file states it: links with their mass, centre of mass and inertia."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from ..float_array import FloatArray

Format = Literal["urdf", "mjcf"]


@dataclass(frozen=True, eq=False)
class Pose:
    """The pose of a frame in another: `p = position + R @ p_inner`; m."""

    position: FloatArray
    R: FloatArray

    def then(self, inner: "Pose") -> "Pose":
        """The pose of a frame that is given in this one."""
        return Pose(self.position + self.R @ inner.position, self.R @ inner.R)


IDENTITY = Pose(np.zeros(3), np.eye(3))


@dataclass(frozen=True, eq=False)
class Stated:
    """What a file states of a link, in the link's frame; it need not be possible.

    Attributes
    ----------
    mass : kg
    com : centre of mass, m, (3,)
    inertia : about the com, kg m², (3, 3)
    unturned : the same if the rotation of its own frame (`rpy`, `quat`) were left out
    """

    mass: float
    com: FloatArray
    inertia: FloatArray
    unturned: FloatArray

    @property
    def is_physical(self) -> bool:
        """Whether it has a mass and a tensor at all."""
        return self.mass > 0 and bool(self.inertia.any())


@dataclass(frozen=True, eq=False)
class Shape:
    """A shape of a link: its bounding box in the link's frame, m, or a mesh.

    Attributes
    ----------
    low, high : corners of the box, (3,); None of a mesh
    span : bytes of the file that the element of the shape takes up
    mesh : the file it names, if it is a mesh
    collides : whether it is a collision shape
    """

    low: FloatArray | None
    high: FloatArray | None
    span: tuple[int, int]
    mesh: str | None
    collides: bool


@dataclass(frozen=True, eq=False)
class Link:
    """A link of a URDF, or a body of an MJCF file.

    Attributes
    ----------
    where : file and line
    stated : None if the file has no `inertial` for it
    parent : the link that it hangs on; empty for a root
    pose : of its frame in its parent's
    moves : whether a joint lets it move against its parent
    by_shapes : whether its inertia is that of its shapes, which is not computed here
    shapes : that it is drawn and collides with
    span : bytes of the file that its element takes up
    joint : likewise of the URDF joint that it hangs on
    """

    name: str
    where: str
    stated: Stated | None
    parent: str
    pose: Pose
    moves: bool
    shapes: tuple[Shape, ...] = ()
    span: tuple[int, int] = (0, 0)
    joint: tuple[int, int] = (0, 0)
    by_shapes: bool = False


@dataclass(frozen=True, eq=False)
class ModelFile:
    """A file as read.

    Attributes
    ----------
    data : its bytes
    folders : where it may have its meshes, by package; "" is its own folder
    links : in the file's order
    notes : what is odd about the file, and what of it was not read
    """

    path: Path
    data: bytes
    format: Format
    links: tuple[Link, ...]
    notes: tuple[str, ...]
    folders: "Folders"

    def link(self, name: str) -> Link:
        """The link of that name; KeyError if there is none."""
        return {link.name: link for link in self.links}[name]


@dataclass(frozen=True)
class Folders:
    """Where a model's meshes may be: its own folder, and those of packages.

    Attributes
    ----------
    own : of the file; absolute, as the others
    packages : folders by the name that `package://` gives them
    """

    own: Path
    packages: tuple[tuple[str, Path], ...] = ()

    def find(self, name: str) -> Path | None:
        """A file that a model names, if it is there and inside one of the folders."""
        wanted = self._place(name)
        try:
            resolved = None if wanted is None else wanted.resolve(strict=True)
        except (OSError, ValueError, RuntimeError):
            return None
        if resolved is None or not resolved.is_file():
            return None
        roots = [self.own, *(folder for _, folder in self.packages), *self._packages_above()]
        inside = any(resolved.is_relative_to(root.resolve()) for root in roots)
        return resolved if inside else None

    def _packages_above(self) -> list[Path]:
        """The packages that the file itself lies in, as ROS lays them out and installs them."""
        return [
            folder
            for folder in self.own.resolve().parents
            if (folder / "package.xml").is_file() or folder.parent.name == "share"
        ]

    def _place(self, name: str) -> Path | None:
        """The path that a name stands for; it need not exist, nor lie inside the folders."""
        scheme, separator, rest = name.partition("://")
        if not separator:
            return self.own / name
        if scheme not in ("package", "model"):
            return None
        package, _, inner = rest.partition("/")
        folder = dict(self.packages).get(package)
        if folder is not None:
            return folder / inner
        return next((f / inner for f in self._packages_above() if f.name == package), None)


def fused(parts: Iterable[tuple[Stated, Pose]]) -> Stated:
    """Rigidly joined parts as one body, in the frame that the poses are given in.

    Masses add, coms weigh by them, and tensors add about the common com by the parallel-axis
    theorem (Goldstein, Classical Mechanics, §5.3). What has no mass is nothing.
    """
    placed = [(part, pose) for part, pose in parts if part.mass]
    mass = sum(part.mass for part, _ in placed)
    coms = [pose.position + pose.R @ part.com for part, pose in placed]
    weighted = sum(
        (part.mass * com for (part, _), com in zip(placed, coms, strict=True)), _zeros(3)
    )
    com = weighted / mass if mass else _zeros(3)
    inertia, unturned = _zeros(3, 3), _zeros(3, 3)
    for (part, pose), its_com in zip(placed, coms, strict=True):
        arm = its_com - com
        moved = part.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
        inertia += pose.R @ part.inertia @ pose.R.T + moved
        unturned += pose.R @ part.unturned @ pose.R.T + moved
    # Turned tensors are symmetric but for rounding.
    return Stated(float(mass), com, (inertia + inertia.T) / 2, unturned)


def welded(links: Sequence[Link], host: str, gone: frozenset[str]) -> list[tuple[Link, Pose]]:
    """A link and those that are fused into it, with their poses in its frame.

    Parameters
    ----------
    gone : links that an engine has no body of its own for
    """
    children: dict[str, list[Link]] = {}
    for link in links:
        children.setdefault(link.parent, []).append(link)
    fused = [(link, IDENTITY) for link in links if link.name == host]
    for link, pose in fused:  # grows as it goes
        fused += [
            (child, pose.then(child.pose))
            for child in children.get(link.name, [])
            if child.name in gone
        ]
    return fused


def _zeros(*shape: int) -> FloatArray:
    return np.zeros(shape)
