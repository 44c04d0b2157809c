"""Finds faults in the numbers of a model file: those that no body can have, and doubtful ones."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ...scenarios import FloatArray
from .model_file import Link, RigidBody, Stated, principal_moments

#: Kinds of faults that no body can have. Of the other kinds, "placeholder", "radius of gyration"
#: and "density", numbers are only doubtful.
IMPOSSIBLE = frozenset(
    ("negative mass", "zero mass", "zero tensor", "not positive definite", "triangle inequality")
)
#: Relative rounding error of the eigenvalues of a tensor.
ROUNDING = 16 * float(np.finfo(float).eps)
#: Factor by which shapes are enlarged before a link's mass must fit into them: shapes are made for
#: looks and for speed, so that some mass may lie outside. Doubtful tensors are mostly off by more.
SHAPE_SLACK = 1.1
#: Density of osmium, the densest element, kg/m³ (CRC Handbook of Chemistry and Physics, 97th ed.,
#: §4).
DENSEST = 22590.0


@dataclass(frozen=True, eq=False)
class FileProblem:
    """One fault of the numbers that a file states for a link.

    Attributes
    ----------
    kind : the kind of fault, in a few words
    text : the fault with its numbers, in words
    """

    kind: str
    text: str

    @property
    def impossible(self) -> bool:
        """Whether no body can have the numbers; otherwise they are only doubtful."""
        return self.kind in IMPOSSIBLE


def problems(link: Link) -> tuple[FileProblem, ...]:
    """Return the faults of the mass and tensor that a file states for a link.

    Doubtful numbers are looked for only if none are impossible.
    """
    stated = link.stated
    if stated is None:
        return ()
    found = [*_of_mass(stated), *_of_tensor(stated)]
    if not found and link.has_inertia:
        found = [*_placeholder(stated), *_beside_its_shapes(link, stated)]
    return tuple(FileProblem(kind, text) for kind, text in found)


def problems_of_parts(body: RigidBody) -> tuple[tuple[Link, FileProblem], ...]:
    """Return the faults of all links of a body, each with the link that has it."""
    return tuple((link, problem) for link, _ in body.parts for problem in problems(link))


def _of_mass(stated: Stated) -> Iterator[tuple[str, str]]:
    """Yield kind and text of a fault: negative mass, tensor without mass, mass without tensor."""
    if stated.mass < 0:
        yield "negative mass", f"a mass of {stated.mass:g} kg"
    elif stated.mass == 0 and stated.inertia_com.any():
        yield "zero mass", "a tensor without a mass"
    elif stated.mass > 0 and not stated.inertia_com.any():
        yield "zero tensor", f"a mass of {stated.mass:g} kg without a tensor"


def _of_tensor(stated: Stated) -> Iterator[tuple[str, str]]:
    """Yield kind and text of the fault of a tensor that no body can have."""
    if not stated.inertia_com.any():
        return
    small, middle, large = principal_moments(stated.inertia_com)
    rounding = ROUNDING * max(abs(small), abs(large))
    if small <= -rounding or middle <= rounding:
        moments = ", ".join(f"{moment:.4g}" for moment in (small, middle, large))
        rule = "principal moments must be positive"
        yield "not positive definite", f"{rule}, they are {moments} kg m²"
    elif large - small - middle > rounding:
        yield "triangle inequality", f"{_digits(small, middle, large)}: no body has it"
    elif small <= rounding:
        # A rod without thickness, whose angular velocity about its own axis is undetermined.
        yield "not positive definite", f"a principal moment is {small:.3g} kg m²"


def _digits(small: float, middle: float, large: float) -> str:
    """Return three moments as "a + b < c", with the fewest digits for which this is still true."""
    for digits in range(2, 18):
        a, b, c = (f"{moment:.{digits}g}" for moment in (small, middle, large))
        if float(a) + float(b) < float(c):
            return f"{a} + {b} < {c}"
    return f"{small!r} + {middle!r} < {large!r}"


def _placeholder(stated: Stated) -> Iterator[tuple[str, str]]:
    """Yield kind and text of a fault if the tensor is a placeholder.

    A placeholder is a power of ten times the identity.
    """
    moment = float(stated.unturned[0, 0])
    exponent = round(np.log10(moment)) if moment > 0 else 0
    if moment == float(f"1e{exponent}") and (stated.unturned == moment * np.eye(3)).all():
        yield "placeholder", f"{moment:g} × identity: a placeholder"


def _beside_its_shapes(link: Link, stated: Stated) -> Iterator[tuple[str, str]]:
    """Yield kind and text of each fault of a link whose mass cannot lie within its shapes.

    Two things are tested. The variance of a mass distribution of width w is at most (w/2)²
    (T. Popoviciu 1935); along x it is (Iyy + Izz − Ixx) / 2m. And the mass is at most that of the
    box around the shapes, filled with the densest element; a flat box is left out here.
    """
    box = shapes_box(link)
    if box is None:
        return
    extent = box[1] - box[0]
    diagonal = np.diag(stated.inertia_com)
    # For a tiny mass the radius of gyration may overflow to infinity.
    with np.errstate(over="ignore"):
        spread = np.sqrt((diagonal.sum() / 2 - diagonal) / stated.mass)
    most = SHAPE_SLACK * extent / 2
    axis = int(np.argmax(spread / np.maximum(most, np.finfo(float).tiny)))
    if spread[axis] > most[axis]:
        yield (
            "radius of gyration",
            f"its radius of gyration along {'xyz'[axis]} is {spread[axis]:.3g} m; within its "
            f"shapes, {extent[axis]:.3g} m wide, at most {extent[axis] / 2:.3g} m are possible",
        )
    if 0 < DENSEST * float(np.prod(SHAPE_SLACK * extent)) < stated.mass:
        sides = " × ".join(f"{side:.3g}" for side in extent)
        yield (
            "density",
            f"{stated.mass:g} kg within shapes of {sides} m are denser than any element, osmium's "
            f"{DENSEST:.0f} kg/m³: is the mass in grams?",
        )


def shapes_box(link: Link) -> FloatArray | None:
    """Return the lowest and the highest corner of the box around a link's shapes, m, (2, 3).

    It is None if the link has no shapes, or if the size of one is not known.
    """
    boxes = [shape.box for shape in link.shapes]
    known = [box for box in boxes if box is not None]
    if not known or len(known) < len(boxes):
        return None
    return np.array([np.min(known, axis=0)[0], np.max(known, axis=0)[1]])
