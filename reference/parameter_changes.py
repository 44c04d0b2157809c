"""What a unit change of a start or a parameter changes in the equations of motion.

At moments that stay, every constant of the equations is linear in one such number: those of a
problem with the change in place of the number, and zero for all others, are the derivatives. A
change of mass, com or inertia is a change δI of the tensor besides.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from mpmath import mp, mpf

from ..scenarios import Scenario
from ..scenarios.exact import DIGITS, ZERO, rotate
from ..scenarios.principal import IDENTITY
from .problem import Problem

#: Of mpf.
Array = Any
#: The entries of an inertia tensor, in the order in which they are listed everywhere.
ENTRIES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


def exact(values: Any) -> Array:
    """Numbers as an array of mpf, of the same shape."""
    return np.vectorize(mpf, otypes=[object])(np.array(values, dtype=object))


_UNITS, _NONE = exact(IDENTITY), exact(ZERO)


@dataclass(frozen=True, eq=False)
class Change:
    """A unit change of one number, in extended precision.

    Attributes
    ----------
    turn_axes, omega_axes : of the start, rad and rad/s, along the principal axes
    inertia_axes : δI about the fixed point, kg m², along them
    constants : of what the constants are linear in, by attribute of a `Problem`
    lever_body : of the vector from what holds the body to the com, m, body axes
    """

    turn_axes: Array = field(default_factory=_NONE.copy)
    omega_axes: Array = field(default_factory=_NONE.copy)
    inertia_axes: Array = field(default_factory=lambda: exact(np.zeros((3, 3))))
    constants: dict[str, Any] = field(default_factory=dict)
    lever_body: Array = field(default_factory=_NONE.copy)


def changes(scenario: Scenario, problem: Problem) -> dict[str, list[Change]]:
    """The changes by attitude and ω at the start, and by all parameters that a scene has, by name.

    Masses and places are those of `[body]`, which is without its rotors; the inertia, that about
    its com.
    """
    with mp.workdps(DIGITS):
        axes = [exact(rotate(problem.q_axes_body, axis)) for axis in IDENTITY]
        rotors, of_body = scenario.rotors.each, _of_body(scenario, problem, axes)
        free = [one.along * exact(one.axis) * (one.hinge == "free") for one in rotors]
        found = {
            "attitude": [Change(turn_axes=axis) for axis in axes],
            "omega": [
                Change(omega_axes=axis, constants={"kept": [row[k] for row in free]})
                for k, axis in enumerate(axes)
            ],
            "inertia": [of_body(_entry(i, j), mpf(0), _NONE) for i, j in ENTRIES],
            "mass": [of_body(0 * _UNITS, mpf(1), _NONE)],
            "com": [of_body(0 * _UNITS, mpf(0), unit) for unit in _UNITS],
        }
        of_effects = {
            "gravity": [Change(constants={"gravity_world": unit}) for unit in _UNITS],
            "drag": [Change(constants={"drag": mpf(1)})],
            "torque_body": [Change(constants={"torque_axes": axis}) for axis in axes],
            "torque_world": [Change(constants={"torque_world": unit}) for unit in _UNITS],
        }
        found |= {name: each for name, each in of_effects.items() if name in scenario.called_for}
        if rotors:
            spun = np.diag([one.along * (one.hinge != "locked") for one in rotors])
            found["spins"] = [Change(constants={"kept": list(row)}) for row in spun]
    return found


def derivative_problem(problem: Problem, change: Change) -> Problem:
    """The problem whose constants are derivatives, but for those that only moments are in."""
    vectors = ("lever_axes", "gravity_world", "torque_axes", "torque_world", "tip_axes")
    numbers: dict[str, Any] = dict.fromkeys(("drag", "mass", "tip_radius"), mpf(0))
    numbers |= dict.fromkeys(vectors, ZERO) | {"kept": [mpf(0)] * len(problem.kept)}
    return replace(problem, **numbers | {"ends_at_lift_off": False} | change.constants)


def _of_body(
    scenario: Scenario, problem: Problem, axes: list[Array]
) -> Callable[[Array, mpf, Array], Change]:
    """What makes a change of the inertia about the com, kg m², the mass, kg, and the com, m."""
    own, whole, R_axes_body = scenario.carrier, scenario.body, np.stack(axes, axis=1)
    mass, com, whole_com = own.mass_exact, exact(own.com_exact), exact(whole.com_exact)
    arm = com if scenario.constraint.is_pivot else com - whole_com

    def change(inertia: Array, heavier: mpf, moved: Array) -> Change:
        # δ of m (r·r 1 − r rᵀ); about a com that moves itself its motion adds nothing.
        square = 2 * (arm @ moved) * _UNITS - np.outer(arm, moved) - np.outer(moved, arm)
        point = (arm @ arm) * _UNITS - np.outer(arm, arm)
        tensor = inertia + heavier * point + mass * square
        lever = (heavier * (com - whole_com) + mass * moved) / whole.mass_exact
        constants: dict[str, Any] = {"mass": heavier}
        if {"pivot", "gravity"} <= scenario.called_for:
            constants["lever_axes"] = R_axes_body @ (heavier * com + mass * moved)
        if problem.slides:
            constants["tip_axes"] = -R_axes_body @ lever
        along_axes = R_axes_body @ tensor @ R_axes_body.T
        return Change(inertia_axes=along_axes, constants=constants, lever_body=lever)

    return change


def _entry(i: int, j: int) -> Array:
    """A unit of an entry of a symmetric tensor."""
    return exact([[{row, column} == {i, j} for column in range(3)] for row in range(3)])
