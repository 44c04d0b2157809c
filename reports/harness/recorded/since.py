"""Since when a measured motion is another one: it is the scene's until then, and obeys a law after.

So it is where a boom unfolds, a thruster stops, something strikes the body, or a sensor is knocked
out of place.
"""

from typing import NamedTuple

import numpy as np
from scipy.special import chdtrc

from ....scenarios import FloatArray, Trajectory
from ....scenarios.rotation import norms
from ..explaining.search import LEFT, LEVEL
from .intervals import Intervals, apart, states_of
from .log import FEWEST, log_of
from .log_fit import START
from .measured import Measured

#: Samples by which a motion that was exact is off by far more, at most: a method's error grows.
AT_ONCE = 3
#: Standard deviations of noise up to which two motions meet at a time.
MEET = 5.0


def since_when(fit: Measured, motion: Trajectory, exact: Trajectory) -> list[str]:
    """Return in words when a motion with noise becomes another one, and which; nothing if not so.

    The motion is the exact one up to the first sample by which its errors are more than noise. The
    law of what comes after is fitted to the rest, and the motion by that law is followed back to
    where it meets the exact motion. If it meets it nowhere, there is a jump.

    Parameters
    ----------
    fit : of all samples
    motion, exact : the recorded and the exact motion
    """
    scenario, log = fit.scenario, fit.given
    squares = np.sum(fit.search.unchanged.residuals.reshape(len(motion.t), -1) ** 2, axis=1)
    by_then = np.arange(1, len(squares) + 1) * log.measured
    first = int(np.argmax(chdtrc(by_then, np.cumsum(squares)) < LEVEL))
    if min(first, len(motion.t) - first) < FEWEST:
        return []

    def part(of: Trajectory, start: Trajectory) -> Measured:
        has = {"is_stated": log.is_stated, "has_omega": log.has_omega}
        return Measured(scenario, log_of(scenario, of, start, log.noise, **has))

    later = motion.at(np.arange(first, len(motion.t)))
    # What the motion was set to there is fitted.
    after = part(later, later)
    if after.is_beyond:
        return []
    back = np.arange(first, -1, -1)
    made = after.given.made([after.found.hypothesis], motion.t[back])[0]
    off = apart(made, states_of(exact)[back])
    distances = np.sqrt(np.mean((off / np.repeat(log.noise, 3)) ** 2, axis=1))
    nearest, words = int(np.argmin(distances)), after.explained(but=START)
    if distances[nearest] < MEET and words:
        first = int(back[nearest])
    before = part(motion.until(first), exact)
    if first < FEWEST or before.is_beyond or before.explained():
        return []
    begins = f"until t = {motion.t[first - 1]:.4g} s it is the exact motion; there"
    if words:
        return [f"{begins} it changes: from then on {one}" for one in words]
    turned, faster = norms(off[0].reshape(2, 3))
    return [
        f"{begins} it jumps, the attitude by {np.degrees(turned):.2g}° and ω by {faster:.2g} "
        "rad/s, and goes on as the equations say"
    ]


class Since(NamedTuple):
    """A motion that is the exact one until it is another one.

    Attributes
    ----------
    last, first : the last sample that is the exact motion's, and the first of those that surely
        are not
    is_method : whether it is the exact motion but for a method's error; else to rounding
    off : how far the motion is off afterwards, from sample to sample, rad and rad/s, (2,)
    """

    last: int
    first: int
    is_method: bool
    off: FloatArray


def since_exactly(data: Intervals, least: FloatArray, reach: int) -> Since | None:
    """Return since when a motion without noise is not the exact one; None if always, or never.

    From sample to sample it follows the equations, and then at once it does not.

    Parameters
    ----------
    data : all intervals of the motion
    least : differences of attitude, rad, and ω, rad/s, that may be rounding, (2,)
    reach : how many samples on each side ω is computed from
    """
    off = norms(data.apart(data.base.equations).reshape(-1, 3)).reshape(-1, 2)
    inner = slice(reach, len(off) - reach)
    if len(off[inner]) < 2 * FEWEST:
        return None
    for is_method in (False, True):
        each = (off / np.hypot(least, is_method * data.method)).max(axis=1)[inner]
        last = int(np.argmax(each > 1))
        first = last + 2 * reach
        soon = each[last : first + AT_ONCE]
        is_at_once = soon.max() > max(1 / LEFT, LEFT**2 * each.max())
        if min(last, len(each) - first) >= FEWEST and is_at_once:
            # What ω is computed from reaches so far.
            return Since(first, first + reach, is_method, off[last + reach :].max(axis=0))
    return None
