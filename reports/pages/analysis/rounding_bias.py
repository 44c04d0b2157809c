"""Biased rounding, whose errors grow as 1/Δt; errors of random rounding grow as 1/√Δt."""

from collections.abc import Iterator

import numpy as np

from .report_data import MethodRuns

#: Relative ulp of single precision.
ULP = float(np.finfo(np.float32).eps)
#: Conserved momenta, whose drift is relative to their own size.
MOMENTA = ("L_norm", "L_vertical", "L_axial")
#: Number of runs, each with half the timestep of the one before, that must show the same drift a
#: step, and the factor within which it must be the same. By rounding at random the drift a step
#: would halve over three runs, and by a method's own error fall to a quarter or less.
RUNS, ALIKE = 3, 2**0.5
#: Least drift of a run that counts as biased, in units of what rounding at random by one ulp a step
#: adds up to: the square root of the number of steps, in ulp.
WALK = 4.0
#: Largest drift a step that counts as rounding, ulp; a larger one has another cause.
MOST = 64.0


def rounding_bias(runs: MethodRuns) -> float | None:
    """Return the bias of a method's rounding: the drift of a momentum in a step, ulp of 24 bits.

    A drift counts as a bias if it is the same in each step in the finest `RUNS` runs of the ladder,
    as by rounding that is always in one direction.

    Returns
    -------
    The largest bias of any conserved momentum, in the finest run; None if there is none.
    """
    return max(_biases(runs), default=None)


def _biases(runs: MethodRuns) -> Iterator[float]:
    """Yield the drift per step, ulp, of each momentum whose drift is by biased rounding."""
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
