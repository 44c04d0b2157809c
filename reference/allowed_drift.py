"""How far a motion may drift from its conservation laws, if its states are as uncertain as stated.

A law's quantity Q is a function of ω, attitude, and position and velocity of the centre of mass.
To first order its error is the sum of what each of their components changes in it. Twice that is
the drift, for Q(t) and Q(0) both err.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from ..scenarios import Errors, FloatArray, Scenario, Trajectory
from .invariants import invariants

EPS = float(np.finfo(float).eps)
#: The components are moved by as many times their error: far above rounding, and still small.
MAGNIFIED = 2.0**20
#: Ulp, of position and velocity as computed from the state: a rotation, a product and a sum.
PLACED = 4
#: Ulp, of a drift as computed: sums of three products.
SUMMED = 8


def allowed_drifts(scenario: Scenario, motion: Trajectory, uncertainty: Errors) -> dict[str, float]:
    """Bound of the drift from each law of the scene, relative to the law's scale, by its name."""
    moved = list(_moved(scenario, motion, uncertainty))
    allowed = {}
    for invariant in invariants(scenario):
        values = invariant.values(motion)
        changes = (_largest(invariant.values(other) - values) for other in moved)
        scale = invariant.law.scale(invariant.scene)
        size = 2 * sum(changes) / MAGNIFIED
        allowed[invariant.name] = (size / scale if scale > 0 else 0.0) + SUMMED * EPS
    return allowed


def _moved(scenario: Scenario, motion: Trajectory, uncertainty: Errors) -> Iterator[Trajectory]:
    """The motion with one component of its states off by `MAGNIFIED` times its error."""
    speed = float(np.linalg.norm(motion.omega_body, axis=1).max())
    for axis in np.eye(3):
        step = MAGNIFIED * uncertainty.omega * speed * axis
        yield _placed(scenario, replace(motion, omega_body=motion.omega_body + step))
        turn = Rotation.from_rotvec(MAGNIFIED * uncertainty.attitude * axis)
        q = (motion.R_world_body * turn).as_quat(scalar_first=True)
        yield _placed(scenario, replace(motion, q_world_body_wxyz=q))
        for name in ("com_world", "velocity_world"):
            vectors = getattr(motion, name)
            size = float(np.linalg.norm(vectors, axis=1).max())
            step = MAGNIFIED * PLACED * EPS * size * axis
            yield replace(motion, **{name: vectors + step})
    for column in np.eye(motion.spins.shape[1]):
        fastest = float(np.abs(motion.spins @ column).max()) + speed
        yield replace(motion, spins=motion.spins + MAGNIFIED * PLACED * EPS * fastest * column)


def _placed(scenario: Scenario, motion: Trajectory) -> Trajectory:
    """The centre of mass where attitude and ω put it."""
    constraint = scenario.constraint
    swing_world = motion.to_world(np.cross(motion.omega_body, constraint.lever))
    return replace(
        motion,
        com_world=constraint.com_world(motion.to_world(constraint.lever), motion.com_world),
        velocity_world=constraint.velocity_world(swing_world, motion.velocity_world),
    )


def _largest(changes: FloatArray) -> float:
    """The largest of numbers (n,), or of the lengths of vectors (n, 3)."""
    return float(np.linalg.norm(changes.reshape(len(changes), -1), axis=1).max())
