"""The observed order of accuracy: how errors shrink with the timestep."""

import numpy as np

from ....scenarios import FloatArray

#: Larger errors are not in the asymptotic range: those of directions, for example, are bounded.
ASYMPTOTIC = 0.1
#: Orders that differ by less than this count as equal.
ORDER_SLACK = 0.25
#: An order is fitted to errors that are larger than this many times the reference's uncertainty.
ABOVE_UNCERTAINTY = 100.0
#: Number of rungs of the ladder to which an order is fitted.
FITTED_RUNGS = 3
#: If the order is below this, errors count as not shrinking.
SETTLING_ORDER = 0.5


def observed_order(
    timesteps: FloatArray, errors: FloatArray, roundoff_bounds: FloatArray, uncertainty: float
) -> float | None:
    """Return the order with which errors shrink: the slope of log error against log timestep.

    Errors are usable if they are in the asymptotic range, above round-off, and above
    `ABOVE_UNCERTAINTY` times the reference's uncertainty. The slope, with its sign, is fitted by
    least squares to `FITTED_RUNGS` usable errors at successive timesteps. If only two errors are
    usable, the slope between them is returned.

    There may be several such groups of three errors. A group is straight if the slopes between its
    neighbours differ by at most `ORDER_SLACK`. The finest straight group whose errors shrink is
    used; if none shrinks, the finest straight group; if none is straight, the straightest group,
    since rounding bends the finest ones.

    Parameters
    ----------
    timesteps : s, coarse to fine, (n,)
    errors : the error at each timestep, (n,)
    roundoff_bounds : the largest error by round-off at each timestep, in the unit of the errors,
        (n,)
    uncertainty : uncertainty of the reference, in the unit of the errors

    Returns
    -------
    The slope; None if fewer than two errors are usable.
    """
    usable = (
        (errors > ABOVE_UNCERTAINTY * uncertainty)
        & (errors > roundoff_bounds)
        & (errors < ASYMPTOTIC)
    )
    rungs = np.flatnonzero(usable)
    if len(rungs) < 2:
        return None
    log_timesteps, log_errors = np.log(timesteps[rungs]), np.log(errors[rungs])
    slopes = np.diff(log_errors) / np.diff(log_timesteps)
    if len(slopes) < FITTED_RUNGS - 1:
        return float(slopes[0])
    bends = np.abs(np.diff(slopes))
    straight = np.flatnonzero(bends <= ORDER_SLACK)
    sloping = straight[slopes[straight + 1] >= SETTLING_ORDER]
    if len(sloping):
        straight = sloping
    start = int(straight[-1]) if len(straight) else int(np.argmin(bends))
    window = slice(start, start + FITTED_RUNGS)
    return float(np.polyfit(log_timesteps[window], log_errors[window], 1)[0])
