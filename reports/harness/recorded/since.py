"""Since when a measured motion is another one: it is the scene's until then, and obeys a law after.

So it is where a boom unfolds, something strikes the body, or a sensor is knocked out of place.
"""

import numpy as np

from ....scenarios import Trajectory
from ....scenarios.rotation import norms
from .intervals import gained
from .measured import FEWEST, START, Measured, log_of


def since_when(fit: Measured, motion: Trajectory, exact: Trajectory) -> list[str]:
    """Return in words when a motion with noise becomes another one, and which; nothing if not so.

    Parameters
    ----------
    fit : of all samples
    motion, exact : the recorded and the exact motion
    """
    scenario, log = fit.scenario, fit.given
    off = gained(scenario, motion).reshape(-1, 2, 3)
    last = int(np.argmax(np.sum((off / log.noise[:, None]) ** 2, axis=(1, 2))))
    count = len(motion.t)
    if min(last + 1, count - last - 1) < FEWEST:
        return []

    def part(of: Trajectory, start: Trajectory) -> Measured:
        has = {"is_stated": log.is_stated, "has_omega": log.has_omega}
        return Measured(scenario, log_of(scenario, of, start, log.noise, **has))

    before = part(motion.until(last + 1), exact)
    if before.is_beyond or before.explained():
        return []
    later = motion.at(np.arange(last + 1, count))
    # What the motion was set to there is fitted.
    after = part(later, later)
    if after.is_beyond:
        return []
    t, (turned, faster) = motion.t[last], norms(off[last])
    begins = f"until t = {t:.4g} s it is the exact motion; there"
    if words := after.explained(but=START):
        return [f"{begins} it changes: from then on {one}" for one in words]
    return [
        f"{begins} it jumps, the attitude by {np.degrees(turned):.2g}° and ω by {faster:.2g} "
        "rad/s, and goes on as the equations say"
    ]
