"""The names of what may be off: changes of equations of motion, and mistakes in reading states.

They are used for what single steps of an engine gain, and for recorded motions. A change is known
by its kind and its numbers, SI; its words follow "as if".
"""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial

from ...scenarios import EFFECTS

#: A change of a factor that seven digits show to a tenth.
VISIBLE = 1e-5
#: Numbers this small beside others are zero but for rounding.
ROUNDING = 1e-12
#: Of a body that turns freely a motion does not show how large its tensor is.
UP_TO_A_FACTOR = ", up to a factor"
_MOMENTUM = next(one.wrong_momentum for one in EFFECTS.values() if one.wrong_momentum)


@dataclass(frozen=True)
class Kind:
    """A kind of change.

    Attributes
    ----------
    count : of its numbers
    words : says it of its numbers
    is_kinematic : whether it is one of how the attitude follows ω
    """

    count: int
    words: Callable[[Sequence[float]], str]
    is_kinematic: bool = False


def vector(numbers: Sequence[float]) -> str:
    """Numbers in brackets."""
    least = ROUNDING * max(map(abs, numbers))
    return f"[{', '.join(f'{n if abs(n) > least else 0.0:.7g}' for n in numbers)}]"


def factor(change: float) -> str:
    """One and a change, with as many digits as show it."""
    return f"{1 + change:.{7 if abs(change) > VISIBLE else 11}g}"


def _with_factor(words: str, wholes: dict[float, str], n: Sequence[float]) -> str:
    return wholes.get(1 + n[0]) or words.format(factor(n[0]))


def _with_vector(words: str, n: Sequence[float]) -> str:
    return words.format(vector(n))


def _with_turn(words: str, n: Sequence[float]) -> str:
    """Fill in a rotation vector."""
    angle = math.hypot(*n)
    axis = vector([value / (angle or 1.0) for value in n])
    return words.format(f"{math.degrees(angle):.4g}° about {axis}")


def _with_axes(words: str, n: Sequence[float]) -> str:
    """Fill in names of axes, which are counted from zero."""
    return words.format("".join("xyz"[int(axis) % 3] for axis in n))


def _slowed(unit: str, n: Sequence[float]) -> str:
    return f"{'slowed' if n[0] > 0 else 'sped up'} by {abs(n[0]):.3g} {unit}"


def _decays(n: Sequence[float]) -> str:
    return f"L were slowed by {n[0]:.3g} {'-' if n[1] < 0 else '+'} {abs(n[1]):.3g} ‖ω‖ /s"


def _gyroscopic(n: Sequence[float]) -> str:
    """Say how much is missing of the torque."""
    words = "the gyroscopic torque ω × Iω were {} times as strong"
    return _with_factor(words, {0.0: "there were no gyroscopic torque"}, [-n[0]])


def _other_omega(n: Sequence[float]) -> str:
    """Name components of ω, each by its axis, counted from one, with a sign."""
    names = [f"{'−' if axis < 0 else ''}ω{'xyz'[int(abs(axis)) % 4 - 1]}" for axis in n]
    return f"it turns as if ω were [{', '.join(names)}]"


def _flipped(n: Sequence[float]) -> str:
    """Name the products of inertia that have another sign."""
    pairs = zip(n, ("Ixy", "Ixz", "Iyz"), strict=True)
    return f"{' and '.join(name for sign, name in pairs if sign < 0)} had the other sign"


def _permuted(n: Sequence[float]) -> str:
    return (
        f"the principal moments were permuted, {vector(n[:3])} kg m² along the axes of "
        f"{vector(n[3:])}"
    )


#: Kinds without numbers.
_PLAIN = {
    "no gyroscopic torque of the body": "there were no gyroscopic torque ω × Iω of the body",
    "gyroscopic about the com": "the gyroscopic torque were ω × Iω with the tensor about the com",
    "gyroscopic of the diagonal": "the gyroscopic torque ω × Iω were of the tensor's diagonal "
    "alone",
    "gyroscopic of other products": "the gyroscopic torque ω × Iω were of the tensor with its "
    "products of inertia of the other sign",
    "gyroscopic without rotation": "the gyroscopic torque ω × Iω were of the principal moments as "
    "if they were along the body's axes",
    "gyroscopic about conjugated axes": "the gyroscopic torque ω × Iω were of the tensor about "
    "conjugated principal axes",
    "inverse of the diagonal": "ω' were of the tensor's diagonal alone, though ω × Iω is of all of "
    "it",
    "tensor as at the start": "the tensor did not turn with the body: as it is at the start, in "
    "world axes",
    "tensor along the world": "the tensor were along world axes, and did not turn with the body",
    "other products": "the products of inertia had the other sign",
    "no products": "there were no products of inertia",
    "conjugated axes": "the tensor were about conjugated principal axes",
    "without rotation": "the principal moments were along the body's axes, without the tensor's "
    "rotation",
    "com as pivot": "the tensor about the com were that about the pivot",
    "pivot twice": "the tensor about the pivot were the one about the com twice moved",
    "com as origin": "the tensor were about the origin instead of the com",
    "com twice": "the tensor about the com had been moved from the origin once more",
    "sphere": "the tensor were that of a sphere",
    "torque along other axes": "the torque were constant along the other axes",
    "scalar last": "the quaternion were read as x, y, z, w",
    "scalar first": "the quaternion's last component were taken for its first",
    "conjugated": "the quaternion were read conjugated",
    "ω in the world": "ω were read along the world's axes",
    "ω turned twice": "ω were turned from world to body axes once more than it needs",
    "ω reversed": "ω were read with the opposite sign",
}
_PLAIN_KINEMATICS = {
    "wrong side": "q' = ½ ω q, as if ω were along world axes: the product is on the wrong side",
    "wrong side, no ½": "q' = ω q, without the ½, and on the wrong side",
    "wrong side, reversed": "q' = −½ ω q, with the other sign, and on the wrong side",
}
#: Kinds whose number is by how much a factor is off, with other words for some factors.
_FACTORS: dict[str, tuple[str, dict[float, str]]] = {
    "gyroscopic, with rotors": ("the gyroscopic torque ω × (Iω + h) were {} times as strong", {}),
    "momentum": (
        _MOMENTUM,
        {
            0.0: "there were no rotors' torque ω × h",
            -1.0: "the rotors' torque ω × h had the other sign",
        },
    ),
    "gravity's size": (
        "gravity were {} times as strong",
        {0.0: "there were no gravity", -1.0: "gravity were turned round"},
    ),
    "torque's size": (
        "the torque were {} times as strong",
        {0.0: "there were no torque", -1.0: "the torque had the other sign"},
    ),
    "drag's size": (
        "drag were {} times as strong",
        {0.0: "there were no drag", -1.0: "drag had the other sign"},
    ),
    "tensor's size": ("the tensor were {} times as large", {}),
    "step": ("a step took {} timesteps", {}),
    "omega": ("ω were read multiplied by {}", {}),
    "velocity": ("the velocity were read multiplied by {}", {}),
}
_TURNING = (
    "it turns {} times as fast as ω says",
    {
        2.0: "q' = q ω, without the ½",
        0.5: "q' = ¼ q ω, with the ½ twice",
        -1.0: "q' = −½ q ω, with the other sign",
    },
)
_ENTRIES = "Ixx, Iyy, Izz, Ixy, Ixz, Iyz = {} kg m²"
#: Kinds with so many numbers, which the words show one after the other.
_VECTORS: dict[str, tuple[int, str]] = {
    "gravity": (3, "gravity were {} m/s²"),
    "com": (3, "the com were at {} m"),
    "torque along body axes": (3, "a torque of {} N m acted besides, along body axes"),
    "torque along world axes": (3, "a torque of {} N m acted besides, along world axes"),
    "gyroscopic tensor": (6, f"the gyroscopic torque ω × Gω were with G: {_ENTRIES}, not I"),
}
for _more in ("", UP_TO_A_FACTOR):
    _VECTORS |= {
        f"moments{_more}": (3, f"the moments were {{}} kg m²{_more}"),
        f"box{_more}": (
            3,
            f"the tensor were that of a box along the body's axes, with {{}} kg m²{_more}",
        ),
        f"tensor{_more}": (6, f"the tensor were {_ENTRIES}{_more}"),
    }


def _kinds() -> Iterable[tuple[str, Kind]]:
    for plain, is_kinematic in ((_PLAIN, False), (_PLAIN_KINEMATICS, True)):
        for name, words in plain.items():
            yield name, Kind(0, partial(_first, words), is_kinematic)
    for name, (words, wholes) in _FACTORS.items():
        yield name, Kind(1, partial(_with_factor, words, wholes))
    for name, (count, words) in _VECTORS.items():
        yield name, Kind(count, partial(_with_vector, words))
    yield "turning", Kind(1, partial(_with_factor, *_TURNING), is_kinematic=True)
    yield "other components", Kind(3, _other_omega, is_kinematic=True)
    euler = "ω is taken for the rates of Euler angles {}"
    yield "Euler rates", Kind(3, partial(_with_axes, euler), is_kinematic=True)
    other = "it turns as if ω were along axes turned by {}"
    yield "turning along other axes", Kind(3, partial(_with_turn, other), is_kinematic=True)
    matrix = "it turns as if ω were multiplied by the matrix of rows {}"
    yield "turning by a matrix", Kind(9, partial(_with_vector, matrix), is_kinematic=True)
    rotated = "the tensor were the same about axes turned by {}"
    yield "rotated tensor", Kind(3, partial(_with_turn, rotated))
    rows = "the tensor's rows and columns were those of the axes {}"
    yield "rows and columns", Kind(3, partial(_with_axes, rows))
    yield "gyroscopic", Kind(1, _gyroscopic)
    yield "permuted moments", Kind(6, _permuted)
    yield "signs of products", Kind(3, _flipped)
    yield "resistance", Kind(1, lambda n: f"it were {_slowed('N m s', n)}")
    yield "decay", Kind(1, lambda n: f"L were {_slowed('/s', n)}")
    yield "decays", Kind(2, _decays)


def _first(words: str, _: Sequence[float]) -> str:
    return words


#: Every kind of change, by name.
KINDS: dict[str, Kind] = dict(_kinds())
