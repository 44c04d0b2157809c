"""The samples of a measured motion, as of a flight log, with normal and independent noise."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.spatial.transform import Rotation

from .....reference.deviations import apart
from .....reference.following import APPROXIMATE, ERROR, EXACT, Integrator, follow_each
from .....scenarios import FloatArray, Scenario, Trajectory
from .....scenarios.rotation import norms, rotation_vectors
from ...explaining.fit import Data, Fit
from ...explaining.hypothesis import Hypothesis, as_it_is
from ...explaining.search import LEFT
from ..samples.intervals import FASTER, states_of
from ..samples.mistakes import FITS
from ..samples.sensors import as_read

#: The first samples are fitted alone: so many that the body turns by `BEGINNING`, rad, but at least
#: `FEWEST`. Then twice as many are fitted, and so on until all are.
BEGINNING, FEWEST = 2.0, 12
#: The most samples of a part of the log that is fitted before all samples are.
MOST = 128
#: Prior standard deviation, relative to the mean moment, of each of the five independent components
#: of a tensor with a given trace. It is the root mean square difference of two random bodies with
#: the same trace, √(2 · 3/8 / 5): their second moments divide the trace at random (uniform on the
#: simplex), and their axes are random.
PRIOR_SPREAD = 0.387


@dataclass(frozen=True, eq=False)
class Log(Data):
    """The n samples of a measured motion, to which hypotheses are fitted.

    Attributes
    ----------
    scene_start : q, scalar first, and ω, rad/s, body axes, of the exact motion at the first sample,
        (7,)
    t : times of the samples, s, (n,)
    states : recorded q and ω, (n, 7)
    noise : standard deviations of attitude, rad, and ω, rad/s, (2,)
    is_stated : whether the noise was stated by the user; else it was estimated
    has_omega : whether ω was recorded; if not, only attitudes are fitted
    dropped : number of samples that `while_followed` has left out at the end of the motion
    is_exact : whether hypotheses are followed with the integrator `EXACT` in any case
    """

    scene_start: FloatArray
    t: FloatArray
    states: FloatArray
    noise: FloatArray
    is_stated: bool
    has_omega: bool
    dropped: int = 0
    is_exact: bool = False

    @cached_property
    def rate(self) -> float:
        """The largest rate at which the body turns or its state changes, rad/s."""
        speeds = norms(np.vstack([self.states[:, 4:], self.scene_start[None, 4:]]))
        return float(max(speeds.max(), float(self.base.rate), self.noise[1]))

    @cached_property
    def omegas(self) -> tuple[FloatArray, FloatArray] | None:
        """The mean ω between samples, by attitudes and as recorded, rad/s, (n - 1, 3) each.

        None if ω was not recorded.
        """
        if not self.has_omega:
            return None
        q, omega = np.split(self.states, [4], axis=1)
        rates = rotation_vectors(q[:-1], q[1:]) / np.diff(self.t)[:, None]
        return rates, (omega[:-1] + omega[1:]) / 2

    @property
    def fastest(self) -> float:
        """The largest ‖ω‖ up to which the motions of hypotheses are followed, rad/s."""
        return FASTER * self.rate

    @cached_property
    def integrator(self) -> Integrator:
        """The integrator that computes the motions of hypotheses: `APPROXIMATE` or `EXACT`.

        It is `APPROXIMATE` if that has an error below the noise of the mean of all samples.
        """
        if self.is_exact:
            return EXACT
        error = ERROR * self.rate * float(np.abs(self.t - self.t[0]).max())
        noise = min(self.noise[0], self.noise[1] / (self.rate or 1.0)) / np.sqrt(len(self.t))
        return APPROXIMATE if error < noise else EXACT

    @cached_property
    def beginnings(self) -> Sequence["Log"]:
        """Logs of more and more of the first samples, to be fitted in turn.

        The first log is so short that its motion is nearly linear in its start. The last log has
        all samples. Each log before it has at most `MOST`, spread evenly over its part of the
        motion.
        """
        turned = np.cumsum(norms(self.states[1:, 4:]) * np.diff(self.t))
        length, lengths = max(FEWEST, int(np.searchsorted(turned, BEGINNING))), list[int]()
        while length < len(self.t):
            lengths.append(length)
            length *= 2
        if len(self.t) > MOST:
            lengths.append(len(self.t))
        return (*map(self._beginning, lengths), self)

    def _beginning(self, length: int) -> "Log":
        """Return the log of at most `MOST` samples, spread evenly over the first `length`."""
        kept = np.unique(np.linspace(0, length - 1, min(length, MOST)).astype(int))
        return replace(self, t=self.t[kept], states=self.states[kept])

    @property
    def measured(self) -> int:
        """The number of components of a sample that are fitted: 6, or 3 if ω was not recorded."""
        return 6 if self.has_omega else 3

    def deviations(self, hypotheses: Hypothesis) -> FloatArray:
        """Return the deviations of the n samples from what sensors read with H hypotheses.

        Returns
        -------
        Deviations of attitude and ω, (H, n, 6), or of attitude alone, (H, n, 3), if ω was not
        recorded; in standard deviations of noise
        """
        made = self.made(hypotheses, self.t)
        # With a far too large scale factor or delay, the readings of sensors may overflow.
        with np.errstate(over="ignore", invalid="ignore"):
            off = apart(as_read(hypotheses, made, self.t), self.states) / np.repeat(self.noise, 3)
        return off[..., : self.measured]

    def made(self, hypotheses: Hypothesis, t: FloatArray) -> FloatArray:
        """Return the states to which H hypotheses lead at n given times, (H, n, 7).

        Parameters
        ----------
        t : times, s, (n,), which increase or decrease from the time of the first sample

        Returns
        -------
        The body's q, scalar first, and ω, rad/s, body axes; not what sensors would read
        """
        # A delay, for example, may be so long that the start is not finite.
        is_finite = np.isfinite(norms(hypotheses.start))[:, None]
        changed = np.where(is_finite, hypotheses.start, 0.0)
        turn = Rotation.from_rotvec(changed[:, :3])
        q = Rotation.from_quat(self.scene_start[:4], scalar_first=True) * turn
        omega = np.where(is_finite, self.scene_start[4:] + changed[:, 3:], np.nan)
        starts = np.hstack([q.as_quat(scalar_first=True), omega])[:, None]
        spans = hypotheses.step[:, None, None] * np.diff(t, prepend=self.t[0])
        return follow_each(hypotheses, starts, spans, self.integrator, fastest=self.fastest)[:, 0]

    def while_followed(self, exact: Trajectory) -> "Log":
        """Return the log without the last samples if rounding of the start hides what they show.

        Near an unstable motion, a change of the start by rounding grows without bound. Once the
        scene's own equations, followed from the start, are off the exact motion by more than the
        fraction `LEFT` of the noise, no hypothesis can be compared with the samples: from there on
        they are left out. The first `FEWEST` are kept in any case.

        Parameters
        ----------
        exact : the exact motion at the times of the log
        """
        (made,) = self.made(self.base[None], self.t)
        off = np.abs(apart(made, states_of(exact)) / np.repeat(self.noise, 3)).max(axis=1)
        # A motion that is too fast for what was recorded is nan, and not lost.
        lost = np.flatnonzero(off > LEFT)
        if len(lost) and not self.is_exact:
            return replace(self, is_exact=True).while_followed(exact)
        kept = max(FEWEST, int(lost[0])) if len(lost) else len(self.t)
        dropped = max(0, len(self.t) - kept)
        return replace(self, t=self.t[:kept], states=self.states[:kept], dropped=dropped)

    def prior_residuals(self, hypotheses: Hypothesis) -> FloatArray:
        """Return the deviations of H hypotheses' tensors of inertia from the scene's, (H, 9).

        The deviations are those of the entries of tensors divided by their traces, in units of
        the prior standard deviation. So the scene's tensor is the mean of the prior.
        """
        made, usual = hypotheses.inertia, self.base.inertia
        traces = np.trace(made, axis1=1, axis2=2)[:, None, None]
        deviations = made / traces - usual / np.trace(usual)
        return np.asarray(3 * deviations.reshape(-1, 9) / PRIOR_SPREAD)

    def squares(self, standardised: FloatArray) -> FloatArray:
        """Return the χ² of attitude and of ω for each of M sets of residuals of n samples, (M, 2).

        If ω was not recorded, only that of attitude is returned, (M, 1). To each χ² that of
        deviations of `FITS`, rad and relative to ‖ω‖, is added, so that rounding is not taken for
        noise.

        Parameters
        ----------
        standardised : the residuals, in standard deviations of noise, sample by sample: three of
            attitude and, if it was recorded, three of ω, (M, 6 n) or (M, 3 n)
        """
        of_vectors = standardised.reshape(len(standardised), len(self.t), -1, 3)
        squares = np.sum(of_vectors**2, axis=(1, 3))
        fits = FITS * np.array([1.0, self.rate]) / self.noise
        return np.asarray(squares + 3 * len(self.t) * fits[: squares.shape[1]] ** 2)

    def chi2_decreases(self, before: FloatArray, after: FloatArray) -> FloatArray:
        """Return by how much each of M changes of equations or sensors decreases χ², (M,).

        If noise is not stated, twice the logarithm of the likelihood ratio is returned instead.
        Each likelihood has the noise that is estimated from its own residuals.

        Parameters
        ----------
        before, after : the m deviations of the samples from the motion without the changes, (m,),
            and with each of them, (M, m), in standard deviations of noise
        """
        if self.is_stated:
            return super().chi2_decreases(before, after)
        ratios = self.squares(before[None]) / self.squares(after)
        return np.asarray(3 * len(self.t) * np.sum(np.log(ratios), axis=1))

    def with_noise_of(self, fit: Fit) -> "Log":
        """Return the same log, with noise that is estimated from the residuals of a fit."""
        (squares,) = self.squares(fit.residuals[None])
        # Each parameter takes one degree of freedom, half from attitude and half from ω.
        freedom = 3 * len(self.t) - len(fit.parameters) / len(squares)
        noise = self.noise.copy()
        noise[: len(squares)] *= np.sqrt(squares / freedom)
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
    """Return a recorded motion as a log, with the exact motion's first state as its start.

    Parameters
    ----------
    motion : the recorded motion
    exact : the exact motion at the recorded times; only its first state is used
    noise : standard deviations of attitude, rad, and ω, rad/s, (2,)
    is_stated : whether the noise was stated by the user; else it was estimated
    has_omega : whether ω was recorded
    """
    start, states = states_of(exact.until(1))[0], states_of(motion)
    return Log(as_it_is(scenario), start, motion.t, states, noise, is_stated, has_omega)
