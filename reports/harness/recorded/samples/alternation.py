"""Finds errors that alternate from sample to sample: noise, or those of an integrator in ω."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

from .....reference.other_equations import equations_of
from .....scenarios import FloatArray, Scenario, Trajectory
from .....scenarios.rotation import norms
from ...explaining.search import LEFT
from .digits import runs
from .intervals import NEAR, derivatives_of_flow, deviations_from_flow, states_of

#: Least number of samples in which alternation can be found.
FEWEST = 12
#: Variance of fourth differences of noise, in units of the noise's variance, by the lag of the
#: differences, if the flow carries a small change of a state on unchanged. At a lag of one sample
#: it is Σ (4 over k)². At a lag of two samples only the first difference is between neighbours:
#: the operator is (1 − B)(1 − B²)³, with the shift B by a sample.
OF_DIFFERENCES = {1: 70.0, 2: 40.0}
#: Neighbouring fourth differences share noise, so that their degrees of freedom are fewer than the
#: differences, by the factor Σ (8 over 4+k)² / (8 over 4)².
SHARED = 2.63
#: Least ratio of fourth to third differences of errors that alternate. For noise it is √3.5 at a
#: lag of one sample and √(10/3) at two. For smooth errors it is less than the angle by which the
#: body turns between the samples, which is less than 2 `NEAR`.
ALTERNATES = 1.4
#: Size of the fourth differences of a number that alternates between 1 and −1.
ALTERNATING = 16.0
#: Noise must exceed this fraction of the bound on the error of rounded numbers; their standard
#: deviation is some fifty times smaller than the bound.
PRINTED = 0.2
#: An alternation that is no noise is reported if it exceeds the least noise by this factor, as the
#: rounding errors of single precision alternate, too.
CLEARLY = 25.0
#: The least noise of a measured attitude, rad, and of a measured ω, relative to the largest ‖ω‖.
#: Smaller errors are those of an integrator, or of its interpolation.
LEAST = 1e-6


@dataclass(frozen=True, eq=False)
class Alternation:
    """The part of a motion's errors that alternates from sample to sample.

    The errors are deviations from the exact flow that begins at the sample before. They are smooth
    if the motion was computed, whatever is wrong with it. They alternate if it was measured, even
    if only every second sample is taken.

    Attributes
    ----------
    every : root mean squares of third differences of samples, first row, and of fourth differences,
        second row; of attitude, rad, and of ω, rad/s, in columns, (2, 2). The errors count as first
        differences
    every_second : the same if further differences are taken with a lag of two samples, (2, 2)
    throughout : whether most samples contribute to the fourth differences, for attitude and for ω,
        (2,); otherwise these may be due to a single jump
    noise : standard deviations of attitude, rad, and ω, rad/s, (2,), if the alternation is noise
    least : least standard deviation that counts as noise of attitude, rad, and ω, rad/s, (2,);
        less may be rounding or an integrator's interpolation
    """

    every: FloatArray
    every_second: FloatArray
    throughout: NDArray[np.bool_]
    noise: FloatArray
    least: FloatArray

    @property
    def is_noise(self) -> NDArray[np.bool_]:
        """Whether the errors that alternate are noise, for attitude and for ω, (2,)."""
        alternates = self._alternates(self.every, 1) & self._alternates(self.every_second, 2)
        return np.asarray(alternates & self.throughout)

    @property
    def of_omega(self) -> list[str]:
        """A list of the sentence that ω alternates, but not as noise does.

        The list is empty if ω does not alternate, if it does so like noise, or if it does so hardly
        more than by rounding.
        """
        alternates = self._alternates(self.every, 1)[1] and self.throughout[1]
        if not alternates or self.is_noise[1] or self.noise[1] < CLEARLY * self.least[1]:
            return []
        size = np.sqrt(3) * self.every[1, 1] / ALTERNATING
        return [
            f"ω alternates from one sample to the next, by ± {size:.2g} rad/s, which is no noise: "
            "so it does by the trapezoidal rule from accelerations that are not the motion's"
        ]

    def _alternates(self, differences: FloatArray, lag: int) -> NDArray[np.bool_]:
        """Return whether differences are those of errors that alternate, for attitude and ω, (2,).

        Parameters
        ----------
        differences : `every` or `every_second`
        lag : the lag of these differences: 1 or 2 samples
        """
        third, fourth = differences
        is_more = fourth > self.least * np.sqrt(OF_DIFFERENCES[lag])
        return np.asarray((fourth > ALTERNATES * third) & is_more)


def alternation(scenario: Scenario, motion: Trajectory, floor: FloatArray) -> Alternation | None:
    """Return the part of a motion's errors that alternates from sample to sample.

    Only the longest part of the motion is used in which the body turns by less than `NEAR` from
    sample to sample. None is returned if it has too few samples, or if its flow leaves the range
    of doubles.

    Parameters
    ----------
    motion : the recorded motion
    floor : errors of attitude, rad, and ω, rad/s, by the rounding of printed numbers, (2,)
    """
    # Fast rotors or a strong torque make the body nutate faster than it turns; drag does not.
    nutating = [one.rate(scenario) for one in scenario.acting if not one.decay(scenario)]
    speeds = norms(motion.omega_body)
    is_near = np.maximum(speeds, max(nutating, default=0.0)) * np.median(np.diff(motion.t)) < NEAR
    near = max(runs(is_near[1:]), key=lambda run: run[1] - run[0], default=(0, 0))
    if near[1] + 1 - near[0] < FEWEST:
        return None
    motion = motion.at(np.arange(near[0], near[1] + 1))
    fastest = float(norms(motion.omega_body).max())
    # These deviations are already differences of the noise of two samples.
    deviations = deviations_from_flow(scenario, motion)
    least = np.maximum(PRINTED * floor, LEAST * np.array([1.0, fastest]))
    squares = [_differences(deviations, lag) for lag in OF_DIFFERENCES]
    every, every_second = (
        np.sqrt(np.array([np.mean(one, axis=0) for one in two])) for two in squares
    )
    fourth = squares[0][1]
    throughout = np.median(fourth, axis=0) > LEFT * np.mean(fourth, axis=0)
    units = np.array([1.0, fastest or 1.0])
    variances = _variances_of_differences(scenario, motion, units[1])
    if not (np.isfinite(variances).all() and np.isfinite(every).all()):
        return None
    seen = (every[1] / units) ** 2
    # Noise in one quantity that hides in what noise in the other one makes may be as large as the
    # standard error of the differences' mean square.
    hidden = np.sqrt(2 * SHARED / (3 * len(fourth))) * seen / np.diag(variances)
    noise = units * np.sqrt(np.maximum(nnls(variances, seen)[0], hidden))
    return Alternation(every, every_second, throughout, noise, least)


def _variances_of_differences(scenario: Scenario, motion: Trajectory, unit: float) -> FloatArray:
    """Return the variances of fourth differences that noise of variance one causes, (2, 2).

    Those of attitude are in the first row and those of ω in the second one; the first column is by
    noise of attitude, and the second one by noise of ω. The flow carries the noise of a sample, n,
    on to the next one as Φ n, where drag may damp it. So the operator is (1 − B)³ (1 − Φ B), with
    the shift B by a sample, and the variance of a component is 20 + 30 tr Φ / 3 + 20 ‖Φ‖² / 3, with
    the Frobenius norm. This is `OF_DIFFERENCES` where Φ = 1. Noise of the other quantity causes
    only the last term.

    Parameters
    ----------
    unit : the unit of ω, rad/s
    """
    states, spans = states_of(motion)[:-1], np.diff(motion.t)
    every = derivatives_of_flow(equations_of(scenario), states, spans, unit)
    derivatives = every.reshape(-1, 2, 3, 2, 3)
    squares = np.median(np.sum(derivatives**2, axis=(2, 4)), axis=0)
    traces = np.median(np.einsum("siajb,ij,ab->si", derivatives, np.eye(2), np.eye(3)), axis=0)
    return np.asarray(20 * squares / 3 + np.diag(20 + 30 * traces / 3))


def _differences(first: FloatArray, lag: int) -> list[FloatArray]:
    """Return the squares of the third and of the fourth differences of attitude and ω.

    They are means over the three components: (n − 2 lag, 2) and (n − 3 lag, 2).

    Parameters
    ----------
    first : the n first differences of attitude, rad, and ω, rad/s, (n, 6)
    lag : the lag of each further difference, d[k + lag] − d[k], in samples
    """
    squares, differences = [], first
    for _ in range(3):
        differences = differences[lag:] - differences[:-lag]
        squares.append(np.mean(differences.reshape(-1, 2, 3) ** 2, axis=2))
    return squares[1:]
