"""Faults of a model file itself: tensors that no body can have, and placeholders."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..float_array import FloatArray
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


Kind = Literal[
    "negative mass",
    "zero mass",
    "zero tensor",
    "not positive definite",
    "triangle inequality",
    "placeholder",
    "radius of gyration",
    "density",
]
#: What no body can have; the other kinds are doubtful.
IMPOSSIBLE: frozenset[Kind] = frozenset(
    ("negative mass", "zero mass", "zero tensor", "not positive definite", "triangle inequality")
)
#: Relative rounding of the eigenvalues of a tensor, in ulp.
ROUNDING = 16 * float(np.finfo(float).eps)
#: A link's mass may lie outside the shapes that it is drawn with by so much of their size: shapes
#: are drawn for looks and for speed, and a doubtful tensor is rarely off by less.
SHAPE_SLACK = 1.1
#: kg/m³, of osmium, the densest element (CRC Handbook of Chemistry and Physics, 97th ed., §4).
DENSEST = 22590.0


@dataclass(frozen=True)
class FileProblem:
    """One thing that a file has wrong of a link; `text` says what, with its numbers."""

    kind: Kind
    text: str

    @property
    def impossible(self) -> bool:
        """Whether no body can have it, as against a doubtful number."""
        return self.kind in IMPOSSIBLE


def problems(link: Link) -> tuple[FileProblem, ...]:
    """The faults of a link's inertial, and what is doubtful about it."""
    stated = link.stated
    if stated is None:
        return ()
    reported = [*_of_mass(stated), *_of_tensor(stated)]
    if not reported and stated.is_physical:
        reported = [*_placeholder(stated), *_outside_its_shapes(link, stated)]
        reported += _dense(link, stated)
    return tuple(reported)


def principal_moments(inertia: FloatArray) -> FloatArray:
    """Ascending, kg m², (3,)."""
    if not (inertia - np.diag(np.diag(inertia))).any():
        return np.sort(np.diag(inertia))
    return np.asarray(np.linalg.eigvalsh(inertia))


def _of_mass(stated: Stated) -> list[FileProblem]:
    has_tensor = bool(stated.inertia.any())
    if stated.mass < 0:
        return [FileProblem("negative mass", f"a mass of {stated.mass:g} kg")]
    if stated.mass == 0 and has_tensor:
        return [FileProblem("zero mass", "a tensor without a mass")]
    if stated.mass > 0 and not has_tensor:
        return [FileProblem("zero tensor", f"a mass of {stated.mass:g} kg without a tensor")]
    return []


def _of_tensor(stated: Stated) -> list[FileProblem]:
    if not stated.inertia.any():
        return []
    small, middle, large = principal_moments(stated.inertia)
    rounding = ROUNDING * max(abs(small), abs(large))
    if small <= -rounding or middle <= rounding:
        moments = ", ".join(f"{moment:.4g}" for moment in (small, middle, large))
        rule = "principal moments must be positive"
        return [FileProblem("not positive definite", f"{rule}, they are {moments} kg m²")]
    if large - small - middle > rounding:
        details = f"{_digits(small, middle, large)}: no body has it"
        return [FileProblem("triangle inequality", details)]
    if small <= rounding:
        # A rod: the largest two are equal, and nothing says how fast it turns about itself.
        return [FileProblem("not positive definite", f"a principal moment is {small:.3g} kg m²")]
    return []


def _digits(small: float, middle: float, large: float) -> str:
    """The text "a + b < c", with as many digits as show the inequality."""
    for digits in range(2, 18):
        a, b, c = (float(f"{moment:.{digits}g}") for moment in (small, middle, large))
        if a + b < c:
            return f"{a:.{digits}g} + {b:.{digits}g} < {c:.{digits}g}"
    return f"{small!r} + {middle!r} < {large!r}"


def _placeholder(stated: Stated) -> list[FileProblem]:
    """A power of ten times the identity: a number that was put in to have one."""
    moment = float(stated.unturned[0, 0])
    exponent = round(np.log10(moment)) if moment > 0 else 0
    if moment == float(f"1e{exponent}") and (stated.unturned == moment * np.eye(3)).all():
        return [FileProblem("placeholder", f"{moment:g} × identity: a placeholder")]
    return []


def _outside_its_shapes(link: Link, stated: Stated) -> list[FileProblem]:
    """A tensor that a mass within the link's shapes cannot have, for any density.

    A mass within a width w varies along it by no more than (w/2)² (T. Popoviciu 1935); along x
    that is (Iyy + Izz − Ixx) / 2m.
    """
    extent = _extent(link)
    if extent is None:
        return []
    diagonal = np.diag(stated.inertia)
    # Of next to no mass it is infinite.
    with np.errstate(over="ignore"):
        spread = np.sqrt((diagonal.sum() / 2 - diagonal) / stated.mass)
    most = SHAPE_SLACK * extent / 2
    axis = int(np.argmax(spread / np.maximum(most, np.finfo(float).tiny)))
    if spread[axis] <= most[axis]:
        return []
    return [
        FileProblem(
            "radius of gyration",
            f"its radius of gyration along {'xyz'[axis]} is {spread[axis]:.3g} m; within its "
            f"shapes, {extent[axis]:.3g} m wide, at most {extent[axis] / 2:.3g} m are possible",
        )
    ]


def _dense(link: Link, stated: Stated) -> list[FileProblem]:
    """A mass that would be denser than any element if it filled the box about the link's shapes."""
    extent = _extent(link)
    if extent is None:
        return []
    # Of a flat shape, whose box has no volume, nothing is known.
    if not 0 < DENSEST * float(np.prod(SHAPE_SLACK * extent)) < stated.mass:
        return []
    sides = " × ".join(f"{side:.3g}" for side in extent)
    return [
        FileProblem(
            "density",
            f"{stated.mass:g} kg within shapes of {sides} m are denser than any element, osmium's "
            f"{DENSEST:.0f} kg/m³: is the mass in grams?",
        )
    ]


def _extent(link: Link) -> FloatArray | None:
    """Sides of the box about a link's shapes, m, along its axes; None where one is not known."""
    if not link.shapes or any(s.low is None or s.high is None for s in link.shapes):
        return None
    low = np.min([s.low for s in link.shapes if s.low is not None], axis=0)
    high = np.max([s.high for s in link.shapes if s.high is not None], axis=0)
    return np.asarray(high - low)
