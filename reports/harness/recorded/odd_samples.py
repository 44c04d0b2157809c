"""Samples of a recorded motion that are wrong by themselves: signs, wraps, order and times."""

import numpy as np

from ....reference.following import follow
from ....scenarios import FloatArray, Scenario, Trajectory
from ....scenarios.rotation import conjugate, norms, rotation_vectors
from ..explaining.hypothesis import as_it_is
from ..explaining.search import LEFT, SAME
from .digits import CHANGES, Numbers, Shown, where
from .intervals import NEAR, apart, gained, states_of
from .mistakes import FITS, TOO_LONG, TOO_SHORT
from .motion import Reading
from .recording import unit_of

#: Least number of samples, and of wrapped ones.
FEWEST, FEWEST_WRAPPED = 6, 2
#: Steps of a search for the time of a state.
NEWTONS = 4
#: Relative distance of jumps that are of one size.
ALIKE = 0.02


def lost_sign(reading: Reading, numbers: Numbers) -> Shown | None:
    """Say that qw is its absolute value: conjugating some of the samples mends all."""
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
    """Say which samples are on the straight line between quaternions of opposite signs."""
    t, q = numbers.t, numbers.q
    before, after = q[:-2], q[2:]
    part = ((t[1:-1] - t[:-2]) / (t[2:] - t[:-2]))[:, None]
    chord = (1 - part) * before + part * after
    lengths = np.maximum(norms(chord), np.finfo(float).tiny)
    off = norms(q[1:-1] / norms(q[1:-1])[:, None] - chord / lengths[:, None])
    speeds = norms(numbers.omega_exact)[1:-1]
    # Of a body that turns by less than half a turn the signs are not opposite by themselves.
    is_slow = speeds * (t[2:] - t[:-2]) < np.pi
    is_opposite = np.einsum("ij,ij->i", before, after) < 0
    is_on = off * lengths < CHANGES * numbers.resolution_q
    wrong = np.flatnonzero(is_slow & is_opposite & is_on) + 1
    if not len(wrong):
        return None
    return Shown(
        f"attitudes are interpolated between quaternions of opposite signs, {where(t, wrong)}: "
        "change the sign of one of the two before",
        wrong,
    )


def wrapped(numbers: Numbers, omega: FloatArray) -> Shown | None:
    """Say that ω is off by one and the same number where it would leave a range, as by overflow."""
    t, turns = numbers.t, norms(numbers.rates) * numbers.spans
    if len(t) < FEWEST or turns.max() > NEAR:
        return None
    means = (
        numbers.rates[1:] * numbers.spans[:-1, None] + numbers.rates[:-1] * numbers.spans[1:, None]
    )
    by_attitude = means / (t[2:] - t[:-2])[:, None]
    off = omega[1:-1] - by_attitude
    largest = float(np.abs(off).max())
    is_off = np.abs(off) > largest / 2
    wrong = np.flatnonzero(is_off.any(axis=1)) + 1
    # Columns that are wrong throughout, and no others, have another sign, or a bias.
    leaves = is_off.any(axis=0) & ~is_off.all(axis=0)
    if len(wrong) < FEWEST_WRAPPED or not leaves.any():
        return None
    jump = float(np.median(np.abs(off[is_off])))
    is_alike = np.abs(np.abs(off[is_off]) - jump).max() < ALIKE * jump
    is_right = np.abs(off[~is_off]).max() < ALIKE * jump
    if not is_alike or not is_right or np.abs(omega).max() > (1 + ALIKE) * jump / 2:
        return None
    # At either end ω is nearly that of the next sample.
    nearly = np.vstack([by_attitude[:1], by_attitude, by_attitude[-1:]])
    wrong = np.flatnonzero((np.abs(omega - nearly) > jump / 2).any(axis=1))
    return Shown(
        f"ω wraps around, off by {jump:.4g} rad/s as numbers do that leave ±{jump / 2:.4g} rad/s, "
        f"{where(t, wrong)}",
        wrong,
    )


def exchanged(scenario: Scenario, motion: Trajectory) -> Shown | None:
    """Say which rows are exchanged with the next: in the other order the motion is smooth."""
    t, states = motion.t, states_of(motion)
    if len(t) < FEWEST or not motion.omega_body.any():
        return None
    equations, speed = as_it_is(scenario).equations, float(norms(motion.omega_body).max())

    def sizes(off: FloatArray) -> FloatArray:
        return norms(off[:, :3]) + norms(off[:, 3:]) / speed

    given = sizes(gained(scenario, motion))
    usual = float(np.median(given))
    before = given[:-2] + given[1:-1] + given[2:]
    # The second and the third of four rows, by the index of the second.
    second = 1 + np.flatnonzero(before > CHANGES * 3 * usual)
    first, third, fourth = second - 1, second + 1, second + 2
    left = np.zeros(len(second))
    for start, end, at in (
        (first, third, second),
        (third, second, third),
        (second, fourth, fourth),
    ):
        made = follow(equations, states[start], (t[at] - t[at - 1])[:, None])[:, 0]
        left += np.nan_to_num(sizes(apart(made, states[end])), nan=np.inf)
    pairs = second[left < LEFT * before[second - 1]]
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
    """Say that times jitter about even ones, by which attitudes follow ω far better.

    Parameters
    ----------
    omega : ω along body axes, rad/s, (n, 3)
    """
    t, q = reading.t, reading.q
    count = np.arange(len(t))
    slope, start = np.polyfit(count, t, 1)
    off = float(np.abs(t - start - slope * count).max())
    if len(t) < FEWEST or off <= FITS * slope or off < unit_of(np.diff(t)):
        return None
    # Samples are usually a round time apart.
    rounded = float(f"{slope:.2g}")
    slope = rounded if abs(rounded - slope) * len(t) < off else slope
    spans = np.diff(t)
    if np.mean(np.abs(spans - np.median(spans)) > ALIKE * slope) < LEFT:
        # A clock that is set makes one span another one.
        return None
    turned, rates = rotation_vectors(q[:-1], q[1:]), (omega[1:] + omega[:-1]) / 2
    given = norms(turned - rates * np.diff(t)[:, None])
    even = norms(turned - rates * slope)
    # Single samples that are off say nothing of times.
    if np.median(even) >= LEFT * np.median(given):
        return None
    return Shown(
        f"the times jitter, by up to {1e3 * off:.2g} ms: attitudes follow ω if the samples are "
        f"taken to be {slope:.6g} s apart",
        np.arange(1, len(t)),
        mended=reading._replace(t=t[0] + slope * count),
    )


def warped(scenario: Scenario, motion: Trajectory, exact: Trajectory, noise: FloatArray) -> str:
    """Say that each state is the exact motion's at another time; empty if that is not so.

    Parameters
    ----------
    noise : errors of attitude, rad, and ω, rad/s, that need no explanation, (2,)
    """
    equations, made, recorded = as_it_is(scenario).equations, states_of(exact), states_of(motion)
    unit = np.repeat([1.0, float(norms(exact.omega_body).max()) or 1.0], 3)
    later = np.zeros(len(motion.t))
    given = off = apart(made, recorded) / unit
    for _ in range(NEWTONS):
        small = SAME / unit[3]
        changed = apart(made, follow(equations, made, np.full((len(later), 1), small))[:, 0]) / unit
        slopes = changed / small
        squares = np.maximum(np.sum(slopes**2, axis=1), np.finfo(float).tiny)
        later += np.sum(slopes * off, axis=1) / squares
        if np.abs(later).max() > motion.t[-1] - motion.t[0]:
            return ""
        made = follow(equations, states_of(exact), later[:, None])[:, 0]
        off = apart(made, recorded) / unit
    size, left = (float(np.abs(one).max()) for one in (given, off))
    is_more = np.abs(given).max(axis=0) > np.maximum(FITS, np.repeat(noise, 3) / unit)
    if not np.isfinite(left) or not is_more.any() or left > SAME * size:
        return ""
    spans = np.diff(motion.t)
    if np.mean(np.abs(np.diff(later)) > SAME * spans) < LEFT:
        # A clock that is set makes one span another one.
        return ""
    slope = float(later @ motion.t / (motion.t @ motion.t))
    if np.abs(later - slope * motion.t).max() < SAME * np.abs(later).max():
        times, how = (1 + slope, TOO_SHORT) if slope > 0 else (1 / (1 + slope), TOO_LONG)
        return f"the times are {times:.4g} times {how}"
    before, after = (one if one > FITS else 0.0 for one in (-later.min(), later.max()))
    return (
        f"each state is that of another time, from {before:.4g} s before to {after:.4g} s "
        "after its own, as where steps of different lengths are written as "
        "if they were even"
    )
