"""What of a recorded motion alternates from sample to sample: noise, or ω of an integrator."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....reference.following import follow
from ....scenarios import FloatArray, Scenario, Trajectory
from ....scenarios.rotation import norms
from ..measuring.changes import as_it_is
from .intervals import apart, states_of
from .mistakes import FITS

#: Samples that it is told from, at least.
FEWEST = 12
#: Fourth differences of noise have a variance of so many times its own, Σ (4 over k)²; where three
#: of them are of every second sample, (1 − B)(1 − B²)³, of fewer.
OF_DIFFERENCES = {1: 70.0, 2: 40.0}
#: The latter's size over that of third ones, √3.5 and √(10/3) of noise alone; of what is smooth it
#: is less than the angle between the samples, of which two are less than this apart.
ALTERNATES, NEAR = 1.4, 0.7
#: The latter of what alternates, ± 1.
ALTERNATING = 16.0
#: Noise that is not that of printed numbers is larger by this factor.
PRINTED = 50.0


@dataclass(frozen=True, eq=False)
class Alternation:
    """What alternates from sample to sample, beyond the exact flow from the sample before.

    It is smooth along a motion that was computed, whatever is wrong with it; along one that was
    measured it alternates, and where only every second sample is taken it does, too.

    Attributes
    ----------
    every, every_second : third and fourth differences of attitude, rad, and ω, rad/s, root mean
        square; the further ones are those of every sample, or of every second one, (2, 2)
    least : that is more than rounding, or an integrator's interpolation, (2,)
    """

    every: FloatArray
    every_second: FloatArray
    least: FloatArray

    @property
    def noise(self) -> FloatArray:
        """Standard deviations, if it is noise, (2,)."""
        return np.asarray(self.every[1] / np.sqrt(OF_DIFFERENCES[1]))

    @property
    def is_noise(self) -> NDArray[np.bool_]:
        """Whether the alternation of attitude, and that of ω, is noise, (2,)."""
        return self._alternates(self.every, 1) & self._alternates(self.every_second, 2)

    @property
    def of_omega(self) -> str:
        """The message that ω alternates by more than noise; empty if it does not."""
        if not self._alternates(self.every, 1)[1] or self.is_noise[1]:
            return ""
        size = np.sqrt(3) * self.every[1, 1] / ALTERNATING
        return (
            f"ω alternates from one sample to the next, by ± {size:.2g} rad/s, which is no noise: "
            "so it does by the trapezoidal rule from accelerations that are not the motion's"
        )

    def _alternates(self, differences: FloatArray, lag: int) -> NDArray[np.bool_]:
        third, fourth = differences
        is_more = fourth > self.least * np.sqrt(OF_DIFFERENCES[lag])
        return np.asarray((fourth > ALTERNATES * third) & is_more)


def alternation(scenario: Scenario, motion: Trajectory, floor: FloatArray) -> Alternation | None:
    """Return what alternates in a motion; None of too few samples, or too far apart.

    Parameters
    ----------
    floor : noise of the printed numbers, of attitude, rad, and ω, rad/s, (2,)
    """
    fastest = float(norms(motion.omega_body).max())
    if len(motion.t) < FEWEST or fastest * np.median(np.diff(motion.t)) >= NEAR:
        return None
    states, equations = states_of(motion), as_it_is(scenario).equations
    made = follow(equations, states[:-1], np.diff(motion.t)[:, None])[:, 0]
    # A difference already, of the noise of two samples.
    gained = apart(made, states[1:])
    least = np.maximum(PRINTED * floor, FITS * np.array([1.0, fastest]))
    every, every_second = (_differences(gained, lag) for lag in OF_DIFFERENCES)
    return Alternation(every, every_second, least)


def _differences(gained: FloatArray, lag: int) -> FloatArray:
    """Root mean squares of the second and third differences, of attitude and ω, (2, 2)."""
    squares = []
    for _ in range(3):
        gained = gained[lag:] - gained[:-lag]
        squares.append(np.mean(gained.reshape(-1, 2, 3) ** 2, axis=(0, 2)))
    return np.sqrt(squares[1:])
