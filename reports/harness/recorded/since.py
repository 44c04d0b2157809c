"""Since when a measured motion is another one: it is the scene's until then, and obeys a law after.

So it is where a boom unfolds, something strikes the body, or a sensor is knocked out of place.
"""

import numpy as np

from ....scenarios import FloatArray, Scenario, Trajectory
from ....scenarios.rotation import norms
from .intervals import gained
from .measured import FEWEST, START, Measured, log_of


def since_when(
    scenario: Scenario,
    motion: Trajectory,
    exact: Trajectory,
    noise: FloatArray,
    *,
    is_stated: bool,
    has_omega: bool,
) -> list[str]:
    """Return in words when a motion with noise becomes another one, and which; nothing if not so.

    Parameters
    ----------
    motion, exact : the recorded and the exact motion
    noise, is_stated, has_omega : as in `Log`
    """
    off = gained(scenario, motion).reshape(-1, 2, 3)
    last = int(np.argmax(np.sum((off / noise[:, None]) ** 2, axis=(1, 2))))
    count = len(motion.t)
    if min(last + 1, count - last - 1) < FEWEST:
        return []

    def part(of: Trajectory, start: Trajectory) -> Measured:
        log = log_of(scenario, of, start, noise, is_stated=is_stated, has_omega=has_omega)
        return Measured(scenario, log)

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
