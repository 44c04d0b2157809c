"""How rounding a motion's states to doubles changes the signals that are computed from them."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from ..scenarios import Errors, Scenario, Trajectory, errors_between, signals_of

EPS = float(np.finfo(float).eps)
#: Factor by which a component's error is magnified, so that its effect is far above rounding; it is
#: still so small that the effect is linear.
MAGNIFIED = 2.0**20
#: Error, in ulp, of a component together with the products that it enters.
ROUNDED = 2
#: Number of samples at which the effect of rounding is computed.
LOOKED_AT = 64


def rounding_of(scenario: Scenario, motion: Trajectory) -> Errors:
    """Return the error of each signal that the rounding of a motion's states to doubles causes.

    It is relative or in rad. It is large where the angular momenta of body and rotors cancel.
    Rounding errors of single components have random signs, so that the squares of their effects are
    added. At most `LOOKED_AT` samples are examined.
    """
    every = -(-len(motion.t) // LOOKED_AT)
    seen = motion.every(every)
    names = [signal.name for signal in signals_of(scenario)]
    ulp = Errors(**dict.fromkeys(names, ROUNDED * EPS))
    apart = [
        [size for _, size in errors_between(scenario, moved, seen)]
        for moved in moved_states(scenario, seen, ulp, ROUNDED)
    ]
    sizes = np.linalg.norm(apart, axis=0) / MAGNIFIED
    return Errors(**dict(zip(names, map(float, sizes), strict=True)))


def moved_states(
    scenario: Scenario, motion: Trajectory, uncertainty: Errors, placed: float
) -> Iterator[Trajectory]:
    """Yield for each component of the states a copy of the motion with an error in this component.

    The error is `MAGNIFIED` times the one that the parameters state, and the same at all samples.

    Parameters
    ----------
    uncertainty : errors of ω, relative to its largest norm, and of attitude, rad
    placed : error of position and velocity of the com, and of spins, in ulp
    """
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
            step = MAGNIFIED * placed * EPS * size * axis
            yield replace(motion, **{name: vectors + step})
    for column in np.eye(motion.spins.shape[1]):
        fastest = float(np.abs(motion.spins @ column).max()) + speed
        yield replace(motion, spins=motion.spins + MAGNIFIED * placed * EPS * fastest * column)


def _placed(scenario: Scenario, motion: Trajectory) -> Trajectory:
    """Return the motion with com and velocity along held axes computed from attitude and ω."""
    constraint = scenario.constraint
    swing_world = motion.to_world(np.cross(motion.omega_body, constraint.lever))
    return replace(
        motion,
        com_world=constraint.com_world(motion.to_world(constraint.lever), motion.com_world),
        velocity_world=constraint.velocity_world(swing_world, motion.velocity_world),
    )
