"""How much the equations of motion change for a unit change of a start number or a parameter.

At constant moments of inertia, every constant of the equations is linear in each such number. A
change of mass, com or inertia also changes the tensor, by δI.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from mpmath import mp, mpf

from ..scenarios import Scenario
from ..scenarios.exact import DIGITS, ZERO, Quaternion, conjugate, rotate, turned_tensor
from ..scenarios.principal import IDENTITY
from .effect_terms import TERMS, BodyChange, EffectTerms, Numbers
from .problem import Problem

#: An array whose entries are mpf numbers.
Array = Any
#: The entries of an inertia tensor, in the order in which they are listed everywhere.
ENTRIES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


def exact(values: Any) -> Array:
    """Return numbers as an array of mpf numbers of the same shape."""
    return np.vectorize(mpf, otypes=[object])(np.array(values, dtype=object))


_UNITS, _NONE = exact(IDENTITY), exact(ZERO)


@dataclass(frozen=True, eq=False)
class Change:
    """How much a problem changes for a unit change of one number, in extended precision.

    Attributes
    ----------
    turn_axes : turn of the attitude at the start, rad, along principal axes
    omega_axes : change of ω at the start, rad/s, along principal axes
    inertia_axes : δI about the fixed point, kg m², along principal axes
    constants : changes of those attributes of `Problem` in which the constants of the equations are
        linear, by attribute
    lever_body : change of the vector from the point that is held to the com, m, body axes
    """

    turn_axes: Array = field(default_factory=_NONE.copy)
    omega_axes: Array = field(default_factory=_NONE.copy)
    inertia_axes: Array = field(default_factory=lambda: exact(np.zeros((3, 3))))
    constants: Numbers = field(default_factory=dict)
    lever_body: Array = field(default_factory=_NONE.copy)


def changes(scenario: Scenario, problem: Problem) -> dict[str, list[Change] | Change]:
    """Return, by name, how much a problem changes for one unit of each start number and parameter.

    The names are "attitude", "omega", "inertia", "mass", "com", and those of effects' parameters.
    For a vector the value is a list with a change for each component, for a scalar a single change.
    Mass, com and inertia are those of the scene's `[body]`, without rotors; the inertia is about
    that body's com.
    """
    q, acting = problem.q_axes_body, [TERMS[name] for name in TERMS if name in scenario.called_for]
    with mp.workdps(DIGITS):
        axes = [exact(rotate(q, axis)) for axis in IDENTITY]
        of_body = _of_body(scenario, q, acting)
        found: dict[str, list[Change] | Change] = {
            "attitude": [Change(turn_axes=axis) for axis in axes],
            "omega": [
                Change(
                    omega_axes=axis,
                    constants=_joined(one.by_omega(scenario, unit) for one in acting),
                )
                for unit, axis in zip(IDENTITY, axes, strict=True)
            ],
            "inertia": [of_body(_entry(i, j), mpf(0), _NONE) for i, j in ENTRIES],
            "mass": of_body(0 * _UNITS, mpf(1), _NONE),
            "com": [of_body(0 * _UNITS, mpf(0), unit) for unit in _UNITS],
        }
        for terms in acting:
            for name, each in terms.parameters(scenario, q).items():
                found[name] = (
                    Change(constants=each)
                    if isinstance(each, dict)
                    else [Change(constants=numbers) for numbers in each]
                )
    return found


def changed_problem(problem: Problem, change: Change) -> Problem:
    """Return a problem in which the numbers in `change.constants` are changed.

    The constants of the equations are linear in these numbers. Start and inertia are not changed.
    """
    with mp.workdps(DIGITS):
        numbers = {
            name: np.array(getattr(problem, name)) + np.array(by)
            for name, by in change.constants.items()
        }
    return replace(problem, **numbers)


def _of_body(
    scenario: Scenario, q: Quaternion, acting: list[EffectTerms]
) -> Callable[[Array, mpf, Array], Change]:
    """Return a function that computes the `Change` of a problem from changes of its body.

    Its arguments are the changes of the inertia about the com, kg m², of the mass, kg, and of the
    com, m, in body axes.

    Parameters
    ----------
    q : quaternion from body axes to principal axes
    acting : terms of the effects that the scene calls for
    """
    own, whole = scenario.carrier, scenario.body
    mass, com, whole_com = own.mass_exact, exact(own.com_exact), exact(whole.com_exact)
    arm = com if scenario.constraint.is_pivot else com - whole_com

    def change(inertia: Array, heavier: mpf, moved: Array) -> Change:
        # The change of m (r·r 1 − r rᵀ). If the tensor is about the com of the whole body, that
        # this com moves, too, changes the tensor to second order only.
        square = 2 * (arm @ moved) * _UNITS - np.outer(arm, moved) - np.outer(moved, arm)
        point = (arm @ arm) * _UNITS - np.outer(arm, arm)
        tensor = inertia + heavier * point + mass * square
        lever = (heavier * (com - whole_com) + mass * moved) / whole.mass_exact
        body_change = BodyChange(heavier, heavier * com + mass * moved, lever)
        return Change(
            inertia_axes=turned_tensor(tensor.tolist(), conjugate(q)),
            constants=_joined(one.by_body(scenario, q, body_change) for one in acting),
            lever_body=lever,
        )

    return change


def _joined(each: Iterable[Numbers]) -> Numbers:
    """Return the changes that several effects make to a problem's numbers, in one dictionary.

    The keys are attributes of `Problem`; no two effects change the same one.
    """
    return {name: by for numbers in each for name, by in numbers.items()}


def _entry(i: int, j: int) -> Array:
    """Return the symmetric tensor, (3, 3), whose entries ij and ji are 1 and all others 0."""
    return exact([[{row, column} == {i, j} for column in range(3)] for row in range(3)])
