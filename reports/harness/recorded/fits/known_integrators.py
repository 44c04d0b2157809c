"""Which known integrator computed a recorded motion, and with which timestep."""

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

#: The most intervals in which known integrators are followed, at the stated timestep and at guessed
#: ones.
FEW, GUESSED = 12, 4
#: Numbers of steps from sample to sample that are tried where the timestep may be another than the
#: stated one.
STEPS = (1, 2, 4, 5, 8, 10, 16, 20, 25, 40, 50, 100)


@dataclass(frozen=True, eq=False)
class KnownIntegrators:
    """The intervals of a motion, and the steps that known integrators take in them.

    Attributes
    ----------
    intervals : of the motion
    stated : the timestep that the motion was computed with, s; None if unknown
    """

    intervals: Intervals
    stated: float | None

    @cached_property
    def span(self) -> float:
        """The median time between consecutive samples, s."""
        return float(np.median(self.intervals.spans))

    @cached_property
    def each(self) -> tuple[Intervals, ...]:
        """The intervals, to be followed with each known integrator in turn at the stated timestep.

        If no timestep is stated, the median time between samples is used.
        """
        return self._steps(self.stated or self.span, FEW)

    def _steps(self, timestep: float, count: int) -> tuple[Intervals, ...]:
        """Return some of the intervals, to be followed with each known integrator in turn.

        Parameters
        ----------
        timestep : timestep of the integrators, s
        count : the most intervals

        Returns
        -------
        An empty tuple if the intervals are not multiples of the timestep
        """
        data = self.intervals.spread(count)
        multiples = data.spans / timestep
        if (np.abs(multiples - np.rint(multiples)) > MULTIPLE * multiples).any():
            return ()
        return tuple(data.made_by(one, timestep) for one in self._integrators)

    @cached_property
    def _integrators(self) -> list[Integrator]:
        """The known integrators that may have computed the motion.

        One that keeps the length of I ω is among them only if the scene's torques keep it, too: it
        would undo drag, and so explain a motion in which drag is missing.
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
        """Return in words the known integrator that computed the motion, if a hypothesis holds.

        Its steps at the stated timestep, with the equations of the hypothesis, lead from sample to
        sample. The text is empty if there is no such integrator, or if the exact flow, too, leads
        from sample to sample within noise.
        """
        exactly = self.left_exactly(hypothesis)
        return self._in_words(self._best(self.each, hypothesis, exactly, noise=1.0))

    def at_another_timestep(self, hypothesis: Hypothesis) -> str:
        """Return in words the known integrator that computed the motion with another timestep.

        The timesteps tried are the median time between samples, divided by `STEPS`. The text is
        empty if none is found.

        Of the many integrators and timesteps that are tried, some have residuals as small as noise
        by chance: the right one must have far smaller residuals.
        """
        exactly = self.left_exactly(hypothesis)
        each = (self._steps(self.span / n, GUESSED) for n in STEPS)
        every = (self._best(steps, hypothesis, exactly, noise=0.0) for steps in each)
        return self._in_words(next(filter(None, every), None))

    def left_exactly(self, hypothesis: Hypothesis) -> float:
        """Return the mean square residual of a hypothesis' exact flow, in variances of noise."""
        return mean_square(
            self.intervals.spread(FEW).made_by(EXACT, 0.0).deviations(hypothesis[None])
        )

    @staticmethod
    def _best(
        each: tuple[Intervals, ...], hypothesis: Hypothesis, exactly: float, noise: float
    ) -> Intervals | None:
        """Return the intervals with the integrator that computed the motion; None if none did.

        It is also None if the exact flow explains the motion as well.

        Parameters
        ----------
        each : the intervals with each integrator
        exactly : the mean square residual of the hypothesis' exact flow, in variances of noise
        noise : the mean square up to which an integrator's residuals count as noise, in variances
            of noise
        """
        if not each or exactly <= 1:
            return None
        squares = [mean_square(one.deviations(hypothesis[None])) for one in each]
        if min(squares) > max(noise, SAME**2 * exactly):
            return None
        # Of integrators whose residuals are within noise the first is named, else the one with the
        # smallest residuals.
        return each[
            next((k for k, one in enumerate(squares) if one <= noise), int(np.argmin(squares)))
        ]

    @staticmethod
    def _in_words(steps: Intervals | None) -> str:
        """Return in words the integrator and timestep of intervals; empty if there are none."""
        return f"what {steps.integrator.name} at {steps.timestep:.4g} s makes" if steps else ""
