"""Gains of steps, whitened: each as it is beyond what those with longer timesteps predict.

The model is that of `gain_series.py`, for one order and a grid of radii and amplitudes.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from ....scenarios import FloatArray

#: Terms of the series that are kept.
TERMS = 9
#: Inverse radii of convergence, and the ratio of neighbouring amplitudes, that are integrated over.
RADII, SPACING = (0.5, 1.0, 2.0, 4.0), 10**0.35
#: Gains with longer timesteps that a prediction needs.
PREDICTED_FROM = 2


@dataclass(frozen=True, eq=False)
class Measured:
    """Gains in units in which the noise of all states is alike.

    Attributes
    ----------
    x : timesteps, relative to the longest, (J,)
    gains, noise : (J, K, 3) and (J,)
    units : what a gain of each state is to be multiplied by, (K,)
    amplitudes : those that are integrated over, (A,)
    turns : of each state in each timestep, in any unit, (J, K)
    """

    x: FloatArray
    gains: FloatArray
    noise: FloatArray
    units: FloatArray
    amplitudes: FloatArray
    turns: FloatArray

    @staticmethod
    def of(
        timesteps: FloatArray, gains: FloatArray, noise: FloatArray, rates: FloatArray | None
    ) -> "Measured":
        """Scale gains by each state's noise; how it depends on timesteps is as in the noisiest."""
        units = np.median(noise / np.median(noise, axis=1, keepdims=True), axis=0)
        scaled, alike = gains / units[:, None], (noise / units).max(axis=1)
        least, largest = 0.1 * alike.min(), 1e3 * (np.abs(scaled).max() + alike.max())
        count = int(np.ceil(np.log(largest / least) / np.log(SPACING)))
        amplitudes = least * SPACING ** np.arange(count + 1)
        x = timesteps / timesteps[0]
        turns = x[:, None] * (np.ones(len(units)) if rates is None else rates)
        return Measured(x, scaled, alike, units, amplitudes, turns)

    def changes(self, last: int) -> NDArray[np.intp]:
        """The index of the timestep from which on steps may be computed otherwise, (n, K).

        One row for each timestep up to `last`, the same for all states, and one for each turn that
        some state changes at by then. 0 in states all of whose steps are on one side.
        """
        count, states = self.turns.shape
        by_timestep = np.repeat(np.arange(1, last + 1)[:, None], states, axis=1)
        by_turn = (self.turns[:, :, None] > np.unique(self.turns)).sum(axis=0).T
        by_turn = np.where(by_turn < count, by_turn, 0)
        is_seen = ((by_turn > 0) & (by_turn <= last)).any(axis=1) | ~by_turn.any(axis=1)
        # One of the two series at least has as many steps as the shorter timesteps at `last`.
        is_long = ((by_turn <= last) | (by_turn >= count - last)).all(axis=1)
        return np.unique(np.concatenate([by_timestep, by_turn[is_seen & is_long]]), axis=0)


@dataclass(frozen=True, eq=False)
class Whitened:
    """Innovations of J gains of K states, in standard deviations, by each of A pairs of the grid.

    A pair is a radius and an amplitude.

    Attributes
    ----------
    innovations : (A, J, K, 3)
    ones : a constant of one, likewise, (A, J)
    sigma : the standard deviations of the predictions, (A, J)
    """

    innovations: FloatArray
    ones: FloatArray
    sigma: FloatArray

    @staticmethod
    def of(measured: Measured, order: int, first: int = 0) -> "Whitened":
        """Whiten the gains from the first on.

        The Cholesky factor of their covariance, noise² + amplitude² · basis · basisᵀ, is found by
        orthogonal triangularisation, as the two terms differ by up to 10²⁶.
        """
        x, noise, gains = measured.x[first:], measured.noise[first:], measured.gains[first:]
        J, K, _ = gains.shape
        scaled = np.array(RADII)[:, None, None] * x
        basis = x**order * scaled ** np.arange(TERMS)[:, None]
        pairs = measured.amplitudes[:, None, None] * basis[:, None]
        stacked = np.empty((len(RADII) * len(measured.amplitudes), J + TERMS, J))
        stacked[:, :J] = np.diag(noise)
        stacked[:, J:] = pairs.reshape(-1, TERMS, J)
        upper = np.linalg.qr(stacked, mode="r")
        diagonal = np.diagonal(upper, axis1=1, axis2=2)
        lower = np.swapaxes(upper * np.sign(diagonal)[:, :, None], 1, 2)
        sigma = np.abs(diagonal)
        whitening = np.zeros_like(lower)
        for j in range(J):
            known = (lower[:, j, None, :j] @ whitening[:, :j])[:, 0]
            whitening[:, j] = (np.eye(J)[j] - known) / sigma[:, j, None]
        innovations = (whitening.reshape(-1, J) @ gains.reshape(J, -1)).reshape(-1, J, K, 3)
        return Whitened(innovations, whitening.sum(axis=2), sigma)

    def until(self, beyond: int) -> "Whitened":
        """The first gains alone."""
        return Whitened(self.innovations[:, :beyond], self.ones[:, :beyond], self.sigma[:, :beyond])

    @cached_property
    def flat(self) -> FloatArray:
        """The prior by which all pairs are alike, (A,)."""
        return np.full(len(self.sigma), 1 / len(self.sigma))

    @cached_property
    def squares(self) -> FloatArray:
        """The squared norm of each innovation, (A, J, K)."""
        return np.asarray(np.einsum("ajkc,ajkc->ajk", self.innovations, self.innovations))

    @cached_property
    def likelihoods(self) -> FloatArray:
        """The logarithm of the density of each gain, given those before it, (A, J, K)."""
        return np.asarray(-self.squares / 2 - 3 * np.log(self.sigma)[:, :, None])

    @cached_property
    def evidence(self) -> FloatArray:
        """The same of all gains together, (A, K)."""
        return np.asarray(self.likelihoods.sum(axis=1))

    @cached_property
    def constants(self) -> tuple[FloatArray, FloatArray]:
        """The constant that fits best, (A, K, 3), and its standard error, (A,)."""
        precision = (self.ones**2).sum(axis=1)
        summed = np.einsum("aj,ajkc->akc", self.ones, self.innovations)
        return summed / precision[:, None, None], 1 / np.sqrt(precision)

    @cached_property
    def evidence_with_constant(self) -> FloatArray:
        """The evidence if a constant is added, of any size, (A, K)."""
        constants, error = self.constants
        gained = ((constants / error[:, None, None]) ** 2).sum(axis=2) / 2
        return np.asarray(self.evidence + gained + 3 * np.log(error)[:, None])

    def tails(self, prior: FloatArray) -> FloatArray:
        """The probability that a gain is so far off its prediction, (J, K)."""
        tails = (self._weights(prior) * chdtrc(3, self.squares)).sum(axis=0)
        tails[:PREDICTED_FROM] = 1.0
        return np.asarray(tails)

    def predictions(self, gains: FloatArray, prior: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Mean, (J, K, 3), and standard deviation, (J, K), of what is predicted of each gain."""
        weights = self._weights(prior)
        means = gains - self.innovations * self.sigma[:, :, None, None]
        mean = (weights[..., None] * means).sum(axis=0)
        spread = ((means - mean) ** 2).mean(axis=3) + self.sigma[:, :, None] ** 2
        return mean, np.sqrt((weights * spread).sum(axis=0))

    def _weights(self, prior: FloatArray) -> FloatArray:
        """The probability of each pair, given the gains before each, (A, J, K)."""
        each = self.likelihoods
        before = np.cumsum(each, axis=1) - each + np.log(prior)[:, None, None]
        return normalised(before)

    def limit(self, prior: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """The limit, (K, 3), its standard error, (K,), and the tail of its being zero, (K,)."""
        constants, error = self.constants
        weights = normalised(self.evidence_with_constant + np.log(prior)[:, None])
        limit = (weights[..., None] * constants).sum(axis=0)
        spread = ((constants - limit) ** 2).mean(axis=2) + error[:, None] ** 2
        squares = ((constants / error[:, None, None]) ** 2).sum(axis=2)
        tails = (weights * chdtrc(3, squares)).sum(axis=0)
        return limit, np.sqrt((weights * spread).sum(axis=0)), tails


def log_sum(logarithms: FloatArray) -> FloatArray:
    """The logarithm of the sum over the first axis; scipy's takes ten times as long."""
    largest = logarithms.max(axis=0)
    return np.asarray(largest + np.log(np.exp(logarithms - largest).sum(axis=0)))


def normalised(logarithms: FloatArray) -> FloatArray:
    """Probabilities over the first axis."""
    weights = np.exp(logarithms - logarithms.max(axis=0))
    return np.asarray(weights / weights.sum(axis=0))
