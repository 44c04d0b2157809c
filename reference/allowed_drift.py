"""How far a motion may drift from its conservation laws, given the uncertainty of its states.

A law's quantity Q is a function of ω, attitude, and position and velocity of the centre of mass.
To first order the error of Q is the sum of the changes that the error of each state component
makes in it. The allowed drift is twice that sum, because Q(t) and Q(0) both have such an error.
"""

import numpy as np

from ..scenarios import Errors, FloatArray, Scenario, Trajectory
from .invariants import invariants
from .state_rounding import MAGNIFIED, moved_states

EPS = float(np.finfo(float).eps)
#: Rounding error, in ulp, of a position or velocity that is computed from attitude and ω by a
#: rotation, a product and a sum.
PLACED = 4
#: Rounding error, in ulp, of a drift, which is computed by sums of three products.
SUMMED = 8


def allowed_drifts(scenario: Scenario, motion: Trajectory, uncertainty: Errors) -> dict[str, float]:
    """Return for each conservation law the largest drift that errors of a motion's states explain.

    The keys are the names of the laws. Drifts are relative to `Law.scale`; if that scale is zero,
    only the rounding of the drift itself is allowed.

    Parameters
    ----------
    motion : the exact motion
    uncertainty : the largest errors of the motion's ω, relative, and of its attitude, rad; those of
        other signals are not used
    """
    moved = list(moved_states(scenario, motion, uncertainty, PLACED))
    allowed = {}
    for invariant in invariants(scenario):
        values = invariant.values(motion)
        changes = (_largest(invariant.values(other) - values) for other in moved)
        scale = invariant.law.scale(invariant.scene)
        size = 2 * sum(changes) / MAGNIFIED
        allowed[invariant.name] = (size / scale if scale > 0 else 0.0) + SUMMED * EPS
    return allowed


def _largest(changes: FloatArray) -> float:
    """Return the largest size of n numbers, (n,), or the largest length of n vectors, (n, 3)."""
    return float(np.linalg.norm(changes.reshape(len(changes), -1), axis=1).max())
