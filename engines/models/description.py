"""Other ways to write a scene's body into a model, all of which mean the same body."""

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

#: A rotation of a frame about none of its axes; of norm 1 to the last digit.
TURN: Quaternion = (mpf("0.8"), mpf("0.2"), mpf("0.4"), mpf("-0.4"))
#: Place of frames that are off the body's frame, in units of the body's largest radius of gyration:
#: a body with one of 7 cm has such frames 0.38 m away.
AWAY = (mpf("4.2"), mpf("-2.8"), mpf("2.1"))
#: Gravity, m/s², that acts in the model and is compensated by forces.
COMPENSATED = (0.0, 0.0, -9.81)

Parts = Literal["one", "welded", "nested", "halves", "thirds"]
Joint = Literal["own", "aligned", "slides and ball", "hinges"]


@dataclass(frozen=True)
class Description:
    """How a body is written into a model, where that differs from the scene's own way.

    Attributes
    ----------
    parts : "one" body; "welded", an empty body with the whole mass on a second body welded to it;
        "nested", the same with an empty body between them, shifted and turned; or "halves" and
        "thirds", two or three bodies that share the mass, the others welded to the first
    full_tensor : whether the tensor is written whole, not along its principal axes
    shape : whether the model has a box of the body's inertia and states no inertia itself
    joint : what the body moves by: the engine's "own" joint for the scene; "aligned", a free joint
        along the inertial frame, which the model has shifted and turned against the body's frame;
        "slides and ball", three slides and a ball joint in place of a free joint; or "hinges",
        three hinges in place of a ball joint
    compensated : whether gravity acts although the scene has none, and is compensated
    urdf : whether the model is URDF, for an engine that has another language of its own
    """

    parts: Parts = "one"
    full_tensor: bool = False
    shape: bool = False
    joint: Joint = "own"
    compensated: bool = False
    urdf: bool = False

    @property
    def features(self) -> frozenset[str]:
        """Names of the ways in which the description differs from `PLAIN`.

        An engine whose `describes` lacks one of these names cannot write such a model.
        """
        wanted = {
            "parts": self.parts != "one",
            "full tensor": self.full_tensor,
            "shape": self.shape,
            "joint": self.joint != "own",
            "compensated": self.compensated,
            "urdf": self.urdf,
        }
        return frozenset(name for name, is_asked in wanted.items() if is_asked)


#: The description with which every scene is written by default.
PLAIN = Description()


@dataclass(frozen=True, eq=False)
class Part:
    """A body of a model, welded to another body.

    Attributes
    ----------
    onto : index of the part that it is welded to; None for the first part
    position, q : pose of the part's frame in the frame of the part that it is welded to, m, w x y z
    body : mass, com and tensor in the part's own frame; None if the part has no mass
    """

    onto: int | None
    position: Vector
    q: Quaternion
    body: Body | None


def parts_of(body: Body, parts: Parts) -> tuple[Part, ...]:
    """Return the parts that a body is written as; the frame of the first is the body's own.

    Parts that share the mass lie on the axis of the least moment, along which the mass reaches
    furthest: so each part gets a tensor that is physically possible.
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
    """Return a point far from the body's origin, m, body axes, in proportion to the body's size."""
    with mp.workdps(DIGITS):
        reach = mp.sqrt(max(principal_axes(body.inertia_com_exact)[0]) / body.mass_exact)
        x, y, z = (part * reach for part in AWAY)
    return (x, y, z)


def _shared(body: Body, count: int) -> tuple[Part, ...]:
    """Return `count` parts of equal mass, in a row along the axis of the least moment.

    Their places account for half of Σ m x² along that axis, their own tensors for the rest.
    """
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
    # Turned by no turn, which makes it symmetric to the last digit.
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
    """Return the axis of the least moment, body axes, and the body's Σ m x² along it, kg m²."""
    moments, R_body_axes = principal_axes(body.inertia_com_exact)
    least = min(range(3), key=lambda k: moments[k])
    x, y, z = (row[least] for row in R_body_axes)
    return (x, y, z), sum(moments) / 2 - moments[least]
