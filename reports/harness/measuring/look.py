"""Single steps from known states, with their gains and the series that are fitted to the gains."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ....engines.checks.equations import Equations
from ....scenarios import FloatArray
from ....scenarios.rotation import norms, rotation_vectors
from ...results.evidence import LEVEL
from .gain_series import GainSeries, fitted
from .noise import term_sizes, weakest_effects
from .steps import Steps


@dataclass(frozen=True, eq=False)
class Look:
    """Steps at J timesteps from K states, their gains, and the series fitted to the gains.

    Attributes
    ----------
    gains : in Q quantities, in the units of `step_gains`, (J, K, Q, 3)
    noise : standard deviation of the noise of each component of the gains, (J, K, Q)
    settled : number of steps, before those that are judged, in which a constraint settled
    is_single : whether the engine declares single precision
    may_split : whether the method may compute short steps by another formula than long steps
    is_pooled : whether the gains of the states are independent of each other; the gains of
        neighbouring states of a run are not
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
        """The series of each of the Q quantities."""
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

        The steps are at J timesteps from K states. Successive angles whose difference is less than
        their noise have the same rank.
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
        """The significance level for the tail of one quantity (Bonferroni)."""
        return LEVEL / len(self.sizes)

    @property
    def tail(self) -> float:
        """The tail of the tests of all quantities together (Bonferroni)."""
        return min(1.0, len(self.series) * min(one.tail for one in self.series))

    @cached_property
    def sizes(self) -> FloatArray:
        """The sizes of the rates of change of Q quantities, which gains are compared with, (Q,)."""
        return term_sizes(self.equations, self.steps)

    @property
    def known_to(self) -> tuple[float, float]:
        """How closely the limits are known to be zero: the larger of size and standard error.

        Returns
        -------
        The largest value in any state and quantity, relative to `sizes`; and the largest value
        relative to the weakest effect in the quantity
        """
        sizes = (np.maximum(one.limit_error, norms(one.limit)) for one in self.series)
        errors = np.array([size.max() for size in sizes])
        weakest = weakest_effects(self.equations, self.steps)
        return float((errors / self.sizes).max()), float((errors / weakest).max())
