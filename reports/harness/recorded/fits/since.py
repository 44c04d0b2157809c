"""Finds the time at which a motion suddenly changes, until which it is the scene's exact motion.

Examples are a boom that unfolds, a thruster that stops, an impact, or a sensor that is knocked out
of place.
"""

from typing import NamedTuple

import numpy as np
from scipy.special import chdtrc, fdtrc

from .....reference.deviations import apart
from .....scenarios import FloatArray, Trajectory
from .....scenarios.rotation import norms
from ...explaining.fit import TINY
from ...explaining.search import LEFT, SIGNIFICANCE
from ..samples.intervals import Intervals, deviations_from_flow, states_of
from .log import FEWEST, log_of
from .log_fit import START
from .measured import Measured

#: A sudden change shows within this number of samples, while a method's error grows slowly.
AT_ONCE = 3
#: Largest distance of two motions, in standard deviations of noise, at which they count as equal.
MEET = 5.0

#: The sentence on a change that nothing explains, after the words on the motion before it.
CHANGED = (
    "{}; from then on it is another one, off by up to {:.2g}° and {:.2g} rad/s from sample to "
    "sample: look for what changed there"
)


def since_when(fit: Measured, motion: Trajectory, exact: Trajectory) -> list[str]:
    """Return sentences on when a motion with noise suddenly changes, and how it goes on then.

    The first sample after the change is the first at which χ² of all deviations so far from the
    exact motion exceeds noise. The samples from there on are fitted by themselves. If that requires
    changes of the scene's equations, there is a sentence for each of them. The time of the sudden
    change is then that at which the fitted motion, followed back in time, meets the exact one, if
    it does. If no such changes are required, the sentence says by how much the motion jumps.

    Parameters
    ----------
    fit : the fit to all samples
    motion, exact : the recorded and the exact motion, at the same times

    Returns
    -------
    The sentences. There are none if too few samples are before or after the change, if the motion
    before it is not the exact one within noise, or if the motion after it is not explained within
    noise
    """
    scenario, log = fit.scenario, fit.given
    squares = np.sum(fit.search.unchanged.residuals.reshape(len(motion.t), -1) ** 2, axis=1)
    degrees_of_freedom = np.arange(1, len(squares) + 1) * log.measured
    first = int(np.argmax(chdtrc(degrees_of_freedom, np.cumsum(squares)) < SIGNIFICANCE))
    if min(first, len(motion.t) - first) < FEWEST:
        return []

    def fitted(of: Trajectory, start: Trajectory) -> Measured:
        flags = {"is_stated": log.is_stated, "has_omega": log.has_omega}
        return Measured(scenario, log_of(scenario, of, start, log.noise, **flags))

    later = motion.at(np.arange(first, len(motion.t)))
    # The start of the later motion is fitted as well.
    after = fitted(later, later)
    if after.is_beyond:
        return []
    back = np.arange(first, -1, -1)
    made = after.given.made(after.found.hypothesis[None], motion.t[back])[0]
    off = apart(made, states_of(exact)[back])
    distances = np.sqrt(np.mean((off / np.repeat(log.noise, 3)) ** 2, axis=1))
    nearest, words = int(np.argmin(distances)), after.explained(but=START)
    if distances[nearest] < MEET and words:
        first = int(back[nearest])
    before = fitted(motion.until(first), exact)
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


def since_left_out(fit: Measured, motion: Trajectory) -> list[str]:
    """Return a list of the sentence that a motion changes among the samples that a fit leaves out.

    The list is empty if it does not, or if no samples are left out.

    However unstable the motion is, the scene's equations lead from each sample to the next to
    within noise. By an F-test, the deviations of the samples that are left out are compared with
    those of the samples before; as two neighbours share the noise of a sample, half of the
    deviations count.

    Parameters
    ----------
    fit : the fit to the samples before those that are left out
    motion : the whole recorded motion
    """
    kept = len(fit.given.t)
    if kept == len(motion.t):
        return []
    squares = norms(deviations_from_flow(fit.scenario, motion).reshape(-1, 3)).reshape(-1, 2) ** 2
    before, after = squares[: kept - 1], squares[kept - 1 :]
    counts = 3 * len(after) / 2, 3 * len(before) / 2
    tails = fdtrc(*counts, after.mean(axis=0) / np.maximum(before.mean(axis=0), TINY))
    if tails.min() > SIGNIFICANCE / 2:
        return []
    last = kept - 1 + int((after / np.maximum(before.mean(axis=0), TINY)).max(axis=1).argmax())
    begins = f"until t = {motion.t[last]:.4g} s it is the exact motion with noise"
    turned, faster = np.sqrt(after.max(axis=0))
    return [CHANGED.format(begins, np.degrees(turned), faster)]


class Since(NamedTuple):
    """A sudden change of a motion that is the exact one before it.

    Attributes
    ----------
    last : index of the last sample that belongs to the exact motion
    first : index of the first sample that belongs to the later motion; equal to `last` if ω was
        recorded, and larger if it is computed from attitudes
    is_method : whether the motion has a method's error before the change; else it is exact but for
        rounding
    off : the largest differences of attitude, rad, and ω, rad/s, from the exact flow over one
        interval, of all intervals after the change, (2,)
    """

    last: int
    first: int
    is_method: bool
    off: FloatArray


def since_exactly(data: Intervals, least: FloatArray, reach: int) -> Since | None:
    """Return the sudden change of a recorded motion without noise; None if there is none.

    Each interval is solved exactly from the state recorded at its start, and the result is compared
    with the state recorded at its end. Before the change the two differ by rounding alone, or by a
    method's error; within `AT_ONCE` samples of it they differ by far more. None is also returned if
    too few intervals lie on either side to tell.

    Parameters
    ----------
    data : all intervals of the motion
    least : bounds on differences by rounding, of attitude, rad, and ω, rad/s, (2,)
    reach : the number of samples on each side from which ω is computed; 0 if ω was recorded
    """
    off = norms(data.apart(data.base).reshape(-1, 3)).reshape(-1, 2)
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
            # A computed ω is wrong already at `reach` samples before the change, and still is as
            # many after it.
            return Since(first, first + reach, is_method, off[last + reach :].max(axis=0))
    return None
