"""Finds columns of ω that stay the same to the last digit, though the body's ω changes."""

import numpy as np

from .....scenarios import FloatArray
from .digits import CHANGES, Numbers, Shown, runs, where

#: Least number of equal samples of a column that is stuck. Fewer may fill up one end of an ω that
#: is up to five samples older or newer than the attitude.
FEWEST = 7
#: A gyroscope saturates only if the body turns faster, on average, than the largest rate that was
#: read: by this fraction of that rate, and by this number of standard errors of the average.
FASTER, CERTAIN = 1e-2, 6.0
#: The sentence on a gyroscope that saturates, with the components and the rate in rad/s and in °/s;
#: and the words for all components.
SATURATES = "the gyroscope saturates: {} is clamped to {:.6g} rad/s ({:.4g} °/s)"
EACH = "each component of ω"


def stuck(numbers: Numbers, omega: FloatArray) -> Shown | None:
    """Return the finding that a column of ω is stuck for some samples; None if none is.

    A stuck column stays the same, though the attitudes show that this component of ω changes. A
    column that stays at the largest value of all columns is not stuck, but clamped.

    Parameters
    ----------
    numbers : the columns of the recording, with those of the exact motion
    omega : ω of the n samples as in the file, rad/s, (n, 3)
    """
    bound, least = float(np.abs(omega).max()), CHANGES * numbers.step_omega
    if not np.ptp(omega, axis=0).any():
        # An ω that is constant in all columns may be right, as without a gyroscopic torque.
        return None
    for axis in range(3):
        column, exact = omega[:, axis], numbers.omega_exact[:, axis]
        a, b = max(runs(column[1:] == column[:-1]), key=lambda run: run[1] - run[0], default=(0, 0))
        if b + 1 - a < FEWEST or abs(column[a]) == bound:
            continue
        changes = float(np.ptp(exact[a : b + 1]))
        # A method's error makes the attitudes turn at a constant other rate, which is no change.
        change_shown = float(np.ptp(numbers.rates[a:b, axis]))
        # A constant component of the exact ω may have been recorded in another column.
        if (np.abs(np.abs(numbers.omega_exact) - abs(column[a])).max(axis=0) < least).any():
            continue
        # If the body has another tensor, ω may be constant. The attitudes then agree with it.
        if changes > least and change_shown > changes / 2:
            how = "dead" if not column[a] else "stuck"
            return Shown(
                f"w{'xyz'[axis]} is {column[a]:.6g} rad/s, to the last digit, "
                f"{_when(numbers.t, a, b)}, though the attitudes show it change: its column is "
                f"{how}",
                np.arange(a + 1 if a else 0, b + 1),
            )
    return None


def saturated(numbers: Numbers, omega: FloatArray) -> Shown | None:
    """Return the finding that a gyroscope saturates; None if it does not.

    If it does, ω stays at its largest value while the attitudes turn faster. If the body's own ω
    were clamped, the attitudes would turn no faster than that.

    Parameters
    ----------
    numbers : the columns of the recording, with those of the exact motion
    omega : ω of the n samples as in the file, rad/s, (n, 3)
    """
    every = [(EACH, slice(None)), *((f"w{name}", slice(k, k + 1)) for k, name in enumerate("xyz"))]
    return next(filter(None, (_saturated(numbers, omega, *which) for which in every)), None)


def _saturated(numbers: Numbers, omega: FloatArray, which: str, columns: slice) -> Shown | None:
    """Return the finding that some columns of ω saturate; None if they do not.

    Parameters
    ----------
    numbers : the columns of the recording, with those of the exact motion
    omega : ω of the n samples as in the file, rad/s, (n, 3)
    which, columns : the columns, in words and as a slice
    """
    some = omega[:, columns]
    bound = float(np.abs(some).max())
    is_at_bound = np.abs(some) == bound
    # A component that is constant throughout may be the motion's own.
    constant = max(numbers.resolution_omega, CHANGES * float(np.finfo(float).eps) * bound)
    is_cut = is_at_bound & (np.ptp(some, axis=0) > constant)
    is_between = is_cut[1:] & (some[1:] == some[:-1])
    excess = (numbers.rates[:, columns] * np.sign(some[1:]))[is_between] - bound
    if len(excess) < FEWEST:
        return None
    error = float(np.std(excess)) / np.sqrt(len(excess))
    if np.mean(excess) < max(FASTER * bound, CERTAIN * error):
        return None
    samples = np.flatnonzero(is_at_bound.any(axis=1))
    return Shown(
        f"{SATURATES.format(which, bound, np.degrees(bound))}, {where(numbers.t, samples)}, and "
        "the attitudes turn faster",
        samples,
    )


def _when(t: FloatArray, a: int, b: int) -> str:
    """Return in words the times and the number of the samples with indices from `a` to `b`.

    Parameters
    ----------
    t : times of all n samples, s, (n,)
    a, b : indices of the first and of the last of the samples
    """
    count, is_to_end = b + 1 - a, b == len(t) - 1
    if is_to_end:
        return f"from t = {t[a]:.6g} s on, for {count} samples" if a else f"in all {count} samples"
    return f"from t = {t[a]:.6g} s to {t[b]:.6g} s, for {count} samples"
