"""Bias of rounding: errors by it grow as 1/Δt, errors by random rounding as 1/√Δt."""

from collections.abc import Iterator

import numpy as np

from .report_data import MethodRuns

#: Relative ulp of single precision.
ULP = float(np.finfo(np.float32).eps)
#: Conserved momenta, whose drift is relative to their own size.
MOMENTA = ("L_norm", "L_vertical", "L_axial")
#: Number of runs, each at half the timestep of the one before, that must show the same drift a
#: step; and the factor within which it must be the same. Over three runs, random rounding would
#: halve the drift a step, and a method's own error would fall to a quarter or less.
RUNS, ALIKE = 3, 2**0.5
#: Least drift of a run that counts as biased, in units of what random rounding by one ulp a step
#: adds up to, √steps ulp.
WALK = 4.0
#: Largest drift a step that counts as rounding, ulp; a larger one has another cause.
MOST = 64.0


def rounding_bias(runs: MethodRuns) -> float | None:
    """Return the bias of a method's rounding: the drift of a momentum a step, ulp of 24 bits.

    A drift counts as a bias if it is larger than random rounding makes it, and if the drift a step
    is about the same in the finest `RUNS` runs of the ladder: rounding in one direction adds the
    same in every step, however long the step.

    Returns
    -------
    The largest bias of any conserved momentum, in the finest run; None if there is no bias.
    """
    return max(_biases(runs), default=None)


def _biases(runs: MethodRuns) -> Iterator[float]:
    """Yield the drift a step, ulp, of each momentum that drifts by biased rounding."""
    ladder = [row for row in runs.rows if row.errors and row.drifts and not row.stock][-RUNS:]
    for name in MOMENTA:
        drifts = [(row.drifts or {}).get(name) for row in ladder]
        a_step = [
            drift / row.steps / ULP for row, drift in zip(ladder, drifts, strict=True) if drift
        ]
        if len(a_step) < RUNS or max(a_step) > ALIKE * min(a_step):
            continue
        if a_step[-1] * np.sqrt(ladder[-1].steps) > WALK and a_step[-1] <= MOST:
            yield a_step[-1]
