"""Biased rounding, whose errors grow as 1/Δt; errors of random rounding grow as 1/√Δt."""

from collections.abc import Iterator

import numpy as np

from .report_data import MethodRuns

#: Relative ulp of single precision.
ULP = float(np.finfo(np.float32).eps)
#: Conserved momenta, whose drift is relative to their own size.
MOMENTA = ("L_norm", "L_vertical", "L_axial")
#: Number of runs, each with half the timestep of the one before, that must show the same drift a
#: step, and within which factor: by rounding at random it would halve over three runs, and by a
#: method's own error fall to a quarter or less.
RUNS, ALIKE = 3, 2**0.5
#: Least drift of a run, in units of what rounding at random by an ulp a step comes to.
WALK = 4.0
#: Most ulp a step that are called rounding; more have another cause.
MOST = 64.0


def rounding_bias(runs: MethodRuns) -> float | None:
    """Return the bias of a method's rounding: the drift of a momentum in a step, ulp of 24 bits.

    Returns
    -------
    The largest such drift of any conserved momentum, in the finest run; None unless the drift a
    step is the same in the finest runs, as by rounding that is always in one direction.
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
