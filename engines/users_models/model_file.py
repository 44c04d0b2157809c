"""The contents of a model file: links with the mass, com and tensor that the file states."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np

from ...scenarios import FloatArray
from ..checks.read_back import BodyReading, composed

Format = Literal["urdf", "mjcf", "usd"]
#: Span of an element in a file: indices of its first byte and of the byte after its last.
Span = tuple[int, int]
#: Name of a URDF link that engines take for the fixed world; links fixed to it are bodies of their
#: own.
WORLD = "world"


@dataclass(frozen=True, eq=False)
class Pose:
    """The pose of an inner frame in an outer frame.

    A point with coordinates p in the inner frame has `position + R @ p` in the outer frame.

    Attributes
    ----------
    position : origin of the inner frame in the outer frame, m, (3,)
    R : matrix that takes components along the inner frame's axes to the outer's, (3, 3)
    """

    position: FloatArray = field(default_factory=lambda: np.zeros(3))
    R: FloatArray = field(default_factory=lambda: np.eye(3))

    def then(self, inner: "Pose") -> "Pose":
        """Return the pose in the outer frame of a third frame.

        Parameters
        ----------
        inner : pose of the third frame in the inner frame of this pose
        """
        return Pose(self.position + self.R @ inner.position, self.R @ inner.R)


@dataclass(frozen=True, eq=False, kw_only=True)
class Stated(BodyReading):
    """Mass, com and tensor that a file states for a link; they may be physically impossible.

    Attributes
    ----------
    unturned : the tensor before it is turned by the rotation of the inertial frame (`rpy`, `quat`),
        kg m², (3, 3)
    """

    unturned: FloatArray

    @property
    def is_physical(self) -> bool:
        """Whether the mass is positive and the tensor not zero."""
        return self.mass > 0 and bool(self.inertia_com.any())


@dataclass(frozen=True, eq=False)
class Shape:
    """A shape of a URDF link.

    Attributes
    ----------
    box : lowest and highest corner of the box around the shape, in the link's frame, m, (2, 3);
        None for a mesh, and for an unknown kind of shape
    span : span of the shape's element in the file
    mesh : name of the mesh's file, as the model states it; None if the shape is no mesh
    collides : whether it is a collision shape; else it is only drawn
    """

    box: FloatArray | None
    span: Span
    mesh: str | None
    collides: bool

    @property
    def ending(self) -> str:
        """The file ending of the mesh, in small letters; empty if the shape is no mesh."""
        return Path(self.mesh or "").suffix.lower()


@dataclass(frozen=True, eq=False)
class Link:
    """A link of a URDF, or a body of an MJCF or a USD file.

    Attributes
    ----------
    where : name of the file, and the line at which the link begins, or its path in a USD file
    stated : mass, com and tensor that the file states; None if it does not state them
    parent : name of the link that this one is attached to; empty for a root
    pose : pose of the link's frame in the parent's frame
    moves : whether a joint lets the link move relative to its parent
    by_shapes : whether engines compute the link's inertia from its shapes, which is not done here
    makes_others : whether it has an element, such as `attach`, that makes bodies; these are not
        read, and may be welded to it
    shapes : shapes by which a URDF's link is drawn and collides
    span : span of the link's element in the model's own file; (0, 0) if it is in an included file,
        and for USD
    joint : span of the URDF joint that attaches the link to its parent; (0, 0) if there is none
    """

    name: str
    where: str
    stated: Stated | None
    parent: str
    pose: Pose
    moves: bool
    by_shapes: bool = False
    makes_others: bool = False
    shapes: tuple[Shape, ...] = ()
    span: Span = (0, 0)
    joint: Span = (0, 0)

    @property
    def has_inertia(self) -> bool:
        """Whether the file states a positive mass and a nonzero tensor for the link."""
        return self.stated is not None and self.stated.is_physical


@dataclass(frozen=True)
class Folders:
    """The folders in which a model's files may be: its own folder, and those of packages.

    Attributes
    ----------
    own : absolute path of the file's own folder
    packages : absolute paths of packages, by the name that `package://` gives them
    """

    own: Path
    packages: tuple[tuple[str, Path], ...] = ()

    def find(self, name: str) -> Path | None:
        """Return the path of a file that a model names; None if it is not inside the folders.

        The ROS packages that contain the model itself are also searched: folders above it that have
        a package.xml, or that are directly below a folder `share`.

        Parameters
        ----------
        name : path relative to the model's own folder, or a `package://` or `model://` URL
        """
        above = [
            folder
            for folder in self.own.resolve().parents
            if (folder / "package.xml").is_file() or folder.parent.name == "share"
        ]
        packages = {folder.name: folder for folder in reversed(above)} | dict(self.packages)
        scheme, separator, rest = name.partition("://")
        package, _, inner = rest.partition("/")
        if separator and (scheme not in ("package", "model") or package not in packages):
            return None
        try:
            path = packages[package] / inner if separator else self.own / name
            path = path.resolve(strict=True)
        except (OSError, ValueError, RuntimeError):
            return None
        roots = (self.own, *above, *packages.values())
        inside = any(path.is_relative_to(root.resolve()) for root in roots)
        return path if inside and path.is_file() else None


@dataclass(frozen=True, eq=False)
class ModelFile:
    """A model file that was read.

    Attributes
    ----------
    path : path of the file
    data : the bytes of the file
    format : the file's format
    links : the model's links, in the file's order
    notes : sentences on oddities of the file, and on what of it was not read
    folders : the folders in which the model's files may be
    checked : for an MJCF or a USD file, the text that engines are given, with included files
        inserted; else empty
    files : the files that the checked text names, by the names in this text; each is the text of an
        attached model, or the path of another file, such as a mesh
    """

    path: Path
    data: bytes
    format: Format
    links: tuple[Link, ...]
    notes: tuple[str, ...]
    folders: Folders
    checked: str = ""
    files: Mapping[str, str | Path] = field(default_factory=dict)

    def link(self, name: str) -> Link:
        """Return the link with a given name; raise KeyError if there is none."""
        return {link.name: link for link in self.links}[name]


@dataclass(frozen=True, eq=False)
class RigidBody:
    """A link, called the host, and the links welded to it: together they are one body.

    Attributes
    ----------
    parts : the host first, then the links welded to it, each with its pose in the host's frame
    """

    parts: tuple[tuple[Link, Pose], ...]

    @property
    def host(self) -> Link:
        """The link to which the others are welded, in whose frame the body is described."""
        return self.parts[0][0]

    @property
    def welded(self) -> tuple[str, ...]:
        """Names of the links welded to the host for which the file states an inertia."""
        return tuple(link.name for link, _ in self.parts[1:] if link.stated is not None)

    @property
    def unread(self) -> str:
        """A sentence on what of the body is not read; empty if all is.

        It is about links whose inertia is that of their shapes, which engines compute, and about
        bodies that elements such as `attach` make.
        """
        by_shapes = ", ".join(link.name for link, _ in self.parts if link.by_shapes)
        if by_shapes:
            return f"the inertia of {by_shapes} is that of its shapes, not read"
        makers = ", ".join(link.name for link, _ in self.parts if link.makes_others)
        return f"bodies made in {makers}, as by <attach>, are not read" if makers else ""

    @property
    def stated(self) -> Stated | None:
        """Mass, com and tensor of the whole body; None if the file states them for no link."""
        stated = [(link.stated, pose) for link, pose in self.parts if link.stated is not None]
        if self.welded:
            return fused(stated)
        return stated[0][0] if stated else None

    def only(self, names: Collection[str]) -> "RigidBody":
        """Return the body with fewer welded links.

        It keeps the host, the links with the given names, and the links between these and the host.
        """
        parents = {link.name: link.parent for link, _ in self.parts[1:]}
        wanted = {self.host.name}
        for name in names:
            while name not in wanted:
                wanted.add(name)
                name = parents[name]
        return RigidBody(tuple(part for part in self.parts if part[0].name in wanted))


def rigid_bodies(
    links: Sequence[Link], gone: Collection[str] | None = None
) -> tuple[RigidBody, ...]:
    """Return the rigid bodies that a model's links form, in the file's order.

    Parameters
    ----------
    links : the model's links
    gone : names of the links that are welded to the link that they are attached to. If None, these
        are the links that no joint moves, except roots and links attached to `WORLD`
    """
    if gone is None:
        gone = {li.name for li in links if li.parent and not li.moves and li.parent != WORLD}
    children: dict[str, list[Link]] = {}
    for link in links:
        children.setdefault(link.parent, []).append(link)
    bodies = []
    for host in (link for link in links if link.name not in gone):
        parts = [(host, Pose())]
        for link, pose in parts:  # the list grows during the loop
            fixed = [child for child in children.get(link.name, []) if child.name in gone]
            parts += [(child, pose.then(child.pose)) for child in fixed]
        bodies.append(RigidBody(tuple(parts)))
    return tuple(bodies)


def fused(parts: Iterable[tuple[Stated, Pose]]) -> Stated:
    """Return the one body that rigidly joined parts form.

    Parts without mass are ignored.

    Parameters
    ----------
    parts : mass, com and tensor of each part in its own frame; and the pose of this frame in the
        frame in which the body is returned
    """
    placed = [(part, pose) for part, pose in parts if part.mass]

    def whole(tensors: Iterable[FloatArray]) -> BodyReading:
        return composed(
            [
                BodyReading(part.mass, part.com, tensor).placed(pose.position, pose.R)
                for (part, pose), tensor in zip(placed, tensors, strict=True)
            ]
        )

    body = whole(part.inertia_com for part, _ in placed)
    # A turned tensor is symmetric only up to rounding.
    inertia = (body.inertia_com + body.inertia_com.T) / 2
    unturned = whole(part.unturned for part, _ in placed).inertia_com
    return Stated(float(body.mass), body.com, inertia, unturned=unturned)


def principal_moments(inertia: FloatArray) -> FloatArray:
    """Return the principal moments, ascending, kg m², (3,), of a tensor, (3, 3)."""
    if not (inertia - np.diag(np.diag(inertia))).any():
        return np.sort(np.diag(inertia))
    return np.asarray(np.linalg.eigvalsh(inertia))
