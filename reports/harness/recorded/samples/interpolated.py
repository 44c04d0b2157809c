"""Finds samples whose ω was not recorded, but held or interpolated linearly from other samples."""

import numpy as np

from .....scenarios import FloatArray
from .....scenarios.rotation import norms
from .digits import CHANGES, Numbers, Shown, runs, where

#: Least number of samples at which ω is new; least number of successive samples on one line.
FEWEST, FEWEST_ON_A_LINE = 3, 2


def interpolated(numbers: Numbers) -> Shown | None:
    """Return the finding that recorded ω is held or interpolated linearly at some samples.

    None is returned if it is not. Held values repeat those of the sample before. Interpolated ones
    are on a straight line between others, to the last digit.
    """
    if numbers.omega is None or len(numbers.t) < FEWEST:
        return None
    t, omega = numbers.t, numbers.omega
    if hold := _zero_order_hold(numbers, omega):
        return hold
    every = _lines(t, omega, numbers.omega_exact, 2 * numbers.resolution_omega)
    lengths = np.unique([b - a for a, b in every])
    if len(every) >= FEWEST and len(lengths) == 1:
        count = int(lengths[0]) + 1
        # At either end a line may be missing.
        if len(t) <= 1 + (len(every) + 2) * count:
            return _at_one_in(count, "interpolated linearly", every[0][0], len(t))
    # Of a sensor that counts, equal samples in succession are frequent.
    every = _lines(t, omega, numbers.omega_exact, 2 * numbers.step_omega)
    gaps = [(a, b) for a, b in every if b - a >= FEWEST_ON_A_LINE]
    if not gaps:
        return None
    samples = np.concatenate([np.arange(a + 1, b + 1) for a, b in gaps])
    of_gaps = f", in {len(gaps)} gaps" if len(gaps) > 1 else ""
    if not np.abs(omega[samples] - omega[samples - 1]).any():
        # The last sample that is held is not on the line, which has its kink there.
        ends = np.array([b + 1 for _, b in gaps])
        samples = np.union1d(samples, ends[(omega[ends] == omega[ends - 1]).all(axis=1)])
        return Shown(
            f"ω is held, as in the sample before, {where(t, samples)}{of_gaps}: leave it out",
            samples,
        )
    return Shown(
        f"ω is on a straight line from the sample before to the one after {where(t, samples)}"
        f"{of_gaps}: what was lost was interpolated; leave it out",
        samples,
    )


def _zero_order_hold(numbers: Numbers, omega: FloatArray) -> Shown | None:
    """Return the finding that ω is new at every m-th sample only, and held at the others.

    None is returned if it is not, for any m.

    Parameters
    ----------
    numbers : the columns of the recording, with those of the exact motion
    omega : ω of the n samples as in the file, rad/s, (n, 3)
    """
    changes = norms(np.diff(omega, axis=0))
    least = CHANGES * numbers.resolution_omega
    new = np.flatnonzero(changes > least)
    count = int(np.median(np.diff(new))) if len(new) >= FEWEST else 1
    # An ω that changes at every sample, and later at none, is that of a body that comes to rest.
    # One that changes at samples of no regular distance is that of a sensor that counts.
    if np.any(new % count != new[:1] % count):
        return None
    if count > 1 and np.sum(changes <= least / CHANGES) >= (count - 1) * (len(new) - 1):
        return _at_one_in(count, "held", int(new[0]) + 1, len(omega))
    return None


def _at_one_in(count: int, how: str, first: int, samples: int) -> Shown:
    """Return the finding that ω is new at one sample in `count` only.

    Parameters
    ----------
    how : words on ω at the other samples, such as "held"
    first : index of the first sample at which ω is new
    samples : the number of all samples
    """
    words = f"ω is {how}: it is new at one sample in {count} only; record those alone"
    return Shown(words, np.flatnonzero((np.arange(samples) - first) % count))


def _lines(
    t: FloatArray, omega: FloatArray, exact: FloatArray, least: float
) -> list[tuple[int, int]]:
    """Return the straight lines of a recorded ω that begin or end with a kink.

    The bend of ω at a sample is its deviation from the straight line between its neighbours. A
    sample is on a line if the recorded ω bends there by no more than rounding, but should bend far
    more: as the exact ω does there, or as the recorded ω does at most samples because of noise.

    Parameters
    ----------
    t : times of the n samples, s, (n,)
    omega, exact : recorded and exact ω, rad/s, (n, 3)
    least : the largest bend by rounding, rad/s

    Returns
    -------
    For each line the index of the sample before the first one on it, and of the last one on it
    """
    fraction = ((t[1:-1] - t[:-2]) / (t[2:] - t[:-2]))[:, None]

    def bends(one: FloatArray) -> FloatArray:
        return norms(one[1:-1] - (1 - fraction) * one[:-2] - fraction * one[2:])

    recorded = bends(omega)
    is_kink = recorded > CHANGES * least
    should = (bends(exact) > CHANGES * least) | (np.median(recorded) > CHANGES * least)
    every = runs((recorded <= least) & should)
    inner = [(a, b) for a, b in every if a and b < len(is_kink)]
    return [(a, b) for a, b in inner if is_kink[a - 1] or is_kink[b]]
