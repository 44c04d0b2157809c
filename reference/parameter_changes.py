"""What a unit change of a start or a parameter changes in the equations of motion.

Every constant of the equations is linear in one such number, at moments that stay: those of the
changed problem with all other numbers zero are therefore the derivatives of the constants. A change
of mass, com or inertia is a change δI of the tensor besides.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, NamedTuple

from mpmath import mp, mpf

from ..scenarios import Scenario
from ..scenarios.exact import (
    DIGITS,
    ZERO,
    Tensor,
    Vector,
    add,
    conjugate,
    dot,
    rotate,
    steiner,
    turned_tensor,
)
from ..scenarios.principal import IDENTITY
from .problem import Problem

NO_TENSOR: Tensor = (ZERO, ZERO, ZERO)
#: The entries of an inertia tensor, in the order in which they are listed everywhere.
ENTRIES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


class Change(NamedTuple):
    """A unit change of one number, in extended precision, along the principal axes.

    Attributes
    ----------
    turn_axes, omega_axes : of the start, rad and rad/s
    inertia_axes : δI about the fixed point, kg m²
    constants : of what the constants are linear in, by attribute of a `Problem`
    lever_body : of the vector from what holds the body to the com, m, body axes
    """

    turn_axes: Vector = ZERO
    omega_axes: Vector = ZERO
    inertia_axes: Tensor = NO_TENSOR
    constants: dict[str, Any] = {}  # noqa: RUF012
    lever_body: Vector = ZERO


def changes(scenario: Scenario, problem: Problem) -> dict[str, tuple[Change, ...]]:
    """The changes by the start and by all parameters that a scene has, by name.

    Masses, places and moments are those of `[body]`, which is without its rotors; the inertia is
    that about its com.
    """
    q, rotors = problem.q_axes_body, scenario.rotors
    with mp.workdps(DIGITS):
        axes = [rotate(q, axis) for axis in IDENTITY]
        found = {
            "attitude": [Change(turn_axes=axis) for axis in axes],
            "omega": [
                Change(omega_axes=rotate(q, axis), constants={"kept": _kept_by(scenario, axis)})
                for axis in IDENTITY
            ],
            "inertia": [_of_body(scenario, problem, inertia=_entry(i, j)) for i, j in ENTRIES],
            "mass": [_of_body(scenario, problem, mass=mpf(1))],
            "com": [_of_body(scenario, problem, com=axis) for axis in IDENTITY],
        }
        in_scene = {
            "gravity": [Change(constants={"gravity_world": axis}) for axis in IDENTITY],
            "drag": [Change(constants={"drag": mpf(1)})],
            "torque_body": [Change(constants={"torque_axes": axis}) for axis in axes],
            "torque_world": [Change(constants={"torque_world": axis}) for axis in IDENTITY],
        }
        found |= {name: each for name, each in in_scene.items() if name in scenario.called_for}
        if rotors:
            spun = [one.along * (one.hinge != "locked") for one in rotors.each]
            found["spins"] = [Change(constants={"kept": row}) for row in _diagonal(spun)]
    return {name: tuple(each) for name, each in found.items()}


def derivative_problem(problem: Problem, change: Change) -> Problem:
    """The problem whose constants are the derivatives, but for those of the moments alone."""
    nothing = dict.fromkeys(
        ("lever_axes", "gravity_world", "torque_axes", "torque_world", "tip_axes"), ZERO
    )
    none = mpf(0)
    zeros = {"drag": none, "mass": none, "tip_radius": none, "kept": (none,) * len(problem.kept)}
    return replace(problem, ends_at_lift_off=False, **nothing | zeros | change.constants)


def _of_body(
    scenario: Scenario,
    problem: Problem,
    inertia: Tensor = NO_TENSOR,
    mass: mpf = ZERO[0],
    com: Vector = ZERO,
) -> Change:
    """The change by one of the inertia about the com, kg m², the mass, kg, and the com, m."""
    body, whole, q = scenario.carrier, scenario.body, problem.q_axes_body
    constraint, moved = scenario.constraint, _scaled(mass, body.com_exact, body.mass_exact, com)
    fixed = ZERO if constraint.is_pivot else whole.com_exact
    arm = _scaled(mpf(1), body.com_exact, mpf(-1), fixed)
    # d(|r|² 1 − r rᵀ) along d, by the polar form of the square: S(r + d) − S(r) − S(d).
    square = add(steiner(mpf(1), _scaled(mpf(1), arm, mpf(1), com)), steiner(mpf(1), com), -1)
    shifted = add(square, steiner(mpf(1), arm), -1)
    tensor = add(inertia, steiner(mass, arm))
    tensor = add(tensor, _times(body.mass_exact, shifted))
    constants: dict[str, Any] = {"mass": mass}
    if {"pivot", "gravity"} <= scenario.called_for:
        constants["lever_axes"] = rotate(q, moved)
    # M δC = δ(Σ m r) − δM C.
    lever = _scaled(1 / whole.mass_exact, moved, -mass / whole.mass_exact, whole.com_exact)
    if scenario.effects.table:
        constants["tip_axes"] = rotate(q, _scaled(mpf(-1), lever, mpf(0), ZERO))
    along_axes = turned_tensor(tensor, conjugate(q))
    return Change(inertia_axes=along_axes, constants=constants, lever_body=lever)


def _kept_by(scenario: Scenario, axis: Vector) -> tuple[mpf, ...]:
    """What free hinges keep the more where ω at the start has a unit more along an axis."""
    return tuple(
        one.along * dot(one.axis, axis) * (one.hinge == "free") for one in scenario.rotors.each
    )


def _diagonal(values: list[mpf]) -> Iterator[tuple[mpf, ...]]:
    for k, value in enumerate(values):
        yield tuple(value if j == k else mpf(0) for j in range(len(values)))


def _entry(i: int, j: int) -> Tensor:
    """A unit of an entry of a symmetric tensor."""
    row = [tuple(mpf({r, c} == {i, j}) for c in range(3)) for r in range(3)]
    return row[0], row[1], row[2]  # type: ignore[return-value]


def _scaled(a: mpf, u: Vector, b: mpf, v: Vector) -> Vector:
    """A u + b v."""
    return (a * u[0] + b * v[0], a * u[1] + b * v[1], a * u[2] + b * v[2])


def _times(factor: mpf, tensor: Tensor) -> Tensor:
    first, second, third = (_scaled(factor, row, mpf(0), ZERO) for row in tensor)
    return (first, second, third)
