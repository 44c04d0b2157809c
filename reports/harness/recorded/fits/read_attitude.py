"""Finds out how a wrong attitude was computed, if the recorded ω is that of the exact motion.

No method integrates ω exactly and the attitude wrongly. So the attitude was filtered or
interpolated after it was computed.
"""

from collections.abc import Iterator

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from .....scenarios import FloatArray, Trajectory
from .....scenarios.rotation import norms, rotation_vectors
from ...explaining.search import LEFT, SAME
from ..samples.clamps import TINY
from ..samples.missing import is_attitude_off, turned_off

#: Least number of samples that tell how the attitude was computed.
FEWEST = 8
#: Largest number of sampling periods between two attitudes that are not interpolated.
MOST_BETWEEN = 60


def attitude_read(motion: Trajectory, exact: Trajectory) -> list[str]:
    """Return a sentence on how a wrong attitude was computed, if the recorded ω is right.

    Parameters
    ----------
    motion, exact : the recorded motion, and the exact one at the same times

    Returns
    -------
    A list of one sentence. It is empty if the attitude is right, if ω is wrong, too, if there are
    too few samples, or if no known way explains the attitude
    """
    if len(motion.t) < FEWEST or not is_attitude_off(motion, exact):
        return []
    q, q_exact = motion.q_world_body_wxyz, exact.q_world_body_wxyz
    most = LEFT * turned_off(motion, exact)
    for words, computed in _explanations(motion.t, q, q_exact):
        if norms(rotation_vectors(q[1:], computed[1:])).max() < most:
            return [words]
    return []


def _explanations(
    t: FloatArray, q: FloatArray, q_exact: FloatArray
) -> Iterator[tuple[str, FloatArray]]:
    """Yield ways in which the recorded attitudes may have been computed from the exact ones.

    Parameters
    ----------
    t : times of the n samples, s, (n,)
    q, q_exact : the recorded and the exact attitudes, scalar first, (n, 4)

    Yields
    ------
    A sentence on the way, and the attitudes computed in that way, (n, 4)
    """
    remaining, steps = rotation_vectors(q[:-1], q_exact[1:]), rotation_vectors(q[:-1], q[1:])
    weight = float(np.sum(remaining * steps) / max(np.sum(remaining**2), TINY))
    if 0 < weight < 1 and np.sum((steps - weight * remaining) ** 2) < LEFT**2 * np.sum(steps**2):
        filtered = Rotation.from_quat(q[:-1], scalar_first=True) * Rotation.from_rotvec(
            weight * remaining
        )
        delay = (1 - weight) / weight * float(np.median(np.diff(t)))
        yield (
            f"the attitude is filtered, which delays it by {delay:.4g} s: at each sample it goes "
            f"{weight:.4g} of the way to the body's",
            np.vstack([q[:1], filtered.as_quat(scalar_first=True)]),
        )
    deviations = norms(rotation_vectors(q, q_exact))
    right = np.flatnonzero(deviations < SAME * deviations.max())
    period = int(np.median(np.diff(right))) if len(right) > 2 else 1
    if 1 < period <= MOST_BETWEEN:
        keys = np.arange(right[0], len(t), period)
        span = slice(keys[0], keys[-1] + 1)
        attitudes = Rotation.from_quat(q[keys], scalar_first=True)
        spherical = Slerp(t[keys], attitudes)(t[span]).as_quat(scalar_first=True)
        signs = np.cumprod([1.0, *np.sign(np.sum(q[keys[:-1]] * q[keys[1:]], axis=1))])
        columns = (signs[:, None] * q[keys]).T
        linear = np.column_stack([np.interp(t[span], t[keys], one) for one in columns])
        for one in spherical, linear / norms(linear)[:, None]:
            computed = q.copy()
            computed[span] = one
            yield (
                f"the attitude is interpolated: it is new at one sample in {period} only; record "
                "those alone",
                computed,
            )
