"""Finds samples with wrong signs, wrapped values, exchanged rows or wrong times."""

import numpy as np

from .....reference.deviations import apart
from .....reference.following import follow
from .....reference.other_equations import equations_of
from .....scenarios import FloatArray, Scenario, Trajectory
from .....scenarios.rotation import conjugate, norms, rotation_vectors
from ...explaining.search import LEFT, SAME
from ..files.motion import Reading
from ..files.recording import unit_of
from .digits import CHANGES, Numbers, Shown, where
from .intervals import NEAR, deviations_from_flow, root_mean_squares, states_of
from .mistakes import FITS, TOO_LONG, TOO_SHORT

#: Least number of samples of a recording; least number of samples whose ω wraps around.
FEWEST, FEWEST_WRAPPED = 6, 2
#: Number of Newton steps with which the time of a state is found.
NEWTON_STEPS = 4
#: Relative tolerance with which jumps, or times between samples, count as equal.
ALIKE = 0.02


def lost_sign(reading: Reading, numbers: Numbers) -> Shown | None:
    """Return the finding that the sign of qw is lost in some samples.

    The absolute value of qw was then recorded, and the conjugates of these samples are right.

    Parameters
    ----------
    reading : the samples of the recording as they were read
    numbers : their columns as in the file, with those of the exact motion

    Returns
    -------
    None if some qw is negative, if conjugation of some samples does not make all of them right, or
    if there are too few samples
    """
    q, exact = reading.q, numbers.q_exact
    if (q[:, 0] < 0).any() or len(q) < FEWEST:
        return None
    given = norms(rotation_vectors(exact, q))
    conjugated = norms(rotation_vectors(exact, conjugate(q)))
    wrong = np.flatnonzero(conjugated < LEFT * given)
    if not 0 < len(wrong) < len(q) or np.minimum(given, conjugated).max() > LEFT * given.max():
        return None
    first, last = reading.t[wrong[[0, -1]]]
    return Shown(
        f"the sign of qw is lost, it is never negative: conjugating {len(wrong)} of {len(q)} "
        f"samples, the first at t = {first:.6g} s, the last at {last:.6g} s, mends all",
        wrong,
        mended=reading._replace(q=np.where((conjugated < given)[:, None], conjugate(q), q)),
    )


def across_signs(numbers: Numbers) -> Shown | None:
    """Return the finding that recorded attitudes are interpolated between q of opposite signs.

    As q and −q are one attitude, an interpolated quaternion is then far from the attitudes of both
    its neighbours. It is found as a quaternion on the straight line between them.

    Returns
    -------
    The finding; None if no attitude is interpolated in this way
    """
    t, q = numbers.t, numbers.q
    before, after = q[:-2], q[2:]
    part = ((t[1:-1] - t[:-2]) / (t[2:] - t[:-2]))[:, None]
    chord = (1 - part) * before + part * after
    lengths = np.maximum(norms(chord), np.finfo(float).tiny)
    deviation = norms(q[1:-1] / norms(q[1:-1])[:, None] - chord / lengths[:, None])
    speeds = norms(numbers.omega_exact)[1:-1]
    # If the body turns by less than half a turn, quaternions with a positive inner product are
    # those that change continuously.
    is_slow = speeds * (t[2:] - t[:-2]) < np.pi
    is_opposite = np.einsum("ij,ij->i", before, after) < 0
    is_on = deviation * lengths < CHANGES * numbers.resolution_q
    wrong = np.flatnonzero(is_slow & is_opposite & is_on) + 1
    if not len(wrong):
        return None
    return Shown(
        f"attitudes are interpolated between quaternions of opposite signs, {where(t, wrong)}: "
        "change the sign of one of the two before",
        wrong,
    )


def wrapped(numbers: Numbers, omega: FloatArray) -> Shown | None:
    """Return the finding that ω wraps around, as integers do that overflow; None if it does not.

    Where a component of ω would leave a range, the width of the range is added or subtracted. None
    is also returned if samples are too few, or too far apart, to tell.

    Parameters
    ----------
    numbers : the columns of the recording, with those of the exact motion
    omega : the recorded ω of n samples, rad/s, along the axes of the file, (n, 3)
    """
    t, turns = numbers.t, norms(numbers.rates) * numbers.spans
    if len(t) < FEWEST or turns.max() > NEAR:
        return None
    means = (
        numbers.rates[1:] * numbers.spans[:-1, None] + numbers.rates[:-1] * numbers.spans[1:, None]
    )
    by_attitude = means / (t[2:] - t[:-2])[:, None]
    deviation = omega[1:-1] - by_attitude
    largest = float(np.abs(deviation).max())
    is_wrong = np.abs(deviation) > largest / 2
    wrong = np.flatnonzero(is_wrong.any(axis=1)) + 1
    # A column that is wrong at all samples has the opposite sign or a bias instead.
    is_wrapped = is_wrong.any(axis=0) & ~is_wrong.all(axis=0)
    if len(wrong) < FEWEST_WRAPPED or not is_wrapped.any():
        return None
    jump = float(np.median(np.abs(deviation[is_wrong])))
    is_alike = np.abs(np.abs(deviation[is_wrong]) - jump).max() < ALIKE * jump
    is_right = np.abs(deviation[~is_wrong]).max() < ALIKE * jump
    if not is_alike or not is_right or np.abs(omega).max() > (1 + ALIKE) * jump / 2:
        return None
    # The first and the last ω are estimated by the estimates for their neighbours.
    estimates = np.vstack([by_attitude[:1], by_attitude, by_attitude[-1:]])
    wrong = np.flatnonzero((np.abs(omega - estimates) > jump / 2).any(axis=1))
    return Shown(
        f"ω wraps around, off by {jump:.4g} rad/s as numbers do that leave ±{jump / 2:.4g} rad/s, "
        f"{where(t, wrong)}",
        wrong,
    )


def exchanged(scenario: Scenario, motion: Trajectory) -> Shown | None:
    """Return the finding that some rows are exchanged with the next ones; None if none are.

    Two successive rows count as exchanged if the exact flow leads to them, and from them to the
    next row, only in the other order.
    """
    t, states = motion.t, states_of(motion)
    if len(t) < FEWEST or not motion.omega_body.any():
        return None
    equations, speed = equations_of(scenario), float(norms(motion.omega_body).max())

    def sizes(deviation: FloatArray) -> FloatArray:
        return norms(deviation[:, :3]) + norms(deviation[:, 3:]) / speed

    given = sizes(deviations_from_flow(scenario, motion))
    typical = float(np.median(given))
    before = given[:-2] + given[1:-1] + given[2:]
    # Of each four rows, the second and third may be exchanged; these are the indices of the second.
    second = 1 + np.flatnonzero(before > CHANGES * 3 * typical)
    first, third, fourth = second - 1, second + 1, second + 2
    residual = np.zeros(len(second))
    for start, end, at in (
        (first, third, second),
        (third, second, third),
        (second, fourth, fourth),
    ):
        model = follow(equations, states[start], (t[at] - t[at - 1])[:, None])[:, 0]
        residual += np.nan_to_num(sizes(apart(model, states[end])), nan=np.inf)
    pairs = second[residual < LEFT * before[second - 1]]
    if not len(pairs):
        return None
    both = np.union1d(pairs, pairs + 1)
    times = f"t = {t[pairs[0]]:.6g} s and {t[pairs[0] + 1]:.6g} s"
    if len(pairs) == 1:
        return Shown(f"the rows at {times} are exchanged", both)
    last = f"at {t[pairs[-1]]:.6g} s and {t[pairs[-1] + 1]:.6g} s"
    return Shown(
        f"{len(pairs)} pairs of successive rows are exchanged, the first at {times}, the last "
        f"{last}",
        both,
    )


def jitter(reading: Reading, omega: FloatArray) -> Shown | None:
    """Return the finding that recorded times jitter about the actual ones; None if they do not.

    They do if the recorded times are uneven, and ω agrees far better with the rate of the attitude
    if the times are taken to be evenly spaced.

    Parameters
    ----------
    reading : the n samples of the recording as they were read
    omega : their ω, rad/s, body axes, (n, 3)
    """
    t, q = reading.t, reading.q
    indices = np.arange(len(t))
    slope, start = np.polyfit(indices, t, 1)
    deviation = float(np.abs(t - start - slope * indices).max())
    if len(t) < FEWEST or deviation <= FITS * slope or deviation < unit_of(np.diff(t)):
        return None
    # Sampling periods are usually round numbers.
    rounded = float(f"{slope:.2g}")
    slope = rounded if abs(rounded - slope) * len(t) < deviation else slope
    spans = np.diff(t)
    if np.mean(np.abs(spans - np.median(spans)) > ALIKE * slope) < LEFT:
        # If few times between samples differ, the clock was set, and does not jitter.
        return None
    turned, rates = rotation_vectors(q[:-1], q[1:]), (omega[1:] + omega[:-1]) / 2
    given = norms(turned - rates * np.diff(t)[:, None])
    even = norms(turned - rates * slope)
    # Medians are compared, as a few wrong samples are no evidence of wrong times.
    if np.median(even) >= LEFT * np.median(given):
        return None
    return Shown(
        f"the times jitter, by up to {1e3 * deviation:.2g} ms: attitudes follow ω if the samples "
        f"are taken to be {slope:.6g} s apart",
        np.arange(1, len(t)),
        mended=reading._replace(t=t[0] + slope * indices),
    )


def warped(scenario: Scenario, motion: Trajectory, exact: Trajectory, noise: FloatArray) -> str:
    """Return the sentence that each recorded state is the exact one at another time.

    The time of each state is found by Newton's method. The text is empty if there are no such
    times, if the motion's errors need no explanation, or if less than a tenth of the times between
    samples are wrong.

    Parameters
    ----------
    motion, exact : the recorded motion, and the exact one at the recorded times
    noise : errors of attitude, rad, and ω, rad/s, that need no explanation, (2,)
    """
    equations, model, recorded = equations_of(scenario), states_of(exact), states_of(motion)
    unit = np.repeat([1.0, float(norms(exact.omega_body).max()) or 1.0], 3)
    offsets = np.zeros(len(motion.t))
    given = deviation = apart(model, recorded) / unit
    for _ in range(NEWTON_STEPS):
        small = SAME / unit[3]
        changed = (
            apart(model, follow(equations, model, np.full((len(offsets), 1), small))[:, 0]) / unit
        )
        slopes = changed / small
        squares = np.maximum(np.sum(slopes**2, axis=1), np.finfo(float).tiny)
        offsets += np.sum(slopes * deviation, axis=1) / squares
        if np.abs(offsets).max() > motion.t[-1] - motion.t[0]:
            return ""
        model = follow(equations, states_of(exact), offsets[:, None])[:, 0]
        deviation = apart(model, recorded) / unit
    size, residual = (float(np.abs(one).max()) for one in (given, deviation))
    is_more = np.abs(given).max(axis=0) > np.maximum(FITS, np.repeat(noise, 3) / unit)
    if not np.isfinite(residual) or not is_more.any() or residual > SAME * size:
        return ""
    spans = np.diff(motion.t)
    if np.mean(np.abs(np.diff(offsets)) > SAME * spans) < LEFT:
        # If few times between samples are wrong, the clock was set.
        return ""
    # From sample to sample the times must be as wrong. A method's error delays a whole motion that
    # lingers near an unstable one, though each step takes the time that it should.
    ends = (
        follow(equations, recorded[:-1], (spans + late)[:, None])[:, 0]
        for late in (np.zeros_like(spans), np.diff(offsets))
    )
    at_stated, at_found = (root_mean_squares(apart(one, recorded[1:]) / unit) for one in ends)
    if not np.hypot(*at_found) <= np.hypot(*at_stated):
        return ""
    slope = float(offsets @ motion.t / (motion.t @ motion.t))
    if np.abs(offsets - slope * motion.t).max() < SAME * np.abs(offsets).max():
        times, how = (1 + slope, TOO_SHORT) if slope > 0 else (1 / (1 + slope), TOO_LONG)
        return f"the times are {times:.4g} times {how}"
    before, after = (one if one > FITS else 0.0 for one in (-offsets.min(), offsets.max()))
    return (
        f"each state is that of another time, from {before:.4g} s before to {after:.4g} s "
        "after its own, as where steps of different lengths are written as "
        "if they were even"
    )
