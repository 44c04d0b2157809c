"""Finds where a recorded motion jumps, if it obeys the equations of motion between most samples."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import chdtri, fdtri

from .....reference.deviations import apart
from .....reference.following import follow
from .....scenarios import FloatArray
from .....scenarios.rotation import norms, rotation_vectors
from ...explaining.search import LEFT, SAME, SIGNIFICANCE
from .intervals import Intervals
from .mistakes import FITS

#: The most rows that may have been lost in one place.
MOST_LOST = 20
#: Largest turn, rad, of an interval in which a jump is looked for.
FAR = 2.5
#: The number of later jumps of which one may lead back to the motion before a jump. The number of
#: kinds of jumps that are named.
UNDONE_BY, KINDS_TOLD = 4, 2
#: The number of intervals on each side with which an interval is compared; two may be jumps, too.
AROUND = 4
#: Number of Newton steps with which the time between two states is found; and tolerance of a number
#: of lost rows.
STEPS, TIME_TOLERANCE = 6, 1e-3


@dataclass(frozen=True)
class Jump:
    """A place where a motion jumps.

    Attributes
    ----------
    kind : name of the kind of jump; jumps of one kind are counted together
    at : time of the first sample that differs from the motion before it, s
    words : a sentence on the jump
    """

    kind: str
    at: float
    words: str


def jumps(data: Intervals, reach: int) -> list[Jump]:
    """Return the first jump of each kind in a motion, with the number of such jumps in its words.

    At most `KINDS_TOLD` kinds are returned. The list is empty if there is no jump, if more than a
    tenth of all intervals have one, or if deviations decay from the first interval on, as those of
    a filter do that starts with the motion.

    Parameters
    ----------
    data : all intervals in which the body turns by less than `FAR`, with the noise of the samples
    reach : the number of samples on each side of a jump whose ω is wrong, as it is computed from
        attitudes; 0 if ω was recorded
    """
    deviations = data.apart(data.base)
    chi2 = np.sum((deviations / data.scale) ** 2, axis=1)
    # At either end ω is computed from samples on one side of it, and has larger errors.
    inner = range(reach, len(deviations) - reach)
    places, found = [k for k in _places(data, deviations, chi2) if k in inner], list[Jump]()
    while places:
        k, *later = places
        last = next((j for j in later[:UNDONE_BY] if _goes_on(data, k, j, chi2[k])), None)
        if last is None and not k and chi2[1] > LEFT**2 * chi2[0]:
            # A filter that starts with the motion affects the samples after the first, too.
            return []
        end = k
        while last is None and (near := [j for j in later if end < j <= end + 1 + 2 * reach]):
            end = near[0]
        if last is not None:
            found.append(_outliers(data, deviations, k, last))
        else:
            around = max(0, k - reach), min(end + reach, len(deviations) - 1)
            found.append(
                (_outlying_attitudes(data, *around) if reach else None)
                or _time_jump(data, *around)
                or (_stretch(data, deviations, k, end) if end > k else _jump(data, deviations, k))
            )
        places = [j for j in later if j > (last or end)]
    kinds = dict.fromkeys(one.kind for one in found)
    return [_with_count([one for one in found if one.kind == kind]) for kind in kinds][:KINDS_TOLD]


def _places(data: Intervals, deviations: FloatArray, chi2: FloatArray) -> list[int]:
    """Return the indices of the intervals whose deviations are far larger than those of others.

    The list is empty if these intervals are more than the fraction `LEFT` of all.

    Parameters
    ----------
    data : the n intervals
    deviations : those of the ends of the intervals from the exact flow, rad and rad/s, (n, 6)
    chi2 : sum of squares of each interval's deviations, in units of their scale, (n,)
    """
    level = SIGNIFICANCE / len(deviations)
    correlated = 1 + 5 * data.of_method
    is_beyond = chi2 / correlated > chdtri(6 / correlated, level)
    # A method's error changes little from one interval to the next.
    in_noise = np.sqrt(np.sum((deviations / np.repeat(data.noise, 3)) ** 2, axis=1))
    around = np.lib.stride_tricks.sliding_window_view(np.pad(in_noise, AROUND), 2 * AROUND + 1)
    others = np.sort(around, axis=1)[:, -3]
    is_beyond |= in_noise > np.maximum(others, 1.0) / SAME
    if np.sum(is_beyond) > LEFT * len(deviations):
        return []
    squares = np.mean(deviations.reshape(-1, 2, 3) ** 2, axis=2)
    # If noise is nearly as large as a method's error, it exceeds the error at some of many samples
    # without a jump.
    usual = np.mean(squares[~is_beyond], axis=0)
    is_beyond &= np.any(squares > usual / fdtri(3 * np.sum(~is_beyond), 3, level), axis=1)
    return [*map(int, np.flatnonzero(is_beyond))]


def _goes_on(data: Intervals, k: int, last: int, chi2: float) -> bool:
    """Return whether the exact flow leads from the start of interval `k` to the end of `last`.

    It does not if the intervals from `k` to `last` are not consecutive.

    Parameters
    ----------
    data : all intervals of the motion
    k, last : indices of the intervals
    chi2 : sum of squares of the deviations of interval `k`, in units of their scale
    """
    if not np.array_equal(data.starts[k + 1 : last + 1], data.ends[k:last]):
        return False
    spans = data.spans[k : last + 1].T
    after = follow(data.base, data.starts[[k]], spans)[0, -1]
    deviations = apart(after[None], data.ends[[last]])[0] / data.scale[k]
    return bool(np.sum(deviations**2) < max(chdtri(6, SIGNIFICANCE), LEFT**4 * chi2))


def _outliers(data: Intervals, deviations: FloatArray, k: int, last: int) -> Jump:
    """Return the jump of outliers: samples that are off, while the motion then goes on as before.

    Parameters
    ----------
    data : all n intervals of the motion
    deviations : those of the ends of all intervals from the exact flow, rad and rad/s, (n, 6)
    k, last : the interval that ends in the first outlier, and the one that begins in the last one
    """
    first, count = data.t[k], last - k
    if count == 1:
        words = f"the sample at t = {first:.6g} s is off by {_size(deviations[k])}: leave it out"
    else:
        words = (
            f"{count} samples, from t = {first:.6g} s to {data.t[last - 1]:.6g} s, are off, the "
            f"first by {_size(deviations[k])}; after them the motion goes on as before: leave them "
            "out"
        )
    return Jump("off", first, words)


def _stretch(data: Intervals, deviations: FloatArray, k: int, end: int) -> Jump:
    """Return the jump over successive intervals in which the motion does not obey the equations.

    Parameters
    ----------
    data : all n intervals of the motion
    deviations : those of the ends of all intervals from the exact flow, rad and rad/s, (n, 6)
    k, end : the first and the last of these intervals
    """
    worst = deviations[k + int(np.argmax(norms(deviations[k : end + 1])))]
    omega_part = worst[3:] / data.scale[k, 3:]
    how = "the attitude does not follow ω" if np.sum(omega_part**2) < 1 else "it goes on otherwise"
    words = (
        f"from t = {data.t[k] - data.spans[k, 0]:.6g} s to {data.t[end]:.6g} s {how}, by up to "
        f"{_size(worst)} from one sample to the next"
    )
    return Jump("stretch", data.t[k], words)


def _outlying_attitudes(data: Intervals, first: int, last: int) -> Jump | None:
    """Return the jump of attitudes that are outliers, if ω was not recorded.

    They are off the exact flow that leads from the start of interval `first` to the end of interval
    `last` of all intervals, `data`.

    Returns
    -------
    None if the flow does not lead to the end of `last`, or if no attitude is off it
    """
    spans = data.spans[first : last + 1].T
    computed = follow(data.base, data.starts[[first]], spans)[0]
    ends, scale = data.ends[first : last + 1], data.scale[first : last + 1]
    deviations = norms(apart(computed, ends)[:, :3])
    is_outlier = (deviations / scale[:, 0]) ** 2 > chdtri(3, SIGNIFICANCE)
    if is_outlier[-1] or not is_outlier.any():
        return None
    at, size = data.t[first : last + 1][is_outlier], float(np.degrees(deviations.max()))
    words = f"the sample at t = {at[0]:.6g} s is off by {size:.3g}°: leave it out"
    if len(at) > 1:
        words = (
            f"{len(at)} samples, from t = {at[0]:.6g} s to {at[-1]:.6g} s, are off by up to "
            f"{size:.3g}°: leave them out"
        )
    return Jump("off", at[0], words)


def _time_jump(data: Intervals, first: int, last: int) -> Jump | None:
    """Return the jump in time from the start of interval `first` of `data` to the end of `last`.

    The exact flow leads from one to the other, but takes another time than the recorded one.

    Returns
    -------
    None if the flow does not lead there in any time
    """
    spans, elapsed = data.spans[first : last + 1, 0], _time_between(data, first, last)
    if elapsed is None:
        return None
    at, span = data.t[(first + last) // 2], float(np.median(spans))
    more = elapsed - float(spans.sum())
    lost = round(more / span)
    if 0 < lost <= MOST_LOST and abs(more - lost * span) < TIME_TOLERANCE * span:
        samples = "1 sample is" if lost == 1 else f"{lost} samples are"
        words = f"{samples} lost before t = {at:.6g} s, or its time is too early"
        return Jump("lost", data.t[first], words)
    begun = data.t[first] - data.spans[first, 0]
    words = (
        f"from t = {begun:.6g} s to {data.t[last]:.6g} s the motion goes on by {elapsed:.4g} s, "
        f"and the times by {spans.sum():.4g} s"
    )
    return Jump("clock", data.t[first], words)


def _jump(data: Intervals, deviations: FloatArray, k: int) -> Jump:
    """Return a jump in interval `k` after which the motion goes on from another state.

    Parameters
    ----------
    data : all n intervals of the motion
    deviations : those of the ends of all intervals from the exact flow, rad and rad/s, (n, 6)
    """
    at = data.t[k]
    if not k:
        words = (
            f"the first sample is off what follows by {_size(deviations[0])}, as where a state is "
            "written before an engine corrects it, or by a step that begins wrongly"
        )
        return Jump("first", at, words)
    like = "a state is set, something strikes it, or a method's coordinates have a pole"
    if np.sum((deviations[k, 3:] / data.scale[k, 3:]) ** 2) < 1:
        like = "the attitude alone is set, or an angle is read from another branch"
    return Jump(
        "jump", at, f"at t = {at:.6g} s it jumps, by {_size(deviations[k])}, as where {like}"
    )


def _time_between(data: Intervals, first: int, last: int) -> float | None:
    """Return the time that the exact flow takes from one interval's start to another's end, s.

    Parameters
    ----------
    data : all intervals of the motion
    first, last : indices of the two intervals

    Returns
    -------
    None if the flow does not lead there, or if ω is 0 in either state
    """
    start, end, equations = data.starts[[first]], data.ends[[last]], data.base
    speeds = norms(np.vstack([start, end])[:, 4:])
    if not speeds.all():
        return None
    elapsed = float(norms(rotation_vectors(start[:, :4], end[:, :4]))[0] / speeds.mean())
    for _ in range(STEPS):
        computed = follow(equations, start, np.array([[elapsed]]))[:, 0]
        omega = computed[0, 4:]
        elapsed += float(rotation_vectors(computed[:, :4], end[:, :4])[0] @ omega / (omega @ omega))
    computed = follow(equations, start, np.array([[elapsed]]))[0, 0]
    is_later = elapsed > 0 and np.isfinite(computed).all()
    return elapsed if is_later and _is_near(computed, end[0], data.scale[last]) else None


def _with_count(alike: Sequence[Jump]) -> Jump:
    """Return the first of several jumps of one kind, with their number added to its words."""
    first, count = alike[0], len(alike)
    if count == 1:
        return first
    also = f"(one of {count} such places, the last at {alike[-1].at:.6g} s)"
    return replace(first, words=f"{first.words} {also}")


def _is_near(computed: FloatArray, recorded: FloatArray, scale: FloatArray) -> bool:
    """Return whether a computed state, (7,), equals a recorded one, (7,), within noise.

    Parameters
    ----------
    scale : standard deviations of attitude, rad, and ω, rad/s, (6,)
    """
    deviations = apart(computed[None], recorded[None])[0] / scale
    return bool(np.sum(deviations**2) < chdtri(6, SIGNIFICANCE))


def _size(deviations: FloatArray) -> str:
    """Return in words the sizes of deviations of attitude, rad, and ω, rad/s, (6,)."""
    turned, faster = (0.0 if size < FITS else size for size in norms(deviations.reshape(2, 3)))
    return f"{np.degrees(turned):.3g}° and {faster:.3g} rad/s"
