"""The changes of a scene's equations of motion that may explain a motion computed wrongly.

A change with k > 0 parameters changes nothing if these are zero, and they are fitted. A change
without parameters sets terms of the equations to given values. The same changes explain the gains
of an engine's steps, and recorded motions.
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

#: Conventions of Euler angles, whose rates may be confused with ω: the indices of the axes of the
#: three intrinsic rotations, in their order. The rates are in the order x, y, z if all three axes
#: differ, and else in the order of the rotations. The convention zxz is left out, as its angles
#: have the same rates as those of zyz.
EULER_ANGLES = (*permutations(range(3)), (2, 1, 2))
#: Which components of a vector are taken for its x, y and z: 1 to 3, negative for the other sign.
#: The vector itself and its negative are left out.
OTHER_COMPONENTS = [
    [sign * (axis + 1) for sign, axis in zip(signs, axes, strict=True)]
    for axes in permutations(range(3))
    for signs in product((1, -1), repeat=3)
    if abs(sum(signs)) < 3 or axes != (0, 1, 2)
]


def changes(scenario: Scenario) -> Iterator[Change]:
    """All changes of a scene's equations of motion, the more specific ones first."""
    equations = equations_of(scenario)
    yield from _of_kinematics()
    yield from _of_gyroscopic_torque(scenario, equations)
    # Changes of effects come before other tensors: a tensor so large that drag or a torque hardly
    # acts on the body explains the same motion.
    yield from of_effects(scenario, equations)
    for kind, numbers, tensor in other_tensors(scenario):
        yield set_to(kind, numbers, **_body(tensor))
    yield set_to("inverse for the tensor", **_body(equations.inverse))
    yield from _of_fitted_tensors(scenario, equations)


def _body(tensor: FloatArray) -> dict[str, Any]:
    """The terms of the equations of motion, by name, that a tensor of inertia, kg m², makes."""
    return {"inertia": tensor, "inverse": inverse(tensor), "gyroscopic": tensor}


def _of_kinematics() -> Iterator[Change]:
    """Changes of how the attitude follows from ω."""
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
    """Changes of the gyroscopic torque ω × Gω, and of the axes along which tensors are constant.

    Changes of the angular momentum of rotors, and of the inverse tensor, are among them.
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
        # The axial moments of parts on free hinges are left out of the tensor that multiplies ω'.
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
    # As ω × (c ω) is zero, G is known only up to a multiple of the identity. The G that is nearest
    # to I, which has the same trace, is fitted.
    yield _with_trace(
        "gyroscopic tensor",
        inertia,
        lambda h, G: h.of(gyroscopic=G),
        lambda h, _: is_of_a_body(h.gyroscopic),
    )


def _of_fitted_tensors(scenario: Scenario, e: OtherEquations) -> Iterator[Change]:
    """Changes that fit the tensor of inertia or a part of it, the com, or the lever."""
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
    """Whether the tensor of inertia of a hypothesis is that of a rigid body."""
    return is_of_a_body(h.inertia)


def _with_moments(axes: FloatArray, h: Hypothesis, moments: FloatArray) -> Hypothesis:
    """Return H hypotheses with principal moments, kg m², (H, 3), about given axes, (3, 3)."""
    return h.with_inertia((axes * moments[:, None]) @ axes.T)


def _scaled_tensor(h: Hypothesis, n: FloatArray) -> Hypothesis:
    """Return H hypotheses with the tensors of inertia times 1 + n, (H, 1)."""
    return h.with_inertia((1 + n[:, :, None]) * h.inertia)


def _with_entry(e: OtherEquations, at: int) -> Change:
    """The change of one entry of the tensor, as by a misprint; `at` is its index in `ENTRIES`."""
    entries, unit = tensor_entries(e.inertia), np.eye(6)[at]

    def changed(h: Hypothesis, n: FloatArray) -> Hypothesis:
        return h.with_inertia(tensors_of_entries(entries + n * unit))

    return Change(
        "entry", changed, np.array([mean_moment(e)]), lambda n: (at, entries[at] + n[0], n[0])
    )


def _rotated_tensor(h: Hypothesis, turn: FloatArray) -> Hypothesis:
    """Return H hypotheses with the tensors turned by rotation vectors, rad, (H, 3)."""
    R = Rotation.from_rotvec(turn).as_matrix()
    return h.with_inertia(R @ h.inertia @ np.swapaxes(R, 1, 2))


def tensor(e: OtherEquations) -> Change:
    """The change that fits the whole tensor, with a fixed trace if no torque shows its scale."""
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
    """The change that fits a tensor with a fixed trace, by the deviations of all entries but Ixx.

    Parameters
    ----------
    nominal : the tensor without the change, kg m², (3, 3)
    apply : puts changed tensors, (H, 3, 3), into H hypotheses
    kind, is_possible : as in `Change`
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
    """Whether torques, drag, rotors or a table let a motion show the scale of the tensor."""
    pulled = e.pull.any() and e.gravity_world.any()
    pushed = e.torque.any() or e.torque_world.any() or e.slowing.any() or e.kept.any()
    return bool(pulled or pushed or e.mobility)
