"""Says where a recorded motion jumps, though it is the exact one from nearly every sample on."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import chdtri, fdtri

from ....reference.following import follow
from ....scenarios import FloatArray
from ....scenarios.rotation import norms, rotation_vectors
from ..explaining.search import LEFT, LEVEL, SAME
from .intervals import Intervals, apart
from .mistakes import FITS

#: Largest number of rows that may have been lost at once.
MOST_LOST = 20
#: Largest turn, rad, of an interval that is looked at.
FAR = 2.5
#: How many later jumps one may be undone by, at most, and how many kinds of jumps are told.
UNDONE_BY, KINDS_TOLD = 4, 2
#: Neighbours, on each side, that an interval is compared with; two may be jumps, too.
AROUND = 4
#: Newton steps to the time in which a motion comes to a state, and relative error of a time.
STEPS, ALIKE = 6, 1e-3


@dataclass(frozen=True)
class Jump:
    """Where a motion jumps.

    Attributes
    ----------
    kind : jumps of one kind are counted together
    at : time of the first sample that is off the motion before it, s
    words : a sentence
    """

    kind: str
    at: float
    words: str


def jumps(data: Intervals, reach: int) -> list[Jump]:
    """Return the jumps of a motion, the first of each kind, with how many there are in words.

    None if there is none, or more than a tenth of all intervals are some.

    Parameters
    ----------
    data : all intervals that turn by less than `FAR`, with the noise of recorded numbers
    reach : samples on each side of a jump at which ω is wrong, as it is found by attitudes
    """
    off = data.apart(data.base.equations)
    left = np.sum((off / data.scale) ** 2, axis=1)
    # At either end ω is found by samples on one side of it, with larger errors.
    inner = range(reach, len(off) - reach)
    places, found = [k for k in _places(data, off, left) if k in inner], list[Jump]()
    while places:
        k, *later = places
        last = next((j for j in later[:UNDONE_BY] if _goes_on(data, k, j, left[k])), None)
        if last is None and not k and left[1] > LEFT**2 * left[0]:
            # What a filter makes of a start goes on in the samples after it.
            return []
        end = k
        while last is None and (near := [j for j in later if end < j <= end + 1 + 2 * reach]):
            end = near[0]
        if last is not None:
            found.append(_off(data, off, k, last))
        else:
            around = max(0, k - reach), min(end + reach, len(off) - 1)
            found.append(
                (_off_attitudes(data, *around) if reach else None)
                or _lost(data, *around)
                or (_stretch(data, off, k, end) if end > k else _jump(data, off, k))
            )
        places = [j for j in later if j > (last or end)]
    kinds = dict.fromkeys(one.kind for one in found)
    return [_counted([one for one in found if one.kind == kind]) for kind in kinds][:KINDS_TOLD]


def _places(data: Intervals, off: FloatArray, left: FloatArray) -> list[int]:
    """Return the intervals whose gain, (n, 6), is far beyond that of the others.

    Parameters
    ----------
    left : sum of squares of each gain, in units of its scale, (n,)
    """
    level = LEVEL / len(off)
    at_once = 1 + 5 * data.of_method
    is_beyond = left / at_once > chdtri(6 / at_once, level)
    # A method's error changes little from one interval to the next.
    in_noise = np.sqrt(np.sum((off / np.repeat(data.noise, 3)) ** 2, axis=1))
    around = np.lib.stride_tricks.sliding_window_view(np.pad(in_noise, AROUND), 2 * AROUND + 1)
    others = np.sort(around, axis=1)[:, -3]
    is_beyond |= in_noise > np.maximum(others, 1.0) / SAME
    if np.sum(is_beyond) > LEFT * len(off):
        return []
    squares = np.mean(off.reshape(-1, 2, 3) ** 2, axis=2)
    # Noise that a method's error nearly hides is larger at some of many samples.
    usual = np.mean(squares[~is_beyond], axis=0)
    is_beyond &= np.any(squares > usual / fdtri(3 * np.sum(~is_beyond), 3, level), axis=1)
    return [*map(int, np.flatnonzero(is_beyond))]


def _goes_on(data: Intervals, k: int, last: int, left: float) -> bool:
    """Whether the motion is after one interval, (last), where it was to be since another, (k).

    Parameters
    ----------
    left : sum of squares of the gain of that, in units of its scale
    """
    if not np.array_equal(data.starts[k + 1 : last + 1], data.ends[k:last]):
        return False
    spans = data.spans[k : last + 1].T
    after = follow(data.base.equations, data.starts[[k]], spans)[0, -1]
    off = apart(after[None], data.ends[[last]])[0] / data.scale[k]
    return bool(np.sum(off**2) < max(chdtri(6, LEVEL), LEFT**4 * left))


def _off(data: Intervals, off: FloatArray, k: int, last: int) -> Jump:
    """Return the samples that are off the motion before and after them."""
    first, count = data.t[k], last - k
    if count == 1:
        words = f"the sample at t = {first:.6g} s is off by {_size(off[k])}: leave it out"
    else:
        words = (
            f"{count} samples, from t = {first:.6g} s to {data.t[last - 1]:.6g} s, are off, the "
            f"first by {_size(off[k])}; after them the motion goes on as before: leave them out"
        )
    return Jump("off", first, words)


def _stretch(data: Intervals, off: FloatArray, k: int, end: int) -> Jump:
    """Return the intervals, one after the other, in which the motion goes on otherwise."""
    worst = off[k + int(np.argmax(norms(off[k : end + 1])))]
    right = worst[3:] / data.scale[k, 3:]
    how = "the attitude does not follow ω" if np.sum(right**2) < 1 else "it goes on otherwise"
    words = (
        f"from t = {data.t[k] - data.spans[k, 0]:.6g} s to {data.t[end]:.6g} s {how}, by up to "
        f"{_size(worst)} from one sample to the next"
    )
    return Jump("stretch", data.t[k], words)


def _off_attitudes(data: Intervals, first: int, last: int) -> Jump | None:
    """Return the attitudes that are off a motion that goes on after them; None if it does not.

    It goes on from the start of one interval to the end of another one; ω was not recorded.
    """
    spans = data.spans[first : last + 1].T
    made = follow(data.base.equations, data.starts[[first]], spans)[0]
    ends, scale = data.ends[first : last + 1], data.scale[first : last + 1]
    off = norms(apart(made, ends)[:, :3])
    is_off = (off / scale[:, 0]) ** 2 > chdtri(3, LEVEL)
    if is_off[-1] or not is_off.any():
        return None
    at, size = data.t[first : last + 1][is_off], float(np.degrees(off.max()))
    words = f"the sample at t = {at[0]:.6g} s is off by {size:.3g}°: leave it out"
    if len(at) > 1:
        words = (
            f"{len(at)} samples, from t = {at[0]:.6g} s to {at[-1]:.6g} s, are off by up to "
            f"{size:.3g}°: leave them out"
        )
    return Jump("off", at[0], words)


def _lost(data: Intervals, first: int, last: int) -> Jump | None:
    """Return the time by which a motion goes on further than its times; None if it does not.

    It does from the start of one interval to the end of another one.
    """
    spans, moved = data.spans[first : last + 1, 0], _moved(data, first, last)
    if moved is None:
        return None
    at, span = data.t[(first + last) // 2], float(np.median(spans))
    more = moved - float(spans.sum())
    lost = round(more / span)
    if 0 < lost <= MOST_LOST and abs(more - lost * span) < ALIKE * span:
        samples = "1 sample is" if lost == 1 else f"{lost} samples are"
        words = f"{samples} lost before t = {at:.6g} s, or its time is too early"
        return Jump("lost", data.t[first], words)
    begun = data.t[first] - data.spans[first, 0]
    words = (
        f"from t = {begun:.6g} s to {data.t[last]:.6g} s the motion goes on by {moved:.4g} s, and "
        f"the times by {spans.sum():.4g} s"
    )
    return Jump("clock", data.t[first], words)


def _jump(data: Intervals, off: FloatArray, k: int) -> Jump:
    """Return what a jump that lasts may come from."""
    at = data.t[k]
    if not k:
        words = (
            f"the first sample is off what follows by {_size(off[0])}, as where a state is written "
            "before an engine corrects it, or by a step that begins wrongly"
        )
        return Jump("first", at, words)
    like = "a state is set, or something strikes it"
    if np.sum((off[k, 3:] / data.scale[k, 3:]) ** 2) < 1:
        like = "the attitude alone is set, or an angle is read from another branch"
    return Jump("jump", at, f"at t = {at:.6g} s it jumps, by {_size(off[k])}, as where {like}")


def _moved(data: Intervals, first: int, last: int) -> float | None:
    """Return the time in which the motion comes from one interval's start to another's end, s."""
    start, end, equations = data.starts[[first]], data.ends[[last]], data.base.equations
    speeds = norms(np.vstack([start, end])[:, 4:])
    if not speeds.all():
        return None
    moved = float(norms(rotation_vectors(start[:, :4], end[:, :4]))[0] / speeds.mean())
    for _ in range(STEPS):
        made = follow(equations, start, np.array([[moved]]))[:, 0]
        omega = made[0, 4:]
        moved += float(rotation_vectors(made[:, :4], end[:, :4])[0] @ omega / (omega @ omega))
    made = follow(equations, start, np.array([[moved]]))[0, 0]
    is_later = moved > 0 and np.isfinite(made).all()
    return moved if is_later and _is_near(made, end[0], data.scale[last]) else None


def _counted(alike: Sequence[Jump]) -> Jump:
    """Return the first of jumps of one kind, and in its words how many there are."""
    first, count = alike[0], len(alike)
    if count == 1:
        return first
    also = f"(one of {count} such places, the last at {alike[-1].at:.6g} s)"
    return replace(first, words=f"{first.words} {also}")


def _is_near(made: FloatArray, recorded: FloatArray, scale: FloatArray) -> bool:
    off = apart(made[None], recorded[None])[0] / scale
    return bool(np.sum(off**2) < chdtri(6, LEVEL))


def _size(off: FloatArray) -> str:
    turned, faster = (0.0 if size < FITS else size for size in norms(off.reshape(2, 3)))
    return f"{np.degrees(turned):.3g}° and {faster:.3g} rad/s"
