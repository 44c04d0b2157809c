"""Links that no joint moves against each other, composed into one rigid body."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

from .model_file import Link, Pose, Stated, fused, welded

#: Name of a URDF link that engines take for the world itself: what is fixed to it is not its part.
WORLD = "world"


@dataclass(frozen=True, eq=False)
class RigidBody:
    """A link, and those welded to it: one body, in the frame of that link.

    Attributes
    ----------
    parts : the link itself and what is welded to it, with their poses in its frame
    """

    parts: tuple[tuple[Link, Pose], ...]

    @property
    def host(self) -> Link:
        """The link that the others are welded to."""
        return self.parts[0][0]

    @property
    def welded(self) -> tuple[str, ...]:
        """Names of the links welded to it that have an inertia of their own."""
        return tuple(link.name for link, _ in self.parts[1:] if link.stated is not None)

    @property
    def unread(self) -> str:
        """The parts whose inertia is that of their shapes, in words; empty if there are none."""
        names = [link.name for link, _ in self.parts if link.by_shapes]
        return f"the inertia of {', '.join(names)} is that of its shapes, not read" if names else ""

    @property
    def stated(self) -> Stated | None:
        """Mass, com and tensor of the whole; None if the file states none of any part."""
        stated = [(link.stated, pose) for link, pose in self.parts if link.stated is not None]
        if self.welded:
            return fused(stated)
        return stated[0][0] if stated else None

    def only(self, names: Collection[str]) -> "RigidBody":
        """The body of its host, those links, and the links that lie between them and the host."""
        parents = {link.name: link.parent for link, _ in self.parts[1:]}
        wanted = {self.host.name}
        for name in names:
            while name not in wanted:
                wanted.add(name)
                name = parents[name]
        return RigidBody(tuple(part for part in self.parts if part[0].name in wanted))


def rigid_bodies(links: Sequence[Link]) -> tuple[RigidBody, ...]:
    """The rigid bodies that a model's links make up, in the file's order."""
    fixed = frozenset(
        link.name for link in links if link.parent and not link.moves and link.parent != WORLD
    )
    return tuple(
        RigidBody(tuple(welded(links, link.name, fixed)))
        for link in links
        if link.name not in fixed
    )
