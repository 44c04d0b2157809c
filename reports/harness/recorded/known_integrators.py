"""Which known integrator made a recorded motion, and with which timestep."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ....reference.following import EXACT, KNOWN
from ..explaining.fit import mean_square
from ..explaining.hypothesis import Hypothesis
from ..explaining.search import SAME
from .intervals import Intervals
from .recording import MULTIPLE

#: Number of intervals that known integrators are followed in, and with timesteps that are guessed.
FEW, GUESSED = 12, 4
#: Steps from sample to sample that are tried where the timestep may be another than the stated one.
STEPS = (1, 2, 4, 5, 8, 10, 16, 20, 25, 40, 50, 100)


@dataclass(frozen=True, eq=False)
class KnownIntegrators:
    """A motion from sample to sample, and the steps that known integrators take in its intervals.

    Attributes
    ----------
    intervals : of the motion
    stated : the timestep that the motion was made with, s; None if unknown
    """

    intervals: Intervals
    stated: float | None

    @cached_property
    def span(self) -> float:
        """The usual distance of two samples, s."""
        return float(np.median(self.intervals.spans))

    @cached_property
    def each(self) -> tuple[Intervals, ...]:
        """The intervals as steps of each integrator, with the timestep that is stated.

        One that is not stated is taken to be the distance of the samples.
        """
        return self._steps(self.stated or self.span, FEW)

    def _steps(self, timestep: float, few: int) -> tuple[Intervals, ...]:
        """Return few intervals as steps of each integrator; none if spans are not multiples."""
        data = self.intervals.spread(few)
        multiples = data.spans / timestep
        if (np.abs(multiples - np.rint(multiples)) > MULTIPLE * multiples).any():
            return ()
        return tuple(data.made_by(one, timestep) for one in KNOWN)

    def that_made(self, hypothesis: Hypothesis) -> str:
        """Return the integrator that made the motion of a hypothesis, in words; empty if none."""
        return self._named(self._best(self.each, hypothesis, noise=1.0))

    def at_another_timestep(self, hypothesis: Hypothesis) -> str:
        """Return the integrator that did so with another timestep, in words; empty if none did.

        Of so many that are tried some are as near as noise: they must be far nearer.
        """
        each = (self._steps(self.span / n, GUESSED) for n in STEPS)
        every = (self._best(steps, hypothesis, noise=0.0) for steps in each)
        return self._named(next(filter(None, every), None))

    def left_exactly(self, hypothesis: Hypothesis) -> float:
        """The mean square of what a hypothesis leaves if no integrator is in it, in noise."""
        return mean_square(self.intervals.spread(FEW).made_by(EXACT, 0.0).deviations([hypothesis]))

    def _best(
        self, each: tuple[Intervals, ...], hypothesis: Hypothesis, noise: float
    ) -> Intervals | None:
        """Return the steps that made the motion of a hypothesis; None if none did.

        Parameters
        ----------
        noise : mean square that they may leave, in units of noise
        """
        exactly = self.left_exactly(hypothesis)
        if not each or exactly <= 1:
            return None
        left = [mean_square(one.deviations([hypothesis])) for one in each]
        if min(left) > max(noise, SAME**2 * exactly):
            return None
        # Of those that leave rounding alone the first is named, else the one that leaves least.
        return each[next((k for k, one in enumerate(left) if one <= noise), int(np.argmin(left)))]

    @staticmethod
    def _named(steps: Intervals | None) -> str:
        return f"what {steps.integrator.name} at {steps.timestep:.4g} s makes" if steps else ""
