"""Finds what alternates from sample to sample of a recorded motion: noise, or an integrator's ω."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .....scenarios import FloatArray, Scenario, Trajectory
from .....scenarios.rotation import norms
from ...explaining.search import LEFT
from .intervals import NEAR, deviations_from_flow

#: Least number of samples in which alternation can be found.
FEWEST = 12
#: Variance of fourth differences of noise, in variances of the noise, by their lag: Σ (4 over k)²
#: at a lag of one sample. At a lag of two samples, three of the four differences are between every
#: second sample: the operator is (1 − B)(1 − B²)³, where B takes the sample before.
OF_DIFFERENCES = {1: 70.0, 2: 40.0}
#: Least ratio of fourth to third differences in what alternates. Noise has √3.5 and √(10/3); in
#: what is smooth the ratio is less than the angle between samples, and two samples are less than
#: `NEAR` apart.
ALTERNATES = 1.4
#: Size of the fourth differences of what alternates between ± 1.
ALTERNATING = 16.0
#: The factor by which noise must exceed the bound of the rounding of printed numbers to be more
#: than that rounding, whose standard deviation is some fifty times smaller than the bound.
PRINTED = 2.0
#: The factor by which an alternation that is no noise must exceed the least noise to be named: the
#: rounding errors of single precision alternate, too.
CLEARLY = 25.0
#: The least noise of a measured attitude, rad, and of a measured ω, relative to the largest ‖ω‖:
#: what is less is the error of an integrator, or of its interpolation.
LEAST = 1e-6


@dataclass(frozen=True, eq=False)
class Alternation:
    """What alternates from sample to sample, beyond the exact flow from the sample before.

    The deviations from that flow are smooth along a motion that was computed, whatever is wrong
    with the motion. Along a motion that was measured they alternate, even if only every second
    sample is taken.

    Attributes
    ----------
    every, every_second : root mean squares of third differences, first row, and of fourth ones,
        second row, in the columns of attitude, rad, and ω, rad/s; of every sample or of every
        second one, (2, 2)
    throughout : whether most samples contribute to the fourth differences, so that these are not
        due to a single jump, for attitude and for ω, (2,)
    least : least size that counts as noise, above rounding and the error of an integrator's
        interpolation, rad and rad/s, (2,)
    """

    every: FloatArray
    every_second: FloatArray
    throughout: NDArray[np.bool_]
    least: FloatArray

    @property
    def noise(self) -> FloatArray:
        """Standard deviations of attitude, rad, and ω, rad/s, if what alternates is noise, (2,)."""
        return np.asarray(self.every[1] / np.sqrt(OF_DIFFERENCES[1]))

    @property
    def is_noise(self) -> NDArray[np.bool_]:
        """Whether what alternates is noise, for attitude and for ω, (2,)."""
        alternates = self._alternates(self.every, 1) & self._alternates(self.every_second, 2)
        return np.asarray(alternates & self.throughout)

    @property
    def of_omega(self) -> list[str]:
        """The sentence that ω alternates though it has no noise; none if it does not."""
        alternates = self._alternates(self.every, 1)[1] and self.throughout[1]
        if not alternates or self.is_noise[1] or self.noise[1] < CLEARLY * self.least[1]:
            return []
        size = np.sqrt(3) * self.every[1, 1] / ALTERNATING
        return [
            f"ω alternates from one sample to the next, by ± {size:.2g} rad/s, which is no noise: "
            "so it does by the trapezoidal rule from accelerations that are not the motion's"
        ]

    def _alternates(self, differences: FloatArray, lag: int) -> NDArray[np.bool_]:
        """Whether differences alternate, for attitude and for ω, (2,).

        Parameters
        ----------
        differences : `every` or `every_second`
        lag : the lag of these differences: 1 or 2 samples
        """
        third, fourth = differences
        is_more = fourth > self.least * np.sqrt(OF_DIFFERENCES[lag])
        return np.asarray((fourth > ALTERNATES * third) & is_more)


def alternation(scenario: Scenario, motion: Trajectory, floor: FloatArray) -> Alternation | None:
    """Return what alternates in a motion; None if samples are too few or too far apart.

    Parameters
    ----------
    floor : errors of attitude, rad, and ω, rad/s, by the rounding of printed numbers, (2,)
    """
    fastest = float(norms(motion.omega_body).max())
    if len(motion.t) < FEWEST or fastest * np.median(np.diff(motion.t)) >= NEAR:
        return None
    # These are first differences already, with the noise of two samples.
    first = deviations_from_flow(scenario, motion)
    least = np.maximum(PRINTED * floor, LEAST * np.array([1.0, fastest]))
    squares = [_differences(first, lag) for lag in OF_DIFFERENCES]
    every, every_second = (
        np.sqrt(np.array([np.mean(one, axis=0) for one in two])) for two in squares
    )
    fourth = squares[0][1]
    throughout = np.median(fourth, axis=0) > LEFT * np.mean(fourth, axis=0)
    return Alternation(every, every_second, throughout, least)


def _differences(first: FloatArray, lag: int) -> list[FloatArray]:
    """Return the third and the fourth differences of attitude and ω, squared.

    The squares are means over the three components: (n − 2 lag, 2) and (n − 3 lag, 2).

    Parameters
    ----------
    first : first differences of attitude, rad, and ω, rad/s, (n, 6)
    lag : the lag of the second and higher differences, d[k + lag] − d[k], in samples
    """
    squares, differences = [], first
    for _ in range(3):
        differences = differences[lag:] - differences[:-lag]
        squares.append(np.mean(differences.reshape(-1, 2, 3) ** 2, axis=2))
    return squares[1:]
