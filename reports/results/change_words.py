"""Words for what may be wrong: changes of equations of motion, and mistakes in reading states.

Such a change may explain the single steps of an engine, or a recorded motion. It is identified by
its kind and by numbers, SI. Its words complete a sentence that begins "behaves as if".
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

from ...scenarios import EFFECTS

#: Smallest deviation of a factor from 1 that seven digits show to within a tenth of it.
VISIBLE = 1e-5
#: Largest size, relative to other components, of a component that is zero but for rounding.
ROUNDING = 1e-12
#: Relative difference below which two fitted numbers count as equal.
ALIKE = 1e-2
#: Number of decimals to which fitted exponents and quaternions are rounded.
DIGITS = 6
#: Products of inertia, in the order in which they are always listed.
PRODUCTS = "Ixy", "Ixz", "Iyz"
#: Words added for a body that turns freely, as its motion shows only the ratios of its moments.
UP_TO_A_FACTOR = ", up to a factor"
_MOMENTUM = next(one.wrong_momentum for one in EFFECTS.values() if one.wrong_momentum)


def vector(numbers: Sequence[float]) -> str:
    """Return numbers as text in brackets; those that are zero but for rounding are written as 0."""
    least = ROUNDING * max(map(abs, numbers))
    return f"[{', '.join(f'{n if abs(n) > least else 0.0:.7g}' for n in numbers)}]"


def _fitted_vector(numbers: Sequence[float]) -> str:
    """Return fitted numbers as text in brackets.

    Numbers smaller than 10⁻⁶ of the largest are zero but for errors of the fit, and are written as
    0.
    """
    least = 10.0**-DIGITS * max(map(abs, numbers))
    return vector([n if abs(n) > least else 0.0 for n in numbers])


def _factor(numbers: Sequence[float]) -> str:
    """Return a factor as text, with enough digits to show how far it is from 1.

    Parameters
    ----------
    numbers : one number, the factor less 1
    """
    (change,) = numbers
    return f"{1 + change:.{7 if abs(change) > VISIBLE else 11}g}"


def _turn(numbers: Sequence[float]) -> str:
    """Return a rotation vector, rad, as an angle in degrees and an axis, in words."""
    angle = math.hypot(*numbers)
    axis = vector([value / (angle or 1.0) for value in numbers])
    return f"{math.degrees(angle):.4g}° about {axis}"


def _slowed(numbers: Sequence[float]) -> str:
    """Return the words for a rate of slowing, such as "slowed by 0.1"; "sped up by" if negative.

    Parameters
    ----------
    numbers : one number, the rate; its unit follows in the sentence, outside of these words
    """
    return f"{'slowed' if numbers[0] > 0 else 'sped up'} by {abs(numbers[0]):.3g}"


def _decays(numbers: Sequence[float]) -> str:
    """Return the words for the rate a + b ‖ω‖, 1/s, at which the angular momentum decays.

    Parameters
    ----------
    numbers : a, 1/s, and b, 1/rad
    """
    a, b = numbers
    return f"{a:.3g} {'-' if b < 0 else '+'} {abs(b):.3g} ‖ω‖"


def _power(numbers: Sequence[float]) -> str:
    """Return the words for a drag torque that grows as a power of ‖ω‖.

    Parameters
    ----------
    numbers : the torque at 1 rad/s, N m, and the exponent
    """
    size, power = numbers
    rounded = round(power, DIGITS) + 0.0
    return f"{size:.4g} ‖ω‖^{rounded:.4g} N m" if rounded else f"dry friction of {size:.4g} N m"


def _rotors(numbers: Sequence[float]) -> str:
    """Return the words for one rotor, or for all of them.

    Parameters
    ----------
    numbers : the rotor's number, counted from one; 0 for all rotors
    """
    return f"rotor {numbers[0]:.0f}" if numbers[0] else "the rotors"


def _axes(numbers: Sequence[float]) -> str:
    """Return the names of axes as one text, such as "xz", given their indices from zero."""
    return "".join("xyz"[int(axis) % 3] for axis in numbers)


def _components(numbers: Sequence[float]) -> str:
    """Return the names of components of ω as one text, such as "ωy, −ωx, ωz".

    Parameters
    ----------
    numbers : axis of each component, counted from one, negative if the component's sign is reversed
    """
    return ", ".join(f"{'−' if n < 0 else ''}ω{_axes([abs(n) - 1])}" for n in numbers)


def _products(numbers: Sequence[float]) -> str:
    """Return the names of the products of inertia whose sign is reversed.

    Parameters
    ----------
    numbers : 1 or −1 for Ixy, Ixz and Iyz each; −1 if the sign is reversed
    """
    pairs = zip(numbers, PRODUCTS, strict=True)
    return " and ".join(name for sign, name in pairs if sign < 0)


def _exchanged(numbers: Sequence[float]) -> str:
    """Return the names of the products of inertia in another order, such as "Ixz, Ixy and Iyz".

    Parameters
    ----------
    numbers : index of each in Ixy, Ixz, Iyz, from zero
    """
    names = [PRODUCTS[int(k)] for k in numbers]
    return f"{', '.join(names[:2])} and {names[2]}"


def _entry(numbers: Sequence[float]) -> str:
    """Return the words for a wrong entry of the inertia tensor: its name, value and error.

    Parameters
    ----------
    numbers : index of the entry in xx, yy, zz, xy, xz, yz, from zero; the wrong value, kg m²; and
        the error of this value, kg m²
    """
    at, value, off = numbers
    name, how = ("Ixx", "Iyy", "Izz", *PRODUCTS)[int(at)], "more" if off > 0 else "less"
    return f"{name} were {value:.7g} kg m², {abs(off):.3g} {how} than it is"


def _permuted(numbers: Sequence[float]) -> str:
    """Return the words for permuted principal moments.

    Parameters
    ----------
    numbers : the three moments in the wrong order, kg m², and then in the right order, kg m²
    """
    return f"{vector(numbers[:3])} kg m² along the axes of {vector(numbers[3:])}"


def _gradient(numbers: Sequence[float]) -> str:
    """Return the words for a gravity gradient.

    Parameters
    ----------
    numbers : the size of the gradient, 1/s², and a unit vector along its axis
    """
    return f"{numbers[0]:.4g} /s² along {vector(numbers[1:])}"


def _gradient_tensor(numbers: Sequence[float]) -> str:
    """Return the words for a gravity gradient: size and axis if symmetric about one, else entries.

    Parameters
    ----------
    numbers : xx − zz, yy − zz, xy, xz and yz of the gradient, 1/s²
    """
    xx, yy, xy, xz, yz = numbers
    sizes, axes = np.linalg.eigh([[xx, xy, xz], [xy, yy, yz], [xz, yz, 0.0]])
    below, above = np.diff(sizes)
    if min(below, above) > ALIKE * max(below, above):
        return f"{vector(numbers)} /s² along world axes, for xx − zz, yy − zz, xy, xz and yz,"
    k = 2 if below < above else 0
    # The axis has no direction: its largest component is made positive.
    axis = axes[:, k] * np.sign(axes[np.argmax(np.abs(axes[:, k])), k])
    return _gradient([sizes[k] - sizes[1], *axis])


def _by_attitude(numbers: Sequence[float]) -> str:
    """Return the words for a torque that depends on the attitude: Σᵢ P eᵢ × Rᵀ eᵢ, N m, body axes.

    R takes body to world components, and the eᵢ are the unit vectors. A torque is described as that
    of a dipole in a field, or of a spring, if it has this form.

    Parameters
    ----------
    numbers : the nine entries of P, row by row, N m
    """
    P = np.reshape(numbers, (3, 3))
    of_body, sizes, of_world = np.linalg.svd(P)
    first, size = float(sizes[0]), float(sizes.mean())
    if sizes[1] < ALIKE * first:
        # m × b stays the same if both signs are reversed.
        sign = 1.0 if of_body[np.argmax(np.abs(of_body[:, 0])), 0] > 0 else -1.0
        m, b = (vector((sign * one).tolist()) for one in (of_body[:, 0], of_world[0]))
        return (
            f"{first:.4g} N m times m × b acted, m = {m} in the body and b = {b} in the world, as "
            "of a dipole in a field,"
        )
    if sizes[2] > (1 - ALIKE) * first:
        sign = float(np.sign(np.linalg.det(P)))
        to = Rotation.from_matrix(sign * P.T / size).as_quat(scalar_first=True, canonical=True)
        at = vector([round(one, DIGITS) + 0.0 for one in to])
        way = "to" if sign > 0 else "away from"
        return f"a spring of {2 * size:.4g} N m a radian turned it {way} the attitude {at}"
    return f"Σ P eᵢ × Rᵀeᵢ acted, with P of the entries {vector(numbers)} N m,"


def _tilted(numbers: Sequence[float]) -> str:
    """Return the words for a tilted gravity.

    Parameters
    ----------
    numbers : the angle of the tilt, °, and the tilted gravity, m/s², three components
    """
    angle, *gravity = numbers
    return (
        f"{angle:.3g}° against the scene's, and is {_fitted_vector(gravity)} m/s²: a stand, or the "
        "axes of what records attitudes, may not be level"
    )


def _by_angle(numbers: Sequence[float]) -> str:
    """Return the words for the torque of a torsion spring, proportional to the angle from rest.

    Parameters
    ----------
    numbers : stiffness, N m/rad, and the attitude at which the spring is at rest, a quaternion
        w x y z
    """
    k, *q_rest_wxyz = numbers
    at = vector([round(q, DIGITS) + 0.0 for q in q_rest_wxyz])
    way = "to" if k > 0 else "away from"
    return (
        f"{abs(k):.4g} N m a radian, in proportion to the angle, turned it {way} the attitude {at}"
    )


@dataclass(frozen=True)
class Kind:
    """A kind of change of the equations of motion or of how states are read.

    Attributes
    ----------
    template : words for a change of this kind, with a pair of braces for its numbers, if it has any
    count : how many numbers a change of this kind has
    shown : function that returns these numbers as text
    is_kinematic : whether the change is in how the attitude follows from ω, not in how ω changes
    special : words that replace the template if the first number has a given value, by that value;
        empty words do not replace it
    """

    template: str
    count: int = 0
    shown: Callable[[Sequence[float]], str] = vector
    is_kinematic: bool = False
    special: Mapping[float, str] = field(default_factory=dict)

    def words(self, numbers: Sequence[float]) -> str:
        """Return a change of this kind in words, which follow "behaves as if".

        Parameters
        ----------
        numbers : the numbers of the change, SI
        """
        if not numbers:
            return self.template
        return self.special.get(numbers[0]) or self.template.format(self.shown(numbers))


def _of_factor(template: str, none: str = "", reversed_: str = "") -> Kind:
    """Return a kind of change that multiplies a term by a factor; its number is the factor − 1.

    Parameters
    ----------
    template : words with a pair of braces for the factor
    none : words for the factor 0; if empty, the template is used
    reversed_ : words for the factor −1; if empty, the template is used
    """
    return Kind(template, 1, _factor, special={-1.0: none, -2.0: reversed_})


_ENTRIES = "Ixx, Iyy, Izz, Ixy, Ixz, Iyz = {} kg m²"
_GYROSCOPIC = "the gyroscopic torque ω × Iω were "
_NOT_GYROSCOPIC = "there were no gyroscopic torque"
_AS_AT_THE_START = "the tensor did not turn with the body: as it is at the start, in world axes"
_ALONG_THE_WORLD = "the tensor were along world axes, and did not turn with the body"
_BESIDES = "a torque of {} N m acted besides, along "
_WITH_HALF = {1.0: "q' = q ω, without the ½", -0.5: "q' = ¼ q ω, with the ½ twice"}
_TURNING = _WITH_HALF | {-2.0: "q' = −½ q ω, with the other sign"}
#: Every kind of change.
KINDS = {
    # How the attitude follows ω.
    "wrong side": Kind(
        "q' = ½ ω q, as if ω were along world axes: the product is on the wrong side",
        is_kinematic=True,
    ),
    "wrong side in world axes": Kind(
        "q' = ½ q ω with ω along world axes: the product is on the wrong side", is_kinematic=True
    ),
    "wrong side, no ½": Kind("q' = ω q, without the ½, and on the wrong side", is_kinematic=True),
    "wrong side, reversed": Kind(
        "q' = −½ ω q, with the other sign, and on the wrong side", is_kinematic=True
    ),
    "turning": Kind(
        "it turns {} times as fast as ω says", 1, _factor, is_kinematic=True, special=_TURNING
    ),
    "other components": Kind("it turns as if ω were [{}]", 3, _components, is_kinematic=True),
    "Euler rates": Kind("ω is taken for the rates of Euler angles {}", 3, _axes, is_kinematic=True),
    "turning along other axes": Kind(
        "it turns as if ω were along axes turned by {}", 3, _turn, is_kinematic=True
    ),
    "turning by a matrix": Kind(
        "it turns as if ω were multiplied by the matrix of rows {}", 9, is_kinematic=True
    ),
    # The gyroscopic torque. The number of "gyroscopic" is the fraction of it that is missing.
    "gyroscopic": Kind(
        _GYROSCOPIC + "{} times as strong",
        1,
        lambda n: _factor([-n[0]]),
        special={1.0: _NOT_GYROSCOPIC},
    ),
    "gyroscopic, with parts": _of_factor(
        "the gyroscopic torque ω × (Iω + h) were {} times as strong"
    ),
    "no gyroscopic torque of the body": Kind("there were no gyroscopic torque ω × Iω of the body"),
    "gyroscopic about the com": Kind(
        "the gyroscopic torque were ω × Iω with the tensor about the com"
    ),
    "gyroscopic of the diagonal": Kind(_GYROSCOPIC + "of the tensor's diagonal alone"),
    "gyroscopic of other products": Kind(
        _GYROSCOPIC + "of the tensor with its products of inertia of the other sign"
    ),
    "gyroscopic without rotation": Kind(
        _GYROSCOPIC + "of the principal moments as if they were along the body's axes"
    ),
    "gyroscopic about conjugated axes": Kind(
        _GYROSCOPIC + "of the tensor about conjugated principal axes"
    ),
    "gyroscopic tensor": Kind(f"the gyroscopic torque ω × Gω were with G: {_ENTRIES}, not I", 6),
    "sign of a rate": Kind("ω{}' had the other sign", 1, _axes),
    "rate held": Kind("ω about its own {} axis were held as it is, as by a hinge", 1, _axes),
    "rate set": Kind("its {} axis were locked: ω about it stays what it was", 1, _axes),
    "inverse of the diagonal": Kind(
        "ω' were of the tensor's diagonal alone, though ω × Iω is of all of it"
    ),
    "momentum": _of_factor(
        _MOMENTUM,
        "there were no rotors' torque ω × h",
        "the rotors' torque ω × h had the other sign",
    ),
    "spins left out": Kind("rotors on free hinges were at rest in the body in the torque ω × h"),
    "rotors' momentum": Kind("the rotors had an angular momentum of {} N m s", 3),
    "momentum besides": Kind("a wheel in it had a constant angular momentum of {} N m s", 3),
    **{
        f"{hinge} rotors": Kind(f"{{}} {words}", 1, _rotors)
        for hinge, words in (
            ("free", "turned freely on their hinges"),
            ("driven", "were driven, at a constant speed relative to the body"),
            ("locked", "were fixed to the body"),
            ("reversed", "turned the other way round"),
        )
    },
    # The tensor.
    "tensor as at the start": Kind(_AS_AT_THE_START),
    "tensor as at the start, not gyroscopic": Kind(f"{_NOT_GYROSCOPIC}, and {_AS_AT_THE_START}"),
    "tensor along the world": Kind(_ALONG_THE_WORLD),
    "tensor along the world, not gyroscopic": Kind(f"{_NOT_GYROSCOPIC}, and {_ALONG_THE_WORLD}"),
    "tensor turned on": Kind("ω were Rᵀ I⁻¹ R L along world axes, for R I⁻¹ Rᵀ L"),
    "other products": Kind("the products of inertia had the other sign"),
    "no products": Kind("there were no products of inertia"),
    "signs of products": Kind("{} had the other sign", 3, _products),
    "conjugated axes": Kind("the tensor were about conjugated principal axes"),
    "without rotation": Kind(
        "the principal moments were along the body's axes, without the tensor's rotation"
    ),
    "inverse for the tensor": Kind("the tensor's inverse were taken for the tensor"),
    "com as pivot": Kind("the tensor about the com were that about the pivot"),
    "pivot twice": Kind("the tensor about the pivot were the one about the com twice moved"),
    "com as origin": Kind("the tensor were about the origin instead of the com"),
    "com twice": Kind("the tensor about the com had been moved from the origin once more"),
    "permuted moments": Kind("the principal moments were permuted, {}", 6, _permuted),
    "rows and columns": Kind("the tensor's rows and columns were those of the axes {}", 3, _axes),
    "exchanged products": Kind("the products Ixy, Ixz and Iyz were {}", 3, _exchanged),
    "parallel axes by distance": Kind(
        "the parallel axis theorem added m r² along every axis, without − m r rᵀ"
    ),
    "parallel axes' products": Kind("the products of the parallel axis theorem had the other sign"),
    "rounded tensor": Kind("the tensor were rounded to {} decimals", 1, lambda n: f"{n[0]:.0f}"),
    "entry": Kind("{}", 3, _entry),
    "sphere": Kind("the tensor were that of a sphere"),
    "tensor's size": _of_factor("the tensor were {} times as large"),
    "rotated tensor": Kind("the tensor were the same about axes turned by {}", 3, _turn),
    **{
        f"{kind}{how}": Kind(words + how, count)
        for how in ("", UP_TO_A_FACTOR)
        for kind, words, count in (
            ("moments", "the moments were {} kg m²", 3),
            ("box", "the tensor were that of a box along the body's axes, with {} kg m²", 3),
            ("tensor", f"the tensor were {_ENTRIES}", 6),
        )
    },
    # Other effects.
    "com": Kind("the com were at {} m", 3),
    "lever": Kind("gravity's lever, mass times the com, were {} kg m, the tensor as it is", 3),
    "world vectors turned on": Kind("gravity and torques were turned by R for its transpose"),
    "world vectors unturned": Kind("gravity and torques along world axes turned with the body"),
    "torques unturned": Kind("gravity's torque along world axes were along the body's"),
    "gravity": Kind("gravity were {} m/s²", 3),
    "gravity on a free body": Kind(
        "gravity acted on the com about the body's origin, as of a body on a pivot"
    ),
    "gravity's size": _of_factor(
        "gravity were {} times as strong", "there were no gravity", "gravity were turned round"
    ),
    "resistance": Kind("it were {} N m s", 1, _slowed),
    "resistance's size": _of_factor(
        "drag were {} times as strong", "there were no drag", "drag had the other sign"
    ),
    "decay": Kind("L were {} /s", 1, _slowed),
    "decay for drag": Kind("L were {} /s, in place of the drag", 1, _slowed),
    "drag's law": Kind("drag were {}", 2, _power),
    "drag along each axis": Kind("the drag along the body's axes were {} N m s", 3, _fitted_vector),
    "drag of ω in the world": Kind("the drag along body axes were against ω along world axes"),
    "drag turned back": Kind("the drag along world axes were against ω along body axes"),
    "braking": Kind("the com's velocity were {} /s", 1, _slowed),
    "decay and braking": Kind("L and the com's velocity were {} /s", 1, _slowed),
    "decays": Kind("L were slowed by {} /s", 2, _decays),
    "torque's size": _of_factor(
        "the torque were {} times as strong",
        "there were no torque",
        "the torque had the other sign",
    ),
    "torque along other axes": Kind("the torque were constant along the other axes"),
    "torque along body axes": Kind(_BESIDES + "body axes", 3),
    "torque along world axes": Kind(_BESIDES + "world axes", 3),
    "gravity gradient": Kind("a gravity gradient of {} acted besides", 4, _gradient),
    "gravity gradient along other axes": Kind(
        "a gravity gradient of {} acted besides", 5, _gradient_tensor
    ),
    "torque by attitude": Kind("a torque by the attitude, {} besides", 9, _by_attitude),
    "tilt": Kind("gravity is tilted by {}", 4, _tilted),
    "spring": Kind("a spring of {}", 5, _by_angle),
    "turning besides": Kind(
        "it turns as if ω were larger by {} rad/s, along body axes",
        *(3, _fitted_vector),
        is_kinematic=True,
    ),
    "world turning": Kind(
        "it turns as if the world turned by {} rad/s", 3, _fitted_vector, is_kinematic=True
    ),
    # How states are set and read.
    "times": _of_factor("samples were {} times as far apart as their times"),
    "step": _of_factor("a step took {} timesteps"),
    "omega": _of_factor("ω were read multiplied by {}"),
    "velocity": _of_factor("the velocity were read multiplied by {}"),
    "scalar last": Kind("the quaternion were read as x, y, z, w"),
    "scalar first": Kind("the quaternion's last component were taken for its first"),
    "conjugated": Kind("the quaternion were read conjugated"),
    "ω in the world": Kind("ω were read along the world's axes"),
    "ω turned twice": Kind("ω were turned from world to body axes once more than it needs"),
    "ω reversed": Kind("ω were read with the opposite sign"),
    "late state": Kind("the state were read as it was before the step"),
    "late attitude": Kind("the attitude were read as it was before the step"),
    "late ω": Kind("ω were read as it was before the step"),
    "first step": Kind(
        "the first step from a given state were another than the next: a reading is late by part "
        "of a step, or the step before is remembered"
    ),
    "24 bits": Kind("the state were held in 24 bits, as in single precision"),
}
