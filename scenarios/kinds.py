"""Kinds of motion: what acts on the body, and whether it has an axis of symmetry."""

import numpy as np

from .float_array import FloatArray
from .scenario import Scenario

#: Moments, and directions, that agree this far, relatively, are equal.
_ALIKE = 1e-9
#: In the order in which they are shown.
KINDS = (
    "free symmetric",
    "free asymmetric",
    "heavy symmetric",
    "heavy asymmetric",
    "driven",
    "with rotors",
    "on a table",
)
#: Effects that leave the energy as it is.
_UNDRIVEN = {"gravity", "pivot"}


def kind_of(scenario: Scenario) -> str:
    """One of `KINDS`: driven if more than gravity acts, heavy if that has a moment about a pivot."""
    if scenario.rotors:
        return "with rotors"
    if "table" in scenario.called_for:
        return "on a table"
    if scenario.called_for - _UNDRIVEN:
        return "driven"
    arm = np.array(scenario.body.com) if scenario.constraint.is_pivot else np.zeros(3)
    if not (scenario.gravity_world.any() and arm.any()):
        arm = np.zeros(3)
    weight = "heavy" if arm.any() else "free"
    return f"{weight} {'symmetric' if _is_symmetric(scenario.inertia, arm) else 'asymmetric'}"


def _is_symmetric(inertia: FloatArray, arm: FloatArray) -> bool:
    """Whether two moments are equal, and the arm from the pivot is along the third one's axis."""
    moments, axes = np.linalg.eigh(inertia)
    for k in range(3):
        others = np.delete(moments, k)
        across = np.linalg.norm(np.cross(axes[:, k], arm))
        is_round = abs(others[1] - others[0]) <= _ALIKE * moments[2]
        if is_round and across <= _ALIKE * np.linalg.norm(arm):
            return True
    return False
