"""Recognises the known integrator that computed a recorded motion, and its timestep."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .....reference.following import EXACT, KNOWN, Integrator, rates
from .....scenarios.rotation import norms
from ...explaining.fit import mean_square
from ...explaining.hypothesis import Hypothesis
from ...explaining.search import SAME
from ..files.recording import MULTIPLE
from ..samples.intervals import Intervals
from ..samples.mistakes import FITS

#: The most intervals in which known integrators take steps: with the stated timestep, and with
#: guessed ones.
FEW, GUESSED = 12, 4
#: Numbers of steps from one sample to the next from which timesteps are guessed.
STEPS = (1, 2, 4, 5, 8, 10, 16, 20, 25, 40, 50, 100)


@dataclass(frozen=True, eq=False)
class KnownIntegrators:
    """The comparison of a recorded motion with the steps of known integrators.

    Attributes
    ----------
    intervals : the intervals between the samples of the motion
    stated : the stated timestep of the motion, s; None if unknown
    """

    intervals: Intervals
    stated: float | None

    @cached_property
    def span(self) -> float:
        """The median time between consecutive samples, s."""
        return float(np.median(self.intervals.spans))

    @cached_property
    def each(self) -> tuple[Intervals, ...]:
        """Some of the intervals, copied once for each known integrator that may have computed them.

        The integrator's steps have the stated timestep, or the median time between samples if none
        is stated. The tuple is empty if the lengths of the intervals are not multiples of that.
        """
        return self._steps(self.stated or self.span, FEW)

    def _steps(self, timestep: float, count: int) -> tuple[Intervals, ...]:
        """Return some intervals, copied once for each known integrator that may have computed them.

        Parameters
        ----------
        timestep : timestep of the integrators, s
        count : the largest number of intervals

        Returns
        -------
        An empty tuple if the lengths of the intervals are not multiples of the timestep
        """
        data = self.intervals.spread(count)
        multiples = data.spans / timestep
        if (np.abs(multiples - np.rint(multiples)) > MULTIPLE * multiples).any():
            return ()
        return tuple(data.made_by(one, timestep) for one in self._integrators)

    @cached_property
    def _integrators(self) -> list[Integrator]:
        """The known integrators that may have computed the motion.

        An integrator that keeps the length of I ω is among them only if the torques keep it, too.
        Otherwise it would undo the drag of a hypothesis, and so explain a motion without drag.
        """
        equations, states = self.intervals.base, self.intervals.starts
        kept = np.tile(equations.kept, (len(states), 1))
        momenta, torques = (
            vectors @ equations.inertia
            for vectors in (states[:, 4:], rates(equations, states, kept)[:, 3:])
        )
        along = np.abs(np.sum(momenta * torques, axis=1)).max()
        is_kept = along <= FITS * (norms(momenta) * norms(torques)).max()
        return [one for one in KNOWN if is_kept or not one.keeps_length]

    def that_made(self, hypothesis: Hypothesis) -> str:
        """Return in words the integrator that computed the motion from a hypothesis' equations.

        Its steps, with the stated timestep, or with the median time between samples if none is
        stated, lead from sample to sample within noise. The text is empty if no known integrator
        does that, or if the exact flow of these equations does the same.
        """
        exactly = self.left_exactly(hypothesis)
        return self._in_words(self._best(self.each, hypothesis, exactly, noise=1.0))

    def at_another_timestep(self, hypothesis: Hypothesis) -> str:
        """Return in words the known integrator that computed the motion with a guessed timestep.

        The timesteps tried are the median time between samples, divided by each of `STEPS`. The
        text is empty if no integrator is found.

        Of the many integrators and timesteps, some have residuals as small as noise by chance. So
        the residuals must be far smaller than those of the exact flow.
        """
        exactly = self.left_exactly(hypothesis)
        each = (self._steps(self.span / n, GUESSED) for n in STEPS)
        every = (self._best(steps, hypothesis, exactly, noise=0.0) for steps in each)
        return self._in_words(next(filter(None, every), None))

    def left_exactly(self, hypothesis: Hypothesis) -> float:
        """Return the mean square of the deviations of the recorded states from an exact flow.

        The flow is that of a hypothesis' equations, from each sample to the next one. The mean
        square is in units of the variance of noise.
        """
        return mean_square(
            self.intervals.spread(FEW).made_by(EXACT, 0.0).deviations(hypothesis[None])
        )

    @staticmethod
    def _best(
        each: tuple[Intervals, ...], hypothesis: Hypothesis, exactly: float, noise: float
    ) -> Intervals | None:
        """Return the intervals with the integrator that computed the motion; None if none did.

        An integrator did if the mean square of its residuals is at most `noise`, or at most `SAME`²
        times `exactly`. None is also returned if the exact flow explains the motion, too.

        Parameters
        ----------
        each : the intervals, once for each integrator
        hypothesis : the equations that the integrators solve
        exactly : mean square of the residuals with the exact flow, in units of the noise's variance
        noise : the mean square up to which residuals count as noise, in the same units
        """
        if not each or exactly <= 1:
            return None
        squares = [mean_square(one.deviations(hypothesis[None])) for one in each]
        if min(squares) > max(noise, SAME**2 * exactly):
            return None
        # The first integrator whose residuals are noise is named. If there is none, it is the one
        # with the smallest residuals.
        return each[
            next((k for k, one in enumerate(squares) if one <= noise), int(np.argmin(squares)))
        ]

    @staticmethod
    def _in_words(steps: Intervals | None) -> str:
        """Return in words the integrator and timestep of intervals; an empty text for None."""
        return f"what {steps.integrator.name} at {steps.timestep:.4g} s makes" if steps else ""
