"""What may have been computed instead of a scene's exact motion: changes of its equations.

Each has k numbers, which are fitted; the equations are the scene's again where they are `none`.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import permutations, product
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from ....reference.other_equations import FIRST_ANGLES, WORLD, OtherEquations
from ....scenarios import FloatArray, Scenario
from ....scenarios.rotation import matrix

Apply = Callable[[OtherEquations, FloatArray], OtherEquations]
Words = Callable[[FloatArray], str]

AXES = "xyz"
#: Entries of a tensor, in the order in which they are listed everywhere.
ENTRIES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
#: Two tensors are one if no entry differs by more, relative to the largest.
SAME = 1e-9
PRINTED = 5
#: Axes of conventions, each turned with the body; where none comes twice, ω has the rate about x
#: first, then those about y and z. Of zxz the rates are those of zyz.
EULER_ANGLES = (*permutations(range(3)), (2, 1, 2))


@dataclass(frozen=True, eq=False)
class Change:
    """A change of the equations of motion.

    Attributes
    ----------
    words : says it of its numbers
    apply : makes it in equations, with its numbers
    none : the numbers that change nothing, (k,)
    sizes : of changes of the numbers that are neither small nor large, (k,)
    is_kinematic : whether it is one of how the attitude follows ω
    """

    words: Words
    apply: Apply
    none: FloatArray = field(default_factory=lambda: np.empty(0))
    sizes: FloatArray = field(default_factory=lambda: np.empty(0))
    is_kinematic: bool = False


def changes(scenario: Scenario, equations: OtherEquations) -> Iterator[Change]:
    """Every change that is looked for, those that say more before those that say less."""
    yield from _of_kinematics()
    yield from _of_gyroscopic_torque(scenario, equations)
    yield from _of_parts(equations)
    yield from _of_known_tensors(scenario, equations)
    yield from _of_effects(scenario, equations)
    yield from _of_fitted_tensors(scenario, equations)


def _set(words: str, *, is_kinematic: bool = False, **numbers: Any) -> Change:
    """A change that has no numbers to fit."""
    return Change(
        lambda _: words,
        lambda e, _: e._replace(**numbers),
        is_kinematic=is_kinematic,
    )


def _of_body(tensor: FloatArray) -> dict[str, Any]:
    """The numbers of equations that are a body's with this tensor."""
    return {"inertia": tensor, "inverse": np.linalg.inv(tensor), "gyroscopic": tensor}


def _factor(words: str, apply: Callable[[OtherEquations, float], OtherEquations]) -> Change:
    """A change of a factor."""
    return Change(
        lambda n: words.format(f"{n[0]:.{PRINTED}g}"),
        lambda e, n: apply(e, float(n[0])),
        np.ones(1),
        np.ones(1),
    )


def _of_kinematics() -> Iterator[Change]:
    side = "q' = ½ ω q, as if ω were along world axes: the product is on the wrong side"
    kinematic = partial(_set, is_kinematic=True)
    yield kinematic(side, kinematics=WORLD)
    yield kinematic(
        "q' = ω q, without the ½, and on the wrong side", kinematics=WORLD, turning=2 * np.eye(3)
    )
    yield kinematic("q' = q ω, without the ½", turning=2 * np.eye(3))
    yield kinematic("q' = ¼ q ω, with the ½ twice", turning=np.eye(3) / 2)
    yield kinematic("q' = −½ q ω, with the other sign", turning=-np.eye(3))
    yield kinematic(
        "q' = −½ ω q, with the other sign, and on the wrong side",
        kinematics=WORLD,
        turning=-np.eye(3),
    )
    for axes in permutations(range(3)):
        for signs in product((1, -1), repeat=3):
            M = np.array(signs)[:, None] * np.eye(3)[list(axes)]
            if not np.array_equal(np.abs(M), np.eye(3)) or abs(sum(signs)) != 3:
                names = ", ".join(
                    f"{'−' if sign < 0 else ''}ω{AXES[axis]}"
                    for sign, axis in zip(signs, axes, strict=True)
                )
                yield kinematic(f"it turns as if ω were [{names}]", turning=M)
    for i, j, k in EULER_ANGLES:
        of_angles = f"ω is taken for the rates of Euler angles {AXES[i]}{AXES[j]}{AXES[k]}"
        yield kinematic(of_angles, kinematics=FIRST_ANGLES + 9 * i + 3 * j + k)
    yield Change(
        lambda n: f"it turns {n[0]:.{PRINTED}g} times as fast as ω says",
        lambda e, n: e._replace(turning=n[0] * np.eye(3)),
        *(np.ones(1), np.ones(1)),
        is_kinematic=True,
    )
    yield Change(
        lambda n: f"it turns as if ω were along axes turned by {_degrees(n)}",
        lambda e, n: e._replace(turning=Rotation.from_rotvec(n).as_matrix()),
        *(np.zeros(3), np.ones(3)),
        is_kinematic=True,
    )
    yield Change(
        lambda n: f"it turns as if ω were multiplied by {_rows(n.reshape(3, 3))}",
        lambda e, n: e._replace(turning=n.reshape(3, 3).copy()),
        *(np.eye(3).ravel(), np.ones(9)),
        is_kinematic=True,
    )


def _of_gyroscopic_torque(scenario: Scenario, e: OtherEquations) -> Iterator[Change]:
    inertia = e.inertia
    of_com = np.array(scenario.body.inertia_com)
    yield _set("there were no gyroscopic torque", gyroscopic=0 * inertia, kept=0 * e.kept)
    if e.kept.any():
        yield _set("there were no gyroscopic torque ω × Iω of the body", gyroscopic=0 * inertia)
    if scenario.constraint.is_pivot:
        yield _set("there were no gyroscopic torque", gyroscopic=inertia - of_com)
        yield _set(
            "the gyroscopic torque were ω × Iω with the tensor about the com", gyroscopic=of_com
        )
    for words, of_parts in (
        ("the gyroscopic torque ω × Iω were {} times as strong", False),
        ("the gyroscopic torque ω × (Iω + h) were {} times as strong", True),
    ):
        if e.kept.any() or not of_parts:
            yield _factor(words, partial(_scaled_gyroscopic, of_parts))
    along_axes = list(_in_other_axes(inertia, is_conjugated=False))
    conjugated = list(_in_other_axes(inertia, is_conjugated=True))
    for words, tensors in (
        ("the tensor's diagonal alone", [_products(inertia, 0.0)]),
        ("the tensor with its products of inertia of the other sign", [_products(inertia, -1.0)]),
        ("the principal moments as if they were along the body's axes", along_axes),
        ("the tensor about conjugated principal axes", conjugated),
    ):
        for tensor in tensors:
            yield _set(f"the gyroscopic torque ω × Iω were of {words}", gyroscopic=tensor)
    inverse = np.diag(1 / np.diag(inertia))
    yield _set(
        "ω' were of the tensor's diagonal alone, though ω × Iω is of all of it", inverse=inverse
    )
    R = matrix(scenario.start.q_world_body_wxyz)
    started = R @ inertia @ R.T
    for words, tensor in (
        ("the tensor did not turn with the body: as it is at the start, in world axes", started),
        ("the tensor were along world axes, and did not turn with the body", inertia),
    ):
        yield _set(words, **_of_body(tensor), in_world=True)
    yield Change(
        partial(_other_gyroscopic, float(np.trace(inertia))),
        lambda e, n: e._replace(gyroscopic=_symmetric(n)),
        _entries(inertia),
        np.full(6, float(np.trace(inertia)) / 3),
    )


def _other_gyroscopic(trace: float, n: FloatArray) -> str:
    # ω × cω is zero: G is known up to a multiple of 1, and has the trace of I here.
    G = _symmetric(n)
    G += (trace - np.trace(G)) / 3 * np.eye(3)
    return f"the gyroscopic torque ω × Gω were with G: {_tensor(G)}, not I"


def _scaled_gyroscopic(of_parts: bool, e: OtherEquations, factor: float) -> OtherEquations:
    return e._replace(
        gyroscopic=factor * e.gyroscopic, kept=factor * e.kept if of_parts else e.kept
    )


def _of_parts(e: OtherEquations) -> Iterator[Change]:
    if e.kept.any():
        yield _set("the rotors' torque ω × h had the other sign", kept=-e.kept)
        yield _set("there were no rotors' torque ω × h", kept=0 * e.kept)
        yield _factor(
            "the rotors' torque ω × h were {} times as strong",
            lambda e, factor: e._replace(kept=factor * e.kept),
        )


def _of_known_tensors(scenario: Scenario, e: OtherEquations) -> Iterator[Change]:
    """Tensors that are made of the scene's by a mistake, each once."""
    seen = [e.inertia]
    for words, tensor in _known_tensors(scenario):
        is_new = all(np.abs(tensor - other).max() > SAME * np.abs(other).max() for other in seen)
        if is_new and np.linalg.eigvalsh(tensor)[0] > 0:
            seen.append(tensor)
            yield _set(words, **_of_body(tensor))


def _known_tensors(scenario: Scenario) -> Iterator[tuple[str, FloatArray]]:
    body, about_pivot = scenario.body, scenario.about == "pivot"
    of_com, of_origin = np.array(body.inertia_com), np.array(body.inertia_origin)
    # What the pivot adds, and rotors that turn freely take away.
    added = np.array(scenario.inertia) - of_com
    yield "the products of inertia had the other sign", _products(of_com, -1.0) + added
    yield "there were no products of inertia", _products(of_com, 0.0) + added
    for tensor in _in_other_axes(of_com, is_conjugated=True):
        yield "the tensor were about conjugated principal axes", tensor + added
    for tensor in _in_other_axes(of_com, is_conjugated=False):
        words = "the principal moments were along the body's axes, without the tensor's rotation"
        yield words, tensor + added
    if about_pivot:
        yield (
            "the tensor about the com were that about the pivot",
            of_com + added - (of_origin - of_com),
        )
        yield "the tensor about the pivot were the one about the com twice moved", added + of_origin
    else:
        yield "the tensor were about the origin instead of the com", of_origin + added
        yield (
            "the tensor about the com had been moved from the origin once more",
            2 * of_com - of_origin + added,
        )
    moments, axes = np.linalg.eigh(of_com)
    for order in list(permutations(range(3)))[1:]:
        permuted = (axes * moments[list(order)]) @ axes.T
        yield (
            f"the principal moments were permuted, {_vector(moments[list(order)])} kg m² along the "
            f"axes of {_vector(moments)}",
            permuted + added,
        )
    for order in list(permutations(range(3)))[1:]:
        names = "".join(AXES[axis] for axis in order)
        yield (
            f"the tensor's rows and columns were those of the axes {names}",
            of_com[np.ix_(order, order)] + added,
        )
    for signs in product((1.0, -1.0), repeat=3):
        flipped = of_com.copy()
        for sign, (i, j) in zip(signs, ENTRIES[3:], strict=True):
            flipped[i, j] *= sign
            flipped[j, i] = flipped[i, j]
        names = " and ".join(
            f"I{AXES[i]}{AXES[j]}"
            for sign, (i, j) in zip(signs, ENTRIES[3:], strict=True)
            if sign < 0
        )
        yield f"{names} had the other sign", flipped + added
    yield "the tensor were that of a sphere", np.eye(3) * moments.mean() + added


def _in_other_axes(tensor: FloatArray, is_conjugated: bool) -> Iterator[FloatArray]:
    """The tensor's moments along the body's axes, or about axes that are turned the other way.

    Which of its principal axes comes first, and in which direction it points, is anyone's choice.
    """
    moments, axes = np.linalg.eigh(tensor)
    for order in permutations(range(3)):
        if not is_conjugated:
            yield np.diag(moments[list(order)])
            continue
        for signs in ((1, 1, 1), (1, 1, -1), (1, -1, 1), (-1, 1, 1)):
            R = axes[:, list(order)] * np.array(signs)
            yield R.T @ np.diag(moments[list(order)]) @ R


def _of_effects(scenario: Scenario, e: OtherEquations) -> Iterator[Change]:
    size = float(np.trace(e.inertia)) / 3
    rate = _fastest(scenario, e)
    if e.gravity_world.any() and not scenario.constraint.is_free:
        g = e.gravity_world
        yield _set("there were no gravity", gravity_world=0 * g)
        yield _set("gravity were turned round", gravity_world=-g)
        yield _factor(
            "gravity were {} times as strong", lambda e, n: e._replace(gravity_world=n * g)
        )
    for name, torque in (("torque", e.torque), ("torque_world", e.torque_world)):
        if torque.any():
            none: Any = {name: 0 * torque}
            opposite: Any = {name: -torque}
            yield _set("there were no torque", **none)
            yield _set("the torque had the other sign", **opposite)
    if e.torque.any() or e.torque_world.any():
        yield _set(
            "the torque were constant along the other axes",
            torque=e.torque_world,
            torque_world=e.torque,
        )
    if e.slowing[0]:
        yield _set("there were no drag", slowing=0 * e.slowing)
        yield _set("drag had the other sign", slowing=-e.slowing)
    yield resistance(scenario, e)
    yield Change(
        lambda n: f"L were {_slowed(n[0])} /s",
        lambda e, n: e._replace(slowing=e.slowing + np.array([0, n[0], 0])),
        np.zeros(1),
        np.full(1, rate),
    )
    yield Change(
        lambda n: f"L were slowed by {n[0]:.3g} {'-' if n[1] < 0 else '+'} {abs(n[1]):.3g} ‖ω‖ /s",
        lambda e, n: e._replace(slowing=e.slowing + np.array([0, n[0], n[1]])),
        np.zeros(2),
        np.array([rate, 1.0]),
    )
    if e.gravity_world.any() and not scenario.constraint.is_free:
        yield Change(
            lambda n: f"gravity were {_vector(n)} m/s²",
            lambda e, n: e._replace(gravity_world=n.copy()),
            e.gravity_world,
            np.full(3, float(np.linalg.norm(e.gravity_world))),
        )
    for axes, name in (("body", "torque"), ("world", "torque_world")):
        yield Change(
            partial(_torque_in_words, axes),
            partial(_pushed, name),
            np.zeros(3),
            np.full(3, size * rate**2),
        )


def _torque_in_words(axes: str, n: FloatArray) -> str:
    return f"a torque of {_vector(n)} N m acted besides, along {axes} axes"


def _pushed(name: str, e: OtherEquations, n: FloatArray) -> OtherEquations:
    torques: Any = {name: getattr(e, name) + n}
    return e._replace(**torques)


def _fastest(scenario: Scenario, e: OtherEquations) -> float:
    return e.rate or float(np.linalg.norm(scenario.start.omega_body)) or 1.0


def resistance(scenario: Scenario, e: OtherEquations) -> Change:
    """Drag, or more of it."""
    return Change(
        lambda n: f"it were {_slowed(n[0])} N m s",
        lambda e, n: e._replace(slowing=e.slowing + np.array([n[0], 0, 0])),
        np.zeros(1),
        np.full(1, float(np.trace(e.inertia)) / 3 * _fastest(scenario, e)),
    )


def com(scenario: Scenario, e: OtherEquations) -> Iterator[Change]:
    """The centre of mass, where a motion shows it: of a body on a pivot under gravity."""
    if scenario.constraint.is_pivot and e.gravity_world.any():
        place, mass = np.array(scenario.body.com), scenario.body.mass
        yield Change(
            lambda n: f"the com were at {_vector(n)} m",
            partial(_moved, place, mass),
            place,
            np.full(3, float(np.linalg.norm(place)) or 1.0),
        )


def _of_fitted_tensors(scenario: Scenario, e: OtherEquations) -> Iterator[Change]:
    """The tensor by its numbers: those that the motion shows, of a free body up to a factor."""
    moments, axes = np.linalg.eigh(e.inertia)
    size = float(moments.mean())
    up_to = "" if _is_scaled(e) else ", up to a factor"
    if not up_to:
        yield _factor(
            "the tensor were {} times as large", lambda e, n: e.with_inertia(n * e.inertia)
        )
    yield from com(scenario, e)
    yield Change(
        lambda n: f"the moments were {_vector(n)} kg m²{up_to}",
        lambda e, n: e.with_inertia((axes * n) @ axes.T),
        moments,
        np.full(3, size),
    )
    yield Change(
        lambda n: (
            f"the tensor were that of a box along the body's axes, with {_vector(n)} kg m²{up_to}"
        ),
        lambda e, n: e.with_inertia(np.diag(n)),
        np.diag(e.inertia).copy(),
        np.full(3, size),
    )
    yield Change(
        lambda n: f"the tensor were the same about axes turned by {_degrees(n)}",
        partial(_rotated, e.inertia),
        np.zeros(3),
        np.ones(3),
    )
    yield fitted_tensor(e)


def fitted_tensor(e: OtherEquations) -> Change:
    """The whole tensor; where the motion does not show its scale, of the scene's trace."""
    size = float(np.trace(e.inertia)) / 3
    if _is_scaled(e):
        return Change(
            lambda n: f"the tensor were {_tensor(_symmetric(n))}",
            lambda e, n: e.with_inertia(_symmetric(n)),
            _entries(e.inertia),
            np.full(6, size),
        )
    return Change(
        lambda n: f"the tensor were {_tensor(tensor_of(n, size))}, up to a factor",
        lambda e, n: e.with_inertia(tensor_of(n, size)),
        _entries(e.inertia)[1:],
        np.full(5, size),
    )


def tensor_of(numbers: FloatArray, size: float) -> FloatArray:
    """A tensor of all but its first entry, with a trace of 3 `size`."""
    return _symmetric([3 * size - numbers[0] - numbers[1], *numbers])


def _is_scaled(e: OtherEquations) -> bool:
    """Whether a torque acts that shows the scale of the tensor."""
    pulled = e.pull.any() and e.gravity_world.any()
    pushed = e.torque.any() or e.torque_world.any() or e.slowing.any() or e.kept.any()
    return bool(pulled or pushed or e.mobility)


def _rotated(inertia: FloatArray, e: OtherEquations, vector: FloatArray) -> OtherEquations:
    R = Rotation.from_rotvec(vector).as_matrix()
    return e.with_inertia(R @ inertia @ R.T)


def _moved(com: FloatArray, mass: float, e: OtherEquations, n: FloatArray) -> OtherEquations:
    steiner = [mass * (r @ r * np.eye(3) - np.outer(r, r)) for r in (com, n)]
    return e.with_inertia(e.inertia - steiner[0] + steiner[1])._replace(pull=mass * n)


def _products(tensor: FloatArray, factor: float) -> FloatArray:
    diagonal = np.diag(np.diag(tensor))
    return diagonal + factor * (tensor - diagonal)


def _entries(tensor: FloatArray) -> FloatArray:
    return np.array([tensor[i, j] for i, j in ENTRIES])


def _symmetric(numbers: Sequence[float] | FloatArray) -> FloatArray:
    xx, yy, zz, xy, xz, yz = numbers
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _slowed(number: float) -> str:
    return f"{'slowed' if number > 0 else 'sped up'} by {abs(number):.3g}"


def _degrees(vector: FloatArray) -> str:
    angle = float(np.linalg.norm(vector))
    return f"{np.degrees(angle):.4g}° about {_vector(vector / (angle or 1.0))}"


def _vector(numbers: FloatArray) -> str:
    # Of numbers that are zero but for rounding nothing is printed.
    small = 1e-12 * np.abs(numbers).max(initial=0.0)
    rounded = np.where(np.abs(numbers) > small, numbers, 0.0)
    return f"[{', '.join(f'{value:.{PRINTED}g}' for value in rounded)}]"


def _tensor(tensor: FloatArray) -> str:
    return f"Ixx, Iyy, Izz, Ixy, Ixz, Iyz = {_vector(_entries(tensor))} kg m²"


def _rows(M: FloatArray) -> str:
    return f"[{', '.join(map(_vector, M))}]"
