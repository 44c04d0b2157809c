"""Other ways to write a scene's body into a model, which mean the same."""

from dataclasses import dataclass
from typing import Literal

from mpmath import mp, mpf

from ...scenarios import Body
from ...scenarios.exact import (
    DIGITS,
    NO_TURN,
    ZERO,
    Quaternion,
    Vector,
    conjugate,
    rotate,
    turned_tensor,
)
from ...scenarios.principal import principal_axes

#: A turn of a frame about none of its axes; of norm 1 to the last digit.
TURN: Quaternion = (mpf("0.8"), mpf("0.2"), mpf("0.4"), mpf("-0.4"))
#: Where frames are put that are off the body's: in its largest radii of gyration, so that a body of
#: 7 cm has them 0.39 m away.
AWAY = (mpf("4.2"), mpf("-2.8"), mpf("2.1"))
#: m/s², of the gravity that is taken away again.
COMPENSATED = (0.0, 0.0, -9.81)

Parts = Literal["one", "welded", "nested", "halves", "thirds"]
Joint = Literal["own", "aligned", "slides and ball", "hinges"]


@dataclass(frozen=True)
class Description:
    """How a body is written, where that is not the scene's own way.

    Attributes
    ----------
    parts : one body; an empty one with the whole welded to it; the same with an empty one between,
        off and turned; or two or three that share the mass, the others welded to the first
    full_tensor : whether the tensor is written whole, not along its principal axes
    shape : whether the inertia is that of a box, not stated
    joint : that the body moves by; `aligned` is a free joint along the inertial frame, which the
        model has off the body's frame and turned
    compensated : whether gravity acts, and is taken away again
    urdf : whether the model is URDF, of an engine that has a language of its own
    """

    parts: Parts = "one"
    full_tensor: bool = False
    shape: bool = False
    joint: Joint = "own"
    compensated: bool = False
    urdf: bool = False

    @property
    def features(self) -> frozenset[str]:
        """What an engine's models must have words for."""
        wanted = {
            "parts": self.parts != "one",
            "full tensor": self.full_tensor,
            "shape": self.shape,
            "joint": self.joint != "own",
            "compensated": self.compensated,
            "urdf": self.urdf,
        }
        return frozenset(name for name, is_asked in wanted.items() if is_asked)


#: As every scene is written.
PLAIN = Description()


@dataclass(frozen=True, eq=False)
class Part:
    """A body of a model, welded to another.

    Attributes
    ----------
    onto : the part that it is welded to, by its index; None of the first
    position, q : of its frame in that part's, m
    body : mass, com and tensor in its own frame; None if it is empty
    """

    onto: int | None
    position: Vector
    q: Quaternion
    body: Body | None


def parts_of(body: Body, parts: Parts) -> tuple[Part, ...]:
    """The parts of a body; the frame of the first is the body's own.

    Masses that share it lie on the axis of the least moment, where the mass reaches furthest, so
    that what is left of the tensor for each of them is one that a body can have.
    """
    with mp.workdps(DIGITS):
        if parts == "one":
            return (Part(None, ZERO, NO_TURN, body),)
        if parts == "welded":
            return (Part(None, ZERO, NO_TURN, None), Part(0, ZERO, NO_TURN, body))
        if parts == "nested":
            x, y, z = away_from(body)
            back = rotate(conjugate(TURN), (-x, -y, -z))
            return (
                Part(None, ZERO, NO_TURN, None),
                Part(0, (x, y, z), TURN, None),
                Part(1, back, conjugate(TURN), body),
            )
        return _shared(body, 2 if parts == "halves" else 3)


def away_from(body: Body) -> Vector:
    """A point far off the body's origin, m, body axes."""
    with mp.workdps(DIGITS):
        reach = mp.sqrt(max(principal_axes(body.inertia_com_exact)[0]) / body.mass_exact)
        x, y, z = (part * reach for part in AWAY)
    return (x, y, z)


def _shared(body: Body, count: int) -> tuple[Part, ...]:
    """As many parts of one mass: half of the spread along their axis is that of their places."""
    axis, spread = _longest(body)
    squares = sum((2 * k - count + 1) ** 2 for k in range(count))
    apart = mp.sqrt(spread / 2 * count / (body.mass_exact * squares))
    mass = body.mass_exact / count
    rows = [
        [
            (body.inertia_com_exact[i][j] - spread / 2 * ((i == j) - axis[i] * axis[j])) / count
            for j in range(3)
        ]
        for i in range(3)
    ]
    first, second, third = ((row[0], row[1], row[2]) for row in rows)
    # Symmetric to the last digit.
    left = turned_tensor((first, second, third), NO_TURN)
    parts = []
    for k in range(count):
        a, b, c = (
            at + (2 * k - count + 1) * apart * along
            for at, along in zip(body.com_exact, axis, strict=True)
        )
        if k == 0:
            parts.append(Part(None, ZERO, NO_TURN, Body(mass, (a, b, c), left)))
        else:
            parts.append(Part(0, (a, b, c), TURN, Body(mass, ZERO, turned_tensor(left, TURN))))
    return tuple(parts)


def _longest(body: Body) -> tuple[Vector, mpf]:
    """The axis of the least moment, and Σ m x² along it, kg m²."""
    moments, R_body_axes = principal_axes(body.inertia_com_exact)
    least = min(range(3), key=lambda k: moments[k])
    x, y, z = (row[least] for row in R_body_axes)
    return (x, y, z), sum(moments) / 2 - moments[least]
