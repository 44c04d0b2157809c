"""Changes of a scene's equations of motion, as mistakes in an engine or in a scene may cause them.

A change may have parameters, which are fitted to data. With parameters of zero it changes nothing.
A change without parameters sets terms of the equations to given values. The same changes are tried
as explanations of the gains of an engine's steps and of recorded motions.
"""

from collections.abc import Callable, Iterator
from functools import partial
from itertools import permutations, product
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from ....reference.other_equations import (
    FIRST_ANGLES,
    WORLD,
    OtherEquations,
    equations_of,
    inverse,
)
from ....scenarios import FloatArray, Scenario
from ....scenarios.rotation import matrix
from ...results.change_words import UP_TO_A_FACTOR
from .effect_changes import com, lever, mean_moment, of_effects, of_momentum
from .hypothesis import Change, Hypothesis, factors, fitted, set_to
from .other_tensors import (
    about_conjugated_axes,
    is_of_a_body,
    other_tensors,
    tensor_entries,
    tensors_of_entries,
    with_products,
    without_rotation,
)

#: Conventions of Euler angles, for the mistake of taking ω for the rates of such angles: the
#: indices of the axes of three intrinsic rotations, in their order. If all three axes differ, ωx,
#: ωy and ωz are taken for the rates of the angles about x, y and z; else for the rates of the
#: first, second and third angle. The convention zxz is left out, as its angles have the same rates
#: as those of zyz.
EULER_ANGLES = (*permutations(range(3)), (2, 1, 2))
#: Mistaken orders and signs of a vector's components. The three numbers say which component, 1 to
#: 3, is taken for x, for y and for z; a negative number means the component with the other sign.
#: The vector itself and its negative are left out.
OTHER_COMPONENTS = [
    [sign * (axis + 1) for sign, axis in zip(signs, axes, strict=True)]
    for axes in permutations(range(3))
    for signs in product((1, -1), repeat=3)
    if abs(sum(signs)) < 3 or axes != (0, 1, 2)
]


def changes(scenario: Scenario) -> Iterator[Change]:
    """Yield the changes of a scene's equations that may explain a motion, specific ones first."""
    equations = equations_of(scenario)
    yield from _of_kinematics()
    yield from _of_gyroscopic_torque(scenario, equations)
    # Changes of effects come before other tensors. If an engine leaves out drag or a torque, a
    # tensor so large that this effect hardly matters explains the same motion.
    yield from of_effects(scenario, equations)
    for kind, numbers, tensor in other_tensors(scenario):
        yield set_to(kind, numbers, **_body(tensor))
    yield set_to("inverse for the tensor", **_body(equations.inverse))
    yield from _of_fitted_tensors(scenario, equations)


def _body(tensor: FloatArray) -> dict[str, Any]:
    """Return what a tensor of inertia sets in `OtherEquations`, by the names of the attributes.

    These are `inertia` and `gyroscopic`, the tensor itself, and `inverse`, its inverse.

    Parameters
    ----------
    tensor : kg m², (3, 3)
    """
    return {"inertia": tensor, "inverse": inverse(tensor), "gyroscopic": tensor}


def _of_kinematics() -> Iterator[Change]:
    """Yield changes of how the attitude follows from ω."""
    yield set_to("wrong side", kinematics=WORLD)
    yield set_to("wrong side, no ½", kinematics=WORLD, turning=2 * np.eye(3))
    yield set_to("wrong side, reversed", kinematics=WORLD, turning=-np.eye(3))
    yield from factors("turning", 2.0, 0.5, -1.0, turning=np.eye(3))
    for shown in OTHER_COMPONENTS:
        turning = np.sign(shown)[:, None] * np.eye(3)[np.abs(shown) - 1]
        yield set_to("other components", shown, turning=turning)
    for i, j, k in EULER_ANGLES:
        yield set_to("Euler rates", (i, j, k), kinematics=FIRST_ANGLES + 9 * i + 3 * j + k)
    yield fitted(
        "turning along other axes",
        *(np.zeros(3), 1.0),
        lambda h, n: h.of(turning=Rotation.from_rotvec(n).as_matrix()),
    )
    yield fitted(
        "turning by a matrix",
        *(np.eye(3).ravel(), 1.0),
        lambda h, n: h.of(turning=n.reshape(-1, 3, 3)),
    )


def _of_gyroscopic_torque(scenario: Scenario, e: OtherEquations) -> Iterator[Change]:
    """Yield changes of the gyroscopic torque ω × (G ω + h), and of how the tensor of inertia turns.

    G is the tensor of inertia in this torque, and h the angular momentum of rotors; some changes
    are of h alone. One change takes a wrong inverse of the tensor. Others keep the tensor constant
    along world axes, although it turns with the body.

    Parameters
    ----------
    e : the scene's own equations
    """
    inertia, of_com = e.inertia, np.array(scenario.body.inertia_com)
    yield set_to("gyroscopic", (1.0,), gyroscopic=0 * inertia, kept=0 * e.kept)
    if scenario.constraint.is_pivot:
        yield set_to("gyroscopic", (1.0,), gyroscopic=inertia - of_com)
        yield set_to("gyroscopic about the com", gyroscopic=of_com)
    if e.kept.any():
        yield set_to("no gyroscopic torque of the body", gyroscopic=0 * inertia)
        yield from of_momentum(e)
        body = scenario.body
        of_all = np.array(body.inertia_origin if scenario.about == "pivot" else body.inertia_com)
        # The tensor that multiplies ω' lacks the axial moments of rotors on free hinges.
        if (of_all != inertia).any():
            yield set_to("spins left out", gyroscopic=of_all, kept=0 * e.kept)
        yield from factors("gyroscopic, with parts", gyroscopic=inertia, kept=e.kept)
    yield from factors("gyroscopic", sign=-1.0, gyroscopic=inertia)
    for kind, tensors in (
        ("gyroscopic of the diagonal", [with_products(inertia, 0.0)]),
        ("gyroscopic of other products", [with_products(inertia, -1.0)]),
        ("gyroscopic without rotation", without_rotation(inertia)),
        ("gyroscopic about conjugated axes", about_conjugated_axes(inertia)),
    ):
        for tensor in tensors:
            yield set_to(kind, gyroscopic=tensor)
    yield set_to("inverse of the diagonal", inverse=np.diag(1 / np.diag(inertia)))
    R = matrix(scenario.start.q_world_body_wxyz)
    for kind, tensor in (
        ("tensor as at the start", R @ inertia @ R.T),
        ("tensor along the world", inertia),
    ):
        terms = {**_body(tensor), "tensor_turns": 1}
        yield set_to(kind, **terms)
        yield set_to(f"{kind}, not gyroscopic", **{**terms, "gyroscopic": 0 * inertia})
    yield set_to("tensor turned on", tensor_turns=2)
    # As ω × (c ω) is zero, a motion shows G only up to a multiple of the identity. So the trace of
    # G stays that of I.
    yield _with_trace(
        "gyroscopic tensor",
        inertia,
        lambda h, G: h.of(gyroscopic=G),
        lambda h, _: is_of_a_body(h.gyroscopic),
    )


def _of_fitted_tensors(scenario: Scenario, e: OtherEquations) -> Iterator[Change]:
    """Yield changes that fit the tensor of inertia or some of its entries, the com, or the lever.

    The lever is mass times com in the torque of gravity.

    Parameters
    ----------
    e : the scene's own equations
    """
    moments, axes = np.linalg.eigh(e.inertia)
    size, how = mean_moment(e), "" if is_scaled(e) else UP_TO_A_FACTOR
    if is_scaled(e):
        yield Change("tensor's size", _scaled_tensor, np.ones(1))
    yield from com(scenario, e)
    yield from lever(e)
    yield from (_with_entry(e, at) for at in range(6))
    for kind, nominal, frame in ("moments", moments, axes), ("box", np.diag(e.inertia), np.eye(3)):
        yield fitted(f"{kind}{how}", nominal, size, partial(_with_moments, frame), has_tensor)
    yield fitted("rotated tensor", np.zeros(3), 1.0, _rotated_tensor)
    yield tensor(e)


def has_tensor(h: Hypothesis, _: FloatArray) -> bool:
    """Return whether a rigid body can have the tensor of inertia of one hypothesis `h`.

    `_`, the parameters of the change, is not used: every `Change.is_possible` is called with them.
    """
    return is_of_a_body(h.inertia)


def _with_moments(axes: FloatArray, h: Hypothesis, moments: FloatArray) -> Hypothesis:
    """Return H hypotheses `h` whose tensors are set to given principal axes and moments of inertia.

    Parameters
    ----------
    axes : the axes, as orthonormal columns, (3, 3)
    moments : kg m², (H, 3)
    """
    return h.with_inertia((axes * moments[:, None]) @ axes.T)


def _scaled_tensor(h: Hypothesis, n: FloatArray) -> Hypothesis:
    """Return H hypotheses with their tensors of inertia multiplied by 1 + n.

    Parameters
    ----------
    n : (H, 1)
    """
    return h.with_inertia((1 + n[:, :, None]) * h.inertia)


def _with_entry(e: OtherEquations, at: int) -> Change:
    """Return the change that adds a fitted number to one entry of the tensor of inertia.

    Parameters
    ----------
    e : the scene's own equations, which have the tensor without the change
    at : index of the entry in Ixx, Iyy, Izz, Ixy, Ixz, Iyz
    """
    entries, unit = tensor_entries(e.inertia), np.eye(6)[at]

    def changed(h: Hypothesis, n: FloatArray) -> Hypothesis:
        return h.with_inertia(tensors_of_entries(entries + n * unit))

    return Change(
        "entry", changed, np.array([mean_moment(e)]), lambda n: (at, entries[at] + n[0], n[0])
    )


def _rotated_tensor(h: Hypothesis, turn: FloatArray) -> Hypothesis:
    """Return H hypotheses with their tensors of inertia turned.

    Parameters
    ----------
    turn : rotation vectors, rad, (H, 3)
    """
    R = Rotation.from_rotvec(turn).as_matrix()
    return h.with_inertia(R @ h.inertia @ np.swapaxes(R, 1, 2))


def tensor(e: OtherEquations) -> Change:
    """Return the change that fits the whole tensor of inertia.

    If the motion does not show the tensor's scale, its trace stays as it is.

    Parameters
    ----------
    e : the scene's own equations, which have the tensor without the change
    """
    if not is_scaled(e):
        of_body = Hypothesis.with_inertia, has_tensor
        return _with_trace(f"tensor{UP_TO_A_FACTOR}", e.inertia, *of_body)
    entries = tensor_entries(e.inertia)
    return fitted(
        "tensor",
        *(entries, mean_moment(e)),
        lambda h, n: h.with_inertia(tensors_of_entries(n)),
        has_tensor,
    )


def _with_trace(
    kind: str,
    nominal: FloatArray,
    apply: Callable[[Hypothesis, FloatArray], Hypothesis],
    is_possible: Callable[[Hypothesis, FloatArray], bool],
) -> Change:
    """Return the change that fits a tensor whose trace stays as it is.

    Its parameters are the deviations of all entries but Ixx, which follows from the trace.

    Parameters
    ----------
    kind : name of the kind of change
    nominal : the tensor without the change, kg m², (3, 3)
    apply : returns H hypotheses in which the tensor is replaced by given ones, (H, 3, 3)
    is_possible : returns whether a mistake can have led to a hypothesis with given parameters
    """
    entries = tensor_entries(nominal)

    def changed(n: FloatArray) -> FloatArray:
        of_xx = -n[..., :2].sum(axis=-1, keepdims=True)
        return np.asarray(entries + np.concatenate([of_xx, n], axis=-1))

    sizes = np.full(5, float(np.trace(nominal)) / 3)

    def with_tensor(h: Hypothesis, n: FloatArray) -> Hypothesis:
        return apply(h, tensors_of_entries(changed(n)))

    return Change(kind, with_tensor, sizes, changed, is_possible)


def is_scaled(e: OtherEquations) -> bool:
    """Return whether torques, drag, rotors or a table let a motion show the scale of the tensor.

    The motion of a body that turns freely shows only ratios of its moments of inertia.

    Parameters
    ----------
    e : the equations of the motion
    """
    pulled = e.pull.any() and e.gravity_world.any()
    pushed = e.torque.any() or e.torque_world.any() or e.slowing.any() or e.kept.any()
    return bool(pulled or pushed or e.mobility)
