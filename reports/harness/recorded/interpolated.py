"""Whether ω of a recording was held, or interpolated linearly, between fewer samples."""

import numpy as np

from ....scenarios import Trajectory
from ....scenarios.rotation import norms

#: Samples at which ω is new, at least; and by how much more than rounding it then changes.
FEWEST, CHANGES = 3, 50.0


def interpolated(motion: Trajectory, rounding: float) -> list[str]:
    """Say that ω is the same, or on a line, between every so many samples; else nothing.

    Parameters
    ----------
    rounding : of ω, rad/s
    """
    distances = np.diff(motion.t)[:, None]
    steps = np.diff(motion.omega_body, axis=0)
    bends = np.diff(steps / distances, axis=0) * distances[1:]
    for how, changes in (("held", norms(steps)), ("interpolated linearly", norms(bends))):
        new = np.flatnonzero(changes > CHANGES * rounding)
        count = int(np.median(np.diff(new))) if len(new) >= FEWEST else 1
        # A motion that comes to rest is new at every sample, and then no more.
        if count > 1 and np.sum(changes <= rounding) >= (count - 1) * (len(new) - 1):
            return [f"ω is {how}: it is new at one sample in {count} only; record those alone"]
    return []
