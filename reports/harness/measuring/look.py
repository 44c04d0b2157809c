"""Steps from known states, what they gain, and the series that explain it."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ....engines.checks.equations import Equations
from ....scenarios import FloatArray
from ....scenarios.rotation import norms, rotation_vectors
from ...results.evidence import LEVEL
from .gain_series import GainSeries, fitted
from .noise import largest_terms, weakest_effects
from .steps import Steps


@dataclass(frozen=True, eq=False)
class Look:
    """Steps, what they gain, the noise of that, and the series that explain it.

    Attributes
    ----------
    gains, noise : of Q quantities, (J, K, Q, 3) and (J, K, Q)
    settled : steps in which a constraint settled first
    is_single : whether the engine declares single precision
    may_split : whether steps may be computed by one formula with long timesteps and by another with
        short ones
    is_pooled : whether the gains of the states are independent of each other, which neighbouring
        states of a run are not
    """

    equations: Equations
    steps: Steps
    gains: FloatArray
    noise: FloatArray
    settled: int
    is_single: bool
    may_split: bool = True
    is_pooled: bool = True

    @cached_property
    def series(self) -> tuple[GainSeries, ...]:
        """The series of each quantity."""
        found: list[GainSeries] = []
        for q in range(self.gains.shape[2]):
            series = fitted(
                self.steps.timesteps,
                self.gains[:, :, q],
                self.noise[:, :, q],
                self.level,
                turns=self.turns,
                changes_elsewhere=[one.changes for one in found if one.changes.any()],
                may_split=self.may_split,
                is_pooled=self.is_pooled,
            )
            found.append(series)
        return tuple(found)

    @property
    def turns(self) -> FloatArray:
        """The rank, from 0, of the angle by which each step turned the body, (J, K).

        Angles whose difference is less than their noise have the same rank.
        """
        before, after = self.steps.before.q_world_body_wxyz, self.steps.after.q_world_body_wxyz
        angles = self.steps.by_timestep(norms(rotation_vectors(before, after))).mean(axis=1)
        noise = self.noise[:, :, 0] * self.steps.timesteps[:, None]
        order = angles.argsort(axis=None)
        ranks = np.zeros(angles.size)
        ranks[order[1:]] = np.cumsum(np.diff(angles.flat[order]) > noise.flat[order[1:]])
        return ranks.reshape(angles.shape)

    @property
    def level(self) -> float:
        """The level that one quantity's tail is held to."""
        return LEVEL / len(self.sizes)

    @property
    def tail(self) -> float:
        """The probability of gains as unlikely as these."""
        return min(1.0, len(self.series) * min(one.tail for one in self.series))

    @cached_property
    def sizes(self) -> FloatArray:
        """The largest terms that the gains are sums of, (Q,)."""
        return largest_terms(self.equations, self.steps)

    @property
    def known_to(self) -> tuple[float, float]:
        """How well the limit is known to be zero: the larger of its size and its standard error.

        Returns
        -------
        That, relative to the largest terms, and relative to the weakest effect
        """
        sizes = (np.maximum(one.limit_error, norms(one.limit)) for one in self.series)
        errors = np.array([size.max() for size in sizes])
        weakest = weakest_effects(self.equations, self.steps)
        return float((errors / self.sizes).max()), float((errors / weakest).max())
