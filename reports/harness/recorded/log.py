"""A flight log: the samples of a measured motion, with normal and independent noise."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.spatial.transform import Rotation

from ....reference.following import follow_each
from ....scenarios import FloatArray, Scenario, Trajectory
from ....scenarios.rotation import norms
from ..explaining.fit import Data, Fit
from ..explaining.hypothesis import Hypothesis, as_it_is
from .intervals import FASTER, apart, states_of
from .mistakes import FITS
from .sensors import as_read

#: Turn of the body, rad, in the samples that are fitted first, and their least number; then twice
#: as many are fitted, until it is all.
BEGINNING, FEWEST = 2.0, 12
#: Standard deviation of a tensor that is assumed before any fit, relative to its mean moment, in
#: each of its directions: the root mean square difference of two bodies of one trace whose second
#: moments share it at random (uniform on the simplex) about axes at random, √(2 · 3/8 / 5).
SPREAD = 0.387


@dataclass(frozen=True, eq=False)
class Log(Data):
    """The samples of a measured motion.

    Attributes
    ----------
    scene_start : q, scalar first, and ω, rad/s, body axes, of the exact motion at the first sample,
        (7,)
    t : s, (n,)
    states : recorded q and ω, (n, 7)
    noise : standard deviations of attitude, rad, and ω, rad/s, (2,)
    is_stated : whether the noise was stated, not estimated
    has_omega : whether ω was recorded; if not, only attitudes are fitted
    """

    scene_start: FloatArray
    t: FloatArray
    states: FloatArray
    noise: FloatArray
    is_stated: bool
    has_omega: bool

    @cached_property
    def fastest(self) -> float:
        """The largest rate of a motion that is tried, rad/s."""
        speeds = norms(np.vstack([self.states[:, 4:], self.scene_start[None, 4:]]))
        return FASTER * float(max(speeds.max(), self.base.equations.rate, self.noise[1]))

    @cached_property
    def parts(self) -> Sequence[int | None]:
        """As in `Data`: from samples in which the motion is nearly linear in its start to all."""
        turned = np.cumsum(norms(self.states[1:, 4:]) * np.diff(self.t))
        length, lengths = max(FEWEST, int(np.searchsorted(turned, BEGINNING))), []
        while length < len(self.t):
            lengths.append(length)
            length *= 2
        return (*lengths, None)

    @property
    def measured(self) -> int:
        """How many numbers a sample has."""
        return 6 if self.has_omega else 3

    def deviations(
        self, hypotheses: Sequence[Hypothesis], samples: int | None = None
    ) -> FloatArray:
        """As in `Data`: what each leaves, in units of noise, (H, n, 6), without ω (H, n, 3)."""
        t = self.t[:samples]
        read = as_read(hypotheses, self.made(hypotheses, t), t)
        off = apart(read, self.states[:samples]) / np.repeat(self.noise, 3)
        return off[..., : self.measured]

    def made(self, hypotheses: Sequence[Hypothesis], t: FloatArray) -> FloatArray:
        """Return the states of H hypotheses at times from the first sample's on, (H, n, 7).

        Parameters
        ----------
        t : s, (n,), in the order in which they follow, or precede, the first sample
        """
        changed = np.stack([one.start for one in hypotheses])
        turn = Rotation.from_rotvec(changed[:, :3])
        q = Rotation.from_quat(self.scene_start[:4], scalar_first=True) * turn
        omega = self.scene_start[4:] + changed[:, 3:]
        starts = np.hstack([q.as_quat(scalar_first=True), omega])[:, None]
        steps = np.array([one.step for one in hypotheses])[:, None, None]
        spans = steps * np.diff(t, prepend=self.t[0])
        equations = [one.equations for one in hypotheses]
        return follow_each(equations, starts, spans, fastest=self.fastest)[:, 0]

    def prior_residuals(self, hypothesis: Hypothesis) -> FloatArray:
        """As in `Data`: how far a tensor's ratios are from the scene's, standardised, (9,)."""
        made, usual = (h.equations.inertia for h in (hypothesis, self.base))
        off = made / np.trace(made) - usual / np.trace(usual)
        return np.asarray(3 * off.ravel() / SPREAD)

    def squares(self, rest: FloatArray) -> FloatArray:
        """Return the sum of squares of attitude and, if it is fitted, of ω: (2,) or (1,).

        Errors that need no explanation are added to it, as rounding is no noise to be explained.
        """
        squares = np.sum(rest.reshape(len(self.t), -1, 3) ** 2, axis=(0, 2))
        fits = FITS * np.array([1.0, self.fastest / FASTER]) / self.noise
        return np.asarray(squares + 3 * len(self.t) * fits[: len(squares)] ** 2)

    def chi2_decrease(self, before: FloatArray, after: FloatArray) -> float:
        """As in `Data`; noise that is not stated is estimated from what is left."""
        if self.is_stated:
            return super().chi2_decrease(before, after)
        ratios = self.squares(before) / self.squares(after)
        return float(3 * len(self.t) * np.sum(np.log(ratios)))

    def with_noise_of(self, fit: Fit) -> "Log":
        """Return the samples, their noise the standard deviation of what a fit leaves of them."""
        squares = self.squares(fit.residuals)
        # Degrees of freedom: each fitted number takes one, half from attitude and half from ω.
        share = 3 * len(self.t) - len(fit.parameters) / len(squares)
        noise = self.noise.copy()
        noise[: len(squares)] *= np.sqrt(squares / share)
        return replace(self, noise=noise)


def log_of(
    scenario: Scenario,
    motion: Trajectory,
    exact: Trajectory,
    noise: FloatArray,
    *,
    is_stated: bool,
    has_omega: bool,
) -> Log:
    """Return the samples of a motion; the arguments are those of `Log`."""
    start, states = states_of(exact.until(1))[0], states_of(motion)
    return Log(as_it_is(scenario), start, motion.t, states, noise, is_stated, has_omega)
