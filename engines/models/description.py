"""The ways in which the same body can be written into a model."""

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

#: Quaternion of a turn about none of the frame's axes; its norm is exactly 1.
TURN: Quaternion = (mpf("0.8"), mpf("0.2"), mpf("0.4"), mpf("-0.4"))
#: Position of a frame far from the body's frame, in units of the body's largest radius of gyration:
#: it is 0.38 m away if that radius is 7 cm.
AWAY = (mpf("4.2"), mpf("-2.8"), mpf("2.1"))
#: Gravity, m/s², of a model in which the engine compensates it by a force.
COMPENSATED = (0.0, 0.0, -9.81)

Parts = Literal["one", "welded", "nested", "halves", "thirds"]
Joint = Literal["own", "aligned", "slides and ball", "hinges"]


@dataclass(frozen=True)
class Description:
    """How a body is written into a model.

    Attributes
    ----------
    parts : "one" body; "welded", a massless body with the whole mass on a second body welded to it;
        "nested", the same with a third, massless body between them, shifted and turned; "halves"
        or "thirds", two or three bodies that share the mass, the others welded to the first
    full_tensor : whether the tensor is written along the body's axes, with products of inertia, and
        not as principal moments
    shape : whether the model states no inertia, but has a box from which the engine computes it
    joint : the joint on which the body moves: "own", the engine's usual one for the scene;
        "aligned", a free joint in the inertial frame, which is shifted and turned relative to the
        frame of the model's body; "slides and ball", three slides and a ball joint in place of a
        free joint; "hinges", three hinges in place of a ball joint
    compensated : whether the model has gravity although the scene has none, and compensates it
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
    """One of the bodies that a scene's body is written as; they are welded together.

    Attributes
    ----------
    onto : index of the part that it is welded to; None for the first part
    position : origin of the part's frame in the frame of the part that it is welded to, m
    q : rotation of the part's frame relative to that frame, a quaternion w x y z
    body : mass, com and tensor in the part's own frame; None if the part has no mass
    """

    onto: int | None
    position: Vector
    q: Quaternion
    body: Body | None


def parts_of(body: Body, parts: Parts) -> tuple[Part, ...]:
    """Return the parts as which a body is written; the frame of the first is the body's own.

    Parts that share the mass lie on the principal axis of the least moment, along which the body is
    longest. So the tensor of each part is physically possible.

    Parameters
    ----------
    parts : into which parts the body is divided, as in `Description.parts`
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
    """Return a point far from the body's origin, m, along body axes.

    Its distance is in proportion to the body's largest radius of gyration.
    """
    with mp.workdps(DIGITS):
        reach = mp.sqrt(max(principal_axes(body.inertia_com_exact)[0]) / body.mass_exact)
        x, y, z = (part * reach for part in AWAY)
    return (x, y, z)


def _shared(body: Body, count: int) -> tuple[Part, ...]:
    """Return `count` parts of equal mass, in a row along the principal axis of the least moment.

    Let x be the coordinate along that axis from the body's com. Half of Σ m x² is due to the
    positions of the parts' coms, and half to the tensors of the parts.
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
    # Turning by the identity makes the tensor exactly symmetric.
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
    """Return the axis of the least principal moment, and the sum Σ m x² over the body, kg m².

    The axis is a unit vector, body axes, and x is the coordinate along it from the com.
    """
    moments, R_body_axes = principal_axes(body.inertia_com_exact)
    least = min(range(3), key=lambda k: moments[k])
    x, y, z = (row[least] for row in R_body_axes)
    return (x, y, z), sum(moments) / 2 - moments[least]
