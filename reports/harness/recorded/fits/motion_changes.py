"""All changes (`Change`) that may explain a recorded motion, and sentences on them.

A change is one of the equations of motion, or of how states are read.
"""

from functools import lru_cache

import numpy as np

from .....reference.other_equations import KEPT_IN_WORLD, equations_of, inverse
from .....scenarios import FloatArray, Scenario
from ....results.change_words import KINDS, vector
from ...explaining.changes import changes
from ...explaining.fit import Fit
from ...explaining.hypothesis import Change, Hypothesis
from ..samples.missing import KINEMATICS
from ..samples.sensors import FILTERS, READINGS, of_sensor
from .motion_effects import of_attitude, of_rotors

#: Kind and number of the change that reverses gravity. A com on the opposite side of the pivot has
#: the same effect, as the tensor about the pivot is then the same.
MIRRORED = "gravity's size", -2.0
#: The change to an integrator that keeps ω along world axes, as game engines do, but multiplies q
#: by it on the right, which is the side for body axes.
IN_WORLD = Change(
    "wrong side in world axes", lambda h, _: h.of(kinematics=KEPT_IN_WORLD), np.empty(0)
)
#: The change in which the times between samples are wrong by a factor.
TIMES = Change("times", lambda h, n: h.of(step=1 + n[:, 0]), np.ones(1))


def _reversed_rate(axis: int) -> Change:
    """Return the change in which one component of ω', of index `axis`, has the wrong sign."""
    sign = 1.0 - 2.0 * np.eye(3)[axis]

    def reverse(h: Hypothesis, _: FloatArray) -> Hypothesis:
        return h.of(inverse=sign[:, None] * h.inverse)

    return Change("sign of a rate", reverse, np.empty(0), lambda _: [axis])


def _locked_axis(axis: int, *, is_set: bool) -> Change:
    """Return the change in which the component of ω along a body axis is constant.

    Parameters
    ----------
    axis : index of the axis
    is_set : if true, the component is set after each step, and the rates of the others are not
        affected; if false, a torque keeps it constant, as the torque of a hinge would
    """
    kept = [i for i in range(3) if i != axis]

    def lock(h: Hypothesis, _: FloatArray) -> Hypothesis:
        inverse_inertia = h.inverse.copy()
        inverse_inertia[:, axis] = 0.0
        if not is_set:
            rows, columns = np.ix_(kept, kept)
            inverse_inertia[:, :, axis] = 0.0
            inverse_inertia[:, rows, columns] = inverse(h.inertia[:, rows, columns])
        return h.of(inverse=inverse_inertia)

    return Change(f"rate {'set' if is_set else 'held'}", lock, np.empty(0), lambda _: [axis])


#: Changes by the mistake of I₁ − I₃ for I₃ − I₁ in one of Euler's equations without torques.
OTHER_SIGNS = [_reversed_rate(axis) for axis in range(3)]
#: Changes by a constraint, or a flag of an engine, that forbids rotation about an axis of the body.
LOCKED = [_locked_axis(axis, is_set=is_set) for is_set in (False, True) for axis in range(3)]


@lru_cache(1)
def changes_of_motion(scenario: Scenario) -> tuple[Change, ...]:
    """Return the changes of equations, or of how states are read, that may explain a motion."""
    scene = scenario, equations_of(scenario)
    of_equations = IN_WORLD, *changes(scenario), *OTHER_SIGNS, *LOCKED
    return *of_equations, *of_rotors(*scene), *of_attitude(*scene), *READINGS


def is_of_turning(change: Change) -> bool:
    """Return whether a change concerns how states are read, or how the attitude follows from ω."""
    return change in READINGS or KINDS[change.kind].is_kinematic


def sentences(found: Fit) -> list[str]:
    """Return a sentence on each change of a fit, with its fitted parameters."""
    every = []
    for change in found.changes:
        if change in (*READINGS, *FILTERS):
            numbers = found.parameters_of(change)
            every.append(of_sensor(change, numbers, _without_errors))
            continue
        before = f"{KINEMATICS}: " if KINDS[change.kind].is_kinematic else "it moves as if "
        words = found.explanation(change).words
        if (change.kind, *found.explanation(change).numbers) == MIRRORED:
            words += ", or the com were on the other side of the pivot"
        every.append(before + words)
    return every


def _without_errors(numbers: FloatArray, _: float) -> str:
    """Return the parameters of a change, `numbers`, as text.

    `_`, the factor from SI units to the unit of the parameters, is not used.
    """
    return vector(numbers.tolist()) if len(numbers) > 1 else f"{numbers[0]:.4g}"
