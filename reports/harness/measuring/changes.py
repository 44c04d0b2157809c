"""What may have been computed instead of a scene's exact motion, and how it may have been read.

Each change has k numbers, which are fitted; it changes nothing where they are zero. The same
changes explain what an engine's steps gain, and recorded motions.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import permutations, product
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from ....reference.other_equations import FIRST_ANGLES, WORLD, OtherEquations, equations_of
from ....scenarios import FloatArray, Scenario
from ....scenarios.rotation import matrix
from ...results.change_words import UP_TO_A_FACTOR
from ...results.evidence import Explanation
from .other_tensors import (
    about_conjugated_axes,
    other_tensors,
    tensor_entries,
    tensor_of_entries,
    with_products,
    without_rotation,
)

#: Axes of conventions of Euler angles, each turned with the body; where none comes twice, ω has the
#: rate about x first, then those about y and z. Of zxz the rates are those of zyz.
EULER_ANGLES = (*permutations(range(3)), (2, 1, 2))
#: Components that may be taken for those of a vector: 1 to 3, negative where the sign is the other.
#: The vector itself, and its negative, are none of them.
OTHER_COMPONENTS = [
    [sign * (axis + 1) for sign, axis in zip(signs, axes, strict=True)]
    for axes in permutations(range(3))
    for signs in product((1, -1), repeat=3)
    if abs(sum(signs)) < 3 or axes != (0, 1, 2)
]


class Hypothesis(NamedTuple):
    """What may have been computed, and how states of it are read.

    Attributes
    ----------
    equations : of motion
    start : by how much the first attitude is turned, a rotation vector, rad, and ω differs, rad/s,
        body axes, (6,)
    read, bias, lag : of ω is read `read` @ ω + `bias` − `lag` ω', rad/s; (3, 3), (3,) and s
    step : timesteps that a step takes
    velocity : factor by which the com's velocity is read too large
    braking : rate at which the com of a body without a pivot is slowed, 1/s
    """

    equations: OtherEquations
    start: FloatArray
    read: FloatArray
    bias: FloatArray
    lag: float = 0.0
    step: float = 1.0
    velocity: float = 1.0
    braking: float = 0.0

    def of(self, **numbers: Any) -> "Hypothesis":
        """A hypothesis in which some numbers of the equations are replaced by these."""
        return self._replace(equations=self.equations._replace(**numbers))

    def of_tensor(self, inertia: FloatArray) -> "Hypothesis":
        """A hypothesis in which the body has another tensor of inertia, kg m², (3, 3)."""
        return self._replace(equations=self.equations.with_inertia(inertia))


def as_it_is(scenario: Scenario) -> Hypothesis:
    """The scene's equations, with states that are read as they are."""
    return Hypothesis(equations_of(scenario), np.zeros(6), np.eye(3), np.zeros(3))


@dataclass(frozen=True, eq=False)
class Change:
    """A change of what is computed or read.

    Attributes
    ----------
    kind : of `KINDS`
    apply : makes it in a hypothesis, with its k numbers
    sizes : of its numbers where the change is neither small nor large, (k,)
    shown : the numbers of its kind, of those that are fitted
    """

    kind: str
    apply: Callable[[Hypothesis, FloatArray], Hypothesis]
    sizes: FloatArray
    shown: Callable[[FloatArray], Sequence[float] | FloatArray] = np.asarray

    def explanation(self, numbers: FloatArray) -> Explanation:
        """The change with fitted numbers, as it is stored and put in words."""
        return Explanation(self.kind, tuple(map(float, self.shown(numbers))))


def changes(scenario: Scenario) -> Iterator[Change]:
    """Every change of what is computed; the more specific ones come first."""
    base = as_it_is(scenario)
    yield from _of_kinematics()
    yield from _of_gyroscopic_torque(scenario, base.equations)
    for kind, numbers, tensor in other_tensors(scenario):
        yield _set(kind, numbers, **_body(tensor))
    yield from _of_effects(scenario, base.equations)
    yield from _of_fitted_tensors(scenario, base.equations)


def _set(kind: str, shown: Sequence[float] = (), **numbers: Any) -> Change:
    """A change that sets numbers of the equations to given values, with nothing to fit."""
    return Change(kind, lambda h, _: h.of(**numbers), np.empty(0), lambda _: shown)


def _fitted(
    kind: str,
    usual: FloatArray,
    size: float | FloatArray,
    apply: Callable[[Hypothesis, FloatArray], Hypothesis],
) -> Change:
    """A change of k numbers from the usual ones; `apply` takes those that there are."""
    sizes = np.broadcast_to(size, usual.shape).astype(float)
    return Change(kind, lambda h, n: apply(h, usual + n), sizes, lambda n: usual + n)


def _factor(kind: str, *wholes: float, sign: float = 1.0, **terms: FloatArray) -> Iterator[Change]:
    """Changes of terms by a factor: by whole factors, then by one that is fitted.

    Parameters
    ----------
    sign : of the kind's number where the factor is larger than one
    """
    for whole in wholes:
        numbers: Any = {name: whole * term for name, term in terms.items()}
        yield _set(kind, (sign * (whole - 1),), **numbers)
    yield Change(
        kind,
        lambda h, n: h.of(**{name: (1 + n[0]) * term for name, term in terms.items()}),
        np.ones(1),
        lambda n: sign * n,
    )


def _body(tensor: FloatArray) -> dict[str, Any]:
    """The tensors in the equations of motion of a body with this tensor of inertia."""
    return {"inertia": tensor, "inverse": np.linalg.inv(tensor), "gyroscopic": tensor}


def _of_kinematics() -> Iterator[Change]:
    yield _set("wrong side", kinematics=WORLD)
    yield _set("wrong side, no ½", kinematics=WORLD, turning=2 * np.eye(3))
    yield _set("wrong side, reversed", kinematics=WORLD, turning=-np.eye(3))
    yield from _factor("turning", 2.0, 0.5, -1.0, turning=np.eye(3))
    for shown in OTHER_COMPONENTS:
        turning = np.sign(shown)[:, None] * np.eye(3)[np.abs(shown) - 1]
        yield _set("other components", shown, turning=turning)
    for i, j, k in EULER_ANGLES:
        yield _set("Euler rates", (i, j, k), kinematics=FIRST_ANGLES + 9 * i + 3 * j + k)
    yield _fitted(
        "turning along other axes",
        *(np.zeros(3), 1.0),
        lambda h, n: h.of(turning=Rotation.from_rotvec(n).as_matrix()),
    )
    yield _fitted(
        "turning by a matrix",
        *(np.eye(3).ravel(), 1.0),
        lambda h, n: h.of(turning=n.reshape(3, 3)),
    )


def _of_gyroscopic_torque(scenario: Scenario, e: OtherEquations) -> Iterator[Change]:
    inertia, of_com = e.inertia, np.array(scenario.body.inertia_com)
    yield _set("gyroscopic", (1.0,), gyroscopic=0 * inertia, kept=0 * e.kept)
    if scenario.constraint.is_pivot:
        yield _set("gyroscopic", (1.0,), gyroscopic=inertia - of_com)
        yield _set("gyroscopic about the com", gyroscopic=of_com)
    if e.kept.any():
        yield _set("no gyroscopic torque of the body", gyroscopic=0 * inertia)
        yield from _factor("momentum", 0.0, -1.0, kept=e.kept)
        yield from _factor("gyroscopic, with parts", gyroscopic=inertia, kept=e.kept)
    yield from _factor("gyroscopic", sign=-1.0, gyroscopic=inertia)
    for kind, tensors in (
        ("gyroscopic of the diagonal", [with_products(inertia, 0.0)]),
        ("gyroscopic of other products", [with_products(inertia, -1.0)]),
        ("gyroscopic without rotation", without_rotation(inertia)),
        ("gyroscopic about conjugated axes", about_conjugated_axes(inertia)),
    ):
        for tensor in tensors:
            yield _set(kind, gyroscopic=tensor)
    yield _set("inverse of the diagonal", inverse=np.diag(1 / np.diag(inertia)))
    R = matrix(scenario.start.q_world_body_wxyz)
    for kind, tensor in (
        ("tensor as at the start", R @ inertia @ R.T),
        ("tensor along the world", inertia),
    ):
        terms = {**_body(tensor), "in_world": True}
        yield _set(kind, **terms)
        yield _set(f"{kind}, not gyroscopic", **{**terms, "gyroscopic": 0 * inertia})
    # ω × cω is zero: G is known up to a multiple of 1.
    yield _with_trace("gyroscopic tensor", inertia, lambda h, G: h.of(gyroscopic=G))


def _of_effects(scenario: Scenario, e: OtherEquations) -> Iterator[Change]:
    # Of a free body a recording does not show gravity, and an engine's steps do.
    if e.gravity_world.any():
        yield from _factor("gravity's size", 0.0, -1.0, gravity_world=e.gravity_world)
    yield from resistance(scenario, e)
    rate, none = _fastest(scenario, e), np.zeros(3)
    yield _fitted("decay", none[:1], rate, lambda h, n: _slowed(h, 0.0, n[0]))
    yield _fitted(
        "decays",
        *(none[:2], np.array([rate, 1.0])),
        lambda h, n: _slowed(h, 0.0, *n),
    )
    if e.torque.any() or e.torque_world.any():
        pushes: dict[str, Any] = {"torque": e.torque, "torque_world": e.torque_world}
        yield from _factor("torque's size", 0.0, -1.0, **pushes)
        along_other_axes: dict[str, Any] = {"torque": e.torque_world, "torque_world": e.torque}
        yield _set("torque along other axes", **along_other_axes)
    if e.slowing[0]:
        yield from _factor("resistance's size", 0.0, -1.0, slowing=e.slowing)
    if e.gravity_world.any():
        size = float(np.linalg.norm(e.gravity_world))
        yield _fitted("gravity", e.gravity_world, size, lambda h, g: h.of(gravity_world=g))
    size = _size(e) * rate**2
    for kind, name in (
        ("torque along body axes", "torque"),
        ("torque along world axes", "torque_world"),
    ):
        yield _fitted(kind, none, size, partial(_pushed, name))


def _pushed(name: str, h: Hypothesis, torque: FloatArray) -> Hypothesis:
    return h.of(**{name: getattr(h.equations, name) + torque})


def _slowed(h: Hypothesis, c: float, a: float = 0.0, b: float = 0.0) -> Hypothesis:
    return h.of(slowing=h.equations.slowing + np.array([c, a, b]))


def resistance(scenario: Scenario, e: OtherEquations) -> Iterator[Change]:
    """A torque that opposes ω, beside the scene's own torques; one number is fitted."""
    size = _size(e) * _fastest(scenario, e)
    yield _fitted("resistance", np.zeros(1), size, lambda h, n: _slowed(h, n[0]))


def com(scenario: Scenario, e: OtherEquations) -> Iterator[Change]:
    """The centre of mass, where a motion shows it: of a body on a pivot under gravity."""
    if scenario.constraint.is_pivot and e.gravity_world.any():
        place, mass = np.array(scenario.body.com), scenario.body.mass

        def moved(h: Hypothesis, com: FloatArray) -> Hypothesis:
            here, there = (mass * (r @ r * np.eye(3) - np.outer(r, r)) for r in (place, com))
            return h.of_tensor(e.inertia - here + there).of(pull=mass * com)

        yield _fitted("com", place, float(np.linalg.norm(place)) or 1.0, moved)


def _of_fitted_tensors(scenario: Scenario, e: OtherEquations) -> Iterator[Change]:
    """Changes that fit the tensor of inertia; of a free body it is known up to a factor."""
    moments, axes = np.linalg.eigh(e.inertia)
    size, how = _size(e), "" if is_scaled(e) else UP_TO_A_FACTOR
    if is_scaled(e):
        yield Change("tensor's size", lambda h, n: h.of_tensor((1 + n[0]) * e.inertia), np.ones(1))
    yield from com(scenario, e)
    yield _fitted(f"moments{how}", moments, size, lambda h, n: h.of_tensor((axes * n) @ axes.T))
    yield _fitted(f"box{how}", np.diag(e.inertia), size, lambda h, n: h.of_tensor(np.diag(n)))

    def rotated(h: Hypothesis, turn: FloatArray) -> Hypothesis:
        R = Rotation.from_rotvec(turn).as_matrix()
        return h.of_tensor(R @ e.inertia @ R.T)

    yield _fitted("rotated tensor", np.zeros(3), 1.0, rotated)
    yield tensor(e)


def tensor(e: OtherEquations) -> Change:
    """Fits the whole tensor; where the motion does not show its scale, with the scene's trace."""
    if not is_scaled(e):
        return _with_trace(f"tensor{UP_TO_A_FACTOR}", e.inertia, Hypothesis.of_tensor)
    entries = tensor_entries(e.inertia)
    return _fitted("tensor", entries, _size(e), lambda h, n: h.of_tensor(tensor_of_entries(n)))


def _with_trace(
    kind: str, usual: FloatArray, apply: Callable[[Hypothesis, FloatArray], Hypothesis]
) -> Change:
    """Fits a tensor by five of its entries; the first follows from the trace, which is kept."""
    entries = tensor_entries(usual)

    def changed(n: FloatArray) -> FloatArray:
        return np.asarray(entries + np.array([-n[0] - n[1], *n]))

    sizes = np.full(5, float(np.trace(usual)) / 3)
    return Change(kind, lambda h, n: apply(h, tensor_of_entries(changed(n))), sizes, changed)


def is_scaled(e: OtherEquations) -> bool:
    """Whether a torque acts that shows the scale of the tensor."""
    pulled = e.pull.any() and e.gravity_world.any()
    pushed = e.torque.any() or e.torque_world.any() or e.slowing.any() or e.kept.any()
    return bool(pulled or pushed or e.mobility)


def _size(e: OtherEquations) -> float:
    """The mean moment, kg m²."""
    return float(np.trace(e.inertia)) / 3


def _fastest(scenario: Scenario, e: OtherEquations) -> float:
    """The rate at which the scene's state changes, or |ω| at its start, rad/s."""
    return e.rate or float(np.linalg.norm(scenario.start.omega_body)) or 1.0
