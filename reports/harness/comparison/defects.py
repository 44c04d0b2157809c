"""The defects of a run: the differences from the exact flow that arise between two samples.

The exact motion that starts in a sample of the run is followed to the time of the next sample, and
its state there is compared with that sample. Earlier errors do not count. So a defect is meaningful
even where a motion is chaotic or errors have saturated, and a fault shows in the interval in which
it acts (W. H. Enright, J. Comput. Appl. Math. 125 (2000) 159; L. F. Shampine, J. Comput. Appl.
Math. 175 (2005) 195). The intervals cover the whole run, so that no fault is missed.

Defects are measured in the same norms as errors, relative to the same scales of the exact motion.
"""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from ....reference import IntegrationError, flow
from ....scenarios import Errors, ErrorSeries, FloatArray, Scenario, Trajectory
from ....scenarios.agreement import ErrorNorm, norm_of
from ....scenarios.fastest_rate import fastest_rate
from ....scenarios.mechanics import RECENT
from ...results.records import Defect, Row

#: Largest turn of a motion, rad, whose defects are computed: more would take over a second.
FARTHEST_TURN = 1e5
#: Least rounding error of a step, relative: it is several ulp, as a step has several products.
LEAST_ROUNDING = 8 * float(np.finfo(float).eps)
#: Relative noise of a step that is no fault: the tolerance of iterative solvers.
NOISE = 1e-12
#: Least turn in an interval, relative to the exact motion's mean, of a body that is not at rest.
MOVING = 1e-3


@dataclass(frozen=True, eq=False)
class Defects:
    """The defects of a run with n samples.

    Attributes
    ----------
    t : ends of the intervals between samples, s, (n − 1,)
    series : the defects in these intervals
    rounding : the largest defects of the exact motion itself, rounded to doubles: how far rounding
        errors at the beginning of an interval grow until its end
    """

    t: FloatArray
    series: ErrorSeries
    rounding: Errors

    def summary(self, steps: int, ulp: float) -> dict[str, Defect]:
        """Return median, 95th percentile and largest of each signal's defects, by its name.

        The time of the largest is added, and the floor, up to which rounding may cause defects. The
        floor grows as the root of the number of steps in an interval, like a random walk.

        Parameters
        ----------
        steps : number of steps of the whole run
        ulp : relative spacing of the engine's floating-point numbers
        """
        step = max(ulp, NOISE) / np.finfo(float).eps
        roundings = np.sqrt(1 + steps / len(self.t)) * step
        p50, p95 = np.percentile(self.series.distances, [50, 95], axis=0, method="higher")
        largest, at = self.series.distances.max(axis=0), self.series.distances.argmax(axis=0)
        return {
            name: Defect(*map(float, (p50[k], p95[k], largest[k], self.t[at[k]], roundings * ulps)))
            for k, (name, ulps) in enumerate(self.rounding)
        }

    def attitude_a_turn(self, motion: Trajectory, usual: float) -> float | None:
        """Return the median over the intervals of the attitude's defect per turn of the run, rad.

        In each interval the defect is divided by the number of turns that the run makes there.
        Intervals in which the run is at rest are left out, as a run that has stopped would seem
        exact. None is returned if all intervals are left out.

        Parameters
        ----------
        motion : the run
        usual : mean number of turns of the exact motion between two samples
        """
        turns = turns_made(motion)
        moves = turns > MOVING * usual
        if not moves.any():
            return None
        return float(np.median(self.series["attitude"][moves] / turns[moves]))


def defects(scenario: Scenario, motion: Trajectory, exact: Trajectory) -> Defects | None:
    """Return the defects of a run; None if they cannot be computed.

    They cannot if the run has only one sample, if the body turns by more than `FARTHEST_TURN` in
    the whole run, or if the exact motion from one of its samples cannot be found.

    Parameters
    ----------
    motion : the run
    exact : the exact motion at the run's samples, or at more times
    """
    turn = fastest_rate(scenario, motion.omega_body) * float(motion.t[-1])
    if len(motion.t) < 2 or turn > FARTHEST_TURN:
        return None
    try:
        series = _series(scenario, motion, exact)
        rounding = _rounding(scenario, exact)
    except IntegrationError:
        return None
    return Defects(motion.t[1:], series, rounding)


def with_defects(row: Row, scenario: Scenario, exact: Trajectory, *, is_single: bool) -> Row:
    """Return a row with the run's defects added, and the median of the attitude's defect per turn.

    The row is returned unchanged if it has no motion or no errors, or if the defects cannot be
    computed.

    Parameters
    ----------
    exact : the exact motion at the run's samples, or at more times
    is_single : whether the engine computes in single precision
    """
    if row.motion is None or row.errors is None:
        return row
    found = defects(scenario, row.motion, exact)
    if found is None:
        return row
    ulp = float(np.finfo(np.float32 if is_single else np.float64).eps)
    by_signal = found.summary(row.steps, ulp)
    added = found.attitude_a_turn(row.motion, turns_made(exact).mean())
    return replace(row, defects=by_signal, attitude_a_turn=added)


def turns_made(motion: Trajectory) -> FloatArray:
    """Return the number of turns, of 2π rad, from each of n samples to the next, (n − 1,)."""
    rates = np.linalg.norm(motion.omega_body, axis=1)
    turns: FloatArray = (rates[1:] + rates[:-1]) / (4 * np.pi) * np.diff(motion.t)
    return turns


@lru_cache(maxsize=RECENT)
def _rounding(scenario: Scenario, exact: Trajectory) -> Errors:
    """Return the largest defect of the exact motion in each signal, due to rounding to doubles.

    At least `LEAST_ROUNDING` is returned.
    """
    of_exact = _series(scenario, exact, exact).worst()
    return Errors(**{name: max(value, LEAST_ROUNDING) for name, value in of_exact})


def _series(scenario: Scenario, motion: Trajectory, exact: Trajectory) -> ErrorSeries:
    """Return the defects of a motion in every interval between its samples.

    Their norms are those of errors, relative to the scales of the exact motion.

    Parameters
    ----------
    exact : the exact motion from the scene's start
    """
    flowed = flow(scenario, motion, np.diff(motion.t))
    made, right = (ErrorNorm(scenario, one).true_table for one in (motion, flowed))
    norm = norm_of(scenario, exact)
    return ErrorSeries(norm.signals, norm.distances(made[1:], right))
