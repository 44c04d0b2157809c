"""What was made of a body's attitude, where the recorded ω alone is that of the exact motion.

No method makes ω of the exact motion, and the attitude otherwise: so the attitude was recorded, or
made of others, in some other way.
"""

from collections.abc import Iterator

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from ....scenarios import FloatArray, Trajectory
from ....scenarios.rotation import norms, rotation_vectors
from ..explaining.search import LEFT, SAME
from .clamps import TINY
from .missing import is_attitude_off, turned_off

#: Least number of samples that show what was made of the attitude.
FEWEST = 8
#: Most samples from one recorded attitude to the next, where others are interpolated.
MOST_BETWEEN = 60


def attitude_read(motion: Trajectory, exact: Trajectory) -> list[str]:
    """Return what was made of the attitude, in words; nothing if ω is not the exact motion's."""
    if len(motion.t) < FEWEST or not is_attitude_off(motion, exact):
        return []
    q, q_exact = motion.q_world_body_wxyz, exact.q_world_body_wxyz
    most = LEFT * turned_off(motion, exact)
    for words, made in _made(motion.t, q, q_exact):
        if norms(rotation_vectors(q[1:], made[1:])).max() < most:
            return [words]
    return []


def _made(t: FloatArray, q: FloatArray, q_exact: FloatArray) -> Iterator[tuple[str, FloatArray]]:
    """Yield what is made of the exact attitudes, in words, and the attitudes that it makes."""
    wanted, steps = rotation_vectors(q[:-1], q_exact[1:]), rotation_vectors(q[:-1], q[1:])
    part = float(np.sum(wanted * steps) / max(np.sum(wanted**2), TINY))
    if 0 < part < 1 and np.sum((steps - part * wanted) ** 2) < LEFT**2 * np.sum(steps**2):
        gone = Rotation.from_quat(q[:-1], scalar_first=True) * Rotation.from_rotvec(part * wanted)
        delay = (1 - part) / part * float(np.median(np.diff(t)))
        yield (
            f"the attitude is filtered, which delays it by {delay:.4g} s: at each sample it goes "
            f"{part:.4g} of the way to the body's",
            np.vstack([q[:1], gone.as_quat(scalar_first=True)]),
        )
    off = norms(rotation_vectors(q, q_exact))
    right = np.flatnonzero(off < SAME * off.max())
    between = int(np.median(np.diff(right))) if len(right) > 2 else 1
    if 1 < between <= MOST_BETWEEN:
        keys = np.arange(right[0], len(t), between)
        kept = slice(keys[0], keys[-1] + 1)
        attitudes = Rotation.from_quat(q[keys], scalar_first=True)
        turned = Slerp(t[keys], attitudes)(t[kept]).as_quat(scalar_first=True)
        signs = np.cumprod([1.0, *np.sign(np.sum(q[keys[:-1]] * q[keys[1:]], axis=1))])
        columns = (signs[:, None] * q[keys]).T
        straight = np.column_stack([np.interp(t[kept], t[keys], one) for one in columns])
        for one in turned, straight / norms(straight)[:, None]:
            made = q.copy()
            made[kept] = one
            yield (
                f"the attitude is interpolated: it is new at one sample in {between} only; record "
                "those alone",
                made,
            )
