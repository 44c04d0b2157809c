"""Bayesian linear regression of the gains of steps on powers of the timestep.

The model is described in `gain_series.py`. Here its order is given, and radii of convergence and
amplitudes are on a grid. For each point of the grid the gains are jointly Gaussian, and likelihood,
limit and predictions follow from one singular value decomposition for each radius, of the powers in
units of the noise (Bishop, Pattern Recognition and Machine Learning, §3.3). A gain at a timestep
beyond the radius may be as large as the largest gain.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.special import erfc

from ....scenarios import FloatArray
from ...results.evidence import LEVEL

#: Number of terms of the series: with more terms, no tail changes by a factor of two.
TERMS = 16
#: Ratio of neighbouring radii of the grid, and square root of the ratio of neighbouring amplitudes.
RATIO = 2**0.5
#: The least number of gains at longer timesteps from which a gain is predicted, and the least
#: number of gains from which a limit is estimated.
PREDICTED_FROM, LEAST = 2, 4


@dataclass(frozen=True, eq=False)
class Measured:
    """The gains at J timesteps from K states, in units in which all states have the same noise.

    Attributes
    ----------
    x : timesteps, relative to the longest, (J,)
    gains, noise : gains, (J, 3, K), and the standard deviation of their noise, (J,)
    units : the unit of each state, by which its gains and noise were divided, (K,)
    amplitudes : the amplitudes of the series' coefficients that are tried, (A,)
    turns : the angle by which each step turns the body, or the angle's rank, (J, K)
    radius : the least radius of convergence that is considered, relative to the longest timestep;
        about two thirds of all timesteps are below it
    """

    x: FloatArray
    gains: FloatArray
    noise: FloatArray
    units: FloatArray
    amplitudes: FloatArray
    turns: FloatArray
    radius: float

    @staticmethod
    def of(
        timesteps: FloatArray, gains: FloatArray, noise: FloatArray, turns: FloatArray | None
    ) -> "Measured":
        """Return the gains of each state in units of its noise.

        At each timestep the largest noise of any state, in these units, is used for all states.

        Parameters
        ----------
        timesteps : J timesteps, long to short, s, (J,)
        gains : the gains from K states, per second, (J, K, 3)
        noise : standard deviation of each component of a gain, (J, K)
        turns : the angle by which each step turns the body, or the angle's rank, (J, K); the
            timesteps are used if it is None
        """
        units = np.median(noise / np.median(noise, axis=1, keepdims=True), axis=0)
        scaled, shared = np.swapaxes(gains, 1, 2) / units, (noise / units).max(axis=1)
        least, largest = 0.1 * shared.min(), 1e3 * (np.abs(scaled).max() + shared.max())
        count = int(np.ceil(np.log(largest / least) / np.log(RATIO**2)))
        amplitudes = least * RATIO ** (2 * np.arange(count + 1))
        x = timesteps / timesteps[0]
        if turns is None:
            turns = np.repeat(x[:, None], len(units), axis=1)
        return Measured(x, scaled, shared, units, amplitudes, turns, float(x[len(x) // 3]))

    def changes(self, last: int) -> NDArray[np.intp]:
        """Return n ways to split the timesteps of each state into a longer and a shorter series.

        A method may compute a step by another formula if its timestep, or the angle by which the
        body turns in it, is small enough. There is one way for each index up to `last`, at which
        the timesteps of all states are split. There is one more way for each angle: it puts the
        steps that turn the body by more into the first series, and the others into the second. A
        way by an angle is left out if it splits no state at an index up to `last`, or if in some
        state both series would have too few timesteps to determine a limit.

        Parameters
        ----------
        last : the largest index at which the second series may begin

        Returns
        -------
        The index of the first timestep of the second series, for n ways and K states, (n, K); 0 if
        the way leaves the timesteps of a state in one series
        """
        count, states = self.turns.shape
        by_timestep = np.repeat(np.arange(1, last + 1)[:, None], states, axis=1)
        by_turn = (self.turns[:, :, None] > np.unique(self.turns)).sum(axis=0).T
        by_turn = np.where(by_turn < count, by_turn, 0)
        is_seen = ((by_turn > 0) & (by_turn <= last)).any(axis=1)
        # One of the two series must have enough timesteps to determine a limit.
        is_long = ((by_turn <= last) | (by_turn >= count - last)).all(axis=1)
        return np.unique(np.concatenate([by_timestep, by_turn[is_seen & is_long]]), axis=0)

    def part(self, first: int, beyond: int) -> "Measured":
        """Return the gains at the timesteps with indices from `first` to `beyond` − 1."""
        kept = slice(first, beyond)
        x, gains, noise, turns = (a[kept] for a in (self.x, self.gains, self.noise, self.turns))
        return replace(self, x=x, gains=gains, noise=noise, turns=turns)

    @property
    def largest(self) -> float:
        """The largest component of a gain, or the largest noise if that is larger."""
        return float(np.maximum(np.abs(self.gains).max(), self.noise.max()))


@dataclass(frozen=True, eq=False)
class Regression:
    """The regression of gains on powers of the timestep, for each of R A pairs of a grid.

    A gain is the difference of a step from the exact motion, per second: a vector, at J timesteps
    from K states. A pair is a radius of convergence of the series and an amplitude of its
    coefficients, with amplitudes running fastest. The prior over the pairs is estimated from all
    states. The model is described in `gain_series.py`.

    Attributes
    ----------
    measured : the gains, in units of each state's noise, and the amplitudes, (A,)
    order : lowest power of the timestep in the series
    inverse_radii : the inverse radii of convergence, in units of 1 / longest timestep, (R,)
    noise : standard deviation of the noise added to the series at each timestep, in the units of
        `measured`, (R, J); beyond the radius of convergence as large as the largest gain
    basis : the powers of the timestep, zero beyond the radius, (R, J, TERMS)
    has_constant : whether a constant, which may be as large as any gain, is added to the series
    """

    measured: Measured
    order: int
    inverse_radii: FloatArray
    noise: FloatArray
    basis: FloatArray
    has_constant: bool = False

    @staticmethod
    def of(measured: Measured, order: int, *, has_constant: bool = False) -> "Regression":
        """Return the regression of all gains on a series of a given order.

        A gain at a timestep beyond the radius of convergence may be as large as the largest gain.

        Parameters
        ----------
        order : lowest power of the timestep in the series
        has_constant : whether a constant is added to the series
        """
        x, radii = measured.x, _inverse_radii(measured)
        scaled = radii[:, None] * x
        powers = scaled[:, :, None] ** np.arange(TERMS) * (x**order)[:, None]
        within = scaled < 1
        beyond = np.where(within, 0.0, measured.largest)
        basis = np.where(within[:, :, None], powers, 0.0)
        noise = np.hypot(measured.noise, beyond)
        return Regression(measured, order, radii, noise, basis, has_constant)

    def before(self, j: int) -> "Regression":
        """Return the regression, with the same grid, of the gains at the j longest timesteps."""
        of_first = self.measured.part(0, j)
        return replace(self, measured=of_first, noise=self.noise[:, :j], basis=self.basis[:, :j])

    @cached_property
    def _decomposition(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """The singular value decomposition U S Vᵀ of the basis in units of the noise.

        There is one for each of R radii of convergence, of gains at J timesteps from K states.

        Returns
        -------
        Uᵀ divided by the noise, (R, J, J), S², (R, J), Vᵀ, (R, TERMS, TERMS), and the gains
        multiplied by the first of these, which projects them onto the columns of U, (R, J, 3, K)
        """
        U, values, right = np.linalg.svd(self.basis / self.noise[:, :, None])
        J, _, K = self.measured.gains.shape
        left = np.swapaxes(U, 1, 2) / self.noise[:, None, :]
        squares = np.zeros((len(self.inverse_radii), J))
        squares[:, : values.shape[1]] = values**2
        projected = left @ self.measured.gains.reshape(J, 3 * K)
        return left, squares, right, projected.reshape(len(left), J, 3, K)

    @cached_property
    def _inverse_variances(self) -> FloatArray:
        """The inverse variance, by prior and noise together, of gains projected on U, (R, A, J).

        It is relative to the inverse variance by noise alone; U is that of `_decomposition`. There
        is one for each of R radii, A amplitudes and J timesteps.
        """
        _, squares, _, _ = self._decomposition
        return np.asarray(1 / (1 + self.measured.amplitudes[:, None] ** 2 * squares[:, None]))

    @cached_property
    def evidence(self) -> FloatArray:
        """The logarithm of the likelihood of each state's gains, without a constant, (R A, K).

        There is one for each pair of R radii and A amplitudes, and each of K states.
        """
        _, _, _, projected = self._decomposition
        each = self._inverse_variances @ (projected**2).sum(axis=2)
        scale = (
            np.log(self._inverse_variances).sum(axis=2)
            - 2 * np.log(self.noise).sum(axis=1)[:, None]
        )
        return np.asarray((3 * scale[..., None] - each) / 2).reshape(-1, projected.shape[3])

    @cached_property
    def constants(self) -> tuple[FloatArray, FloatArray]:
        """The constant that, added to the series, fits best for each pair of the grid, (R A, 3, K).

        There is one for each of R radii, A amplitudes and K states. They are followed by the
        standard errors of their components, (R A,).
        """
        left, _, _, projected = self._decomposition
        ones, (R, J, _, K) = left.sum(axis=2), projected.shape
        precision = (self._inverse_variances @ (ones**2)[:, :, None]).reshape(-1)
        summed = (self._inverse_variances * ones[:, None]) @ projected.reshape(R, J, -1)
        return summed.reshape(-1, 3, K) / precision[:, None, None], 1 / np.sqrt(precision)

    @cached_property
    def evidence_with_constant(self) -> FloatArray:
        """The logarithm of the likelihood of gains for a series plus a constant, (R A, K).

        There is one for each of R radii, A amplitudes and K states. The constant has a flat prior
        up to the size of the largest gain.
        """
        constants, error = self.constants
        gained = ((constants / error[:, None, None]) ** 2).sum(axis=1) / 2
        return np.asarray(
            self.evidence + gained + 3 * np.log(error / self.measured.largest)[:, None]
        )

    @cached_property
    def _log_prior(self) -> FloatArray:
        """The logarithm of the prior of each pair of R radii and A amplitudes, (R A, 1).

        The prior is the mean of the uniform distribution and of the posterior averaged over all
        states (empirical Bayes).
        """
        evidence = self.evidence_with_constant if self.has_constant else self.evidence
        shown = _normalised(evidence)[0].mean(axis=1, keepdims=True)
        return np.asarray(np.log((1 / len(evidence) + shown) / 2))

    @cached_property
    def each(self) -> FloatArray:
        """The logarithm of the likelihood of the gains of each of the K states, (K,)."""
        evidence = self.evidence_with_constant if self.has_constant else self.evidence
        return _normalised(evidence + self._log_prior)[1]

    @property
    def total(self) -> float:
        """The logarithm of the likelihood of the gains of all states."""
        return float(self.each.sum())

    @cached_property
    def limit(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """The limits of the gains at vanishing timesteps, and tests of whether they are zero.

        Returns
        -------
        The limits of K states, (K, 3), and their standard errors, (K,), in the unit of the gains,
        and the tails of these tests, (K,)
        """
        (constants, error), units = self.constants, self.measured.units
        weights = _normalised(self.evidence_with_constant + self._log_prior)[0]
        limit = (weights[:, None] * constants).sum(axis=0)
        spread = ((constants - limit) ** 2).mean(axis=1) + error[:, None] ** 2
        squares = ((constants / error[:, None, None]) ** 2).sum(axis=1)
        tails = (weights * _tail(squares)).sum(axis=0)
        return (limit * units).T, np.sqrt((weights * spread).sum(axis=0)) * units, tails

    @cached_property
    def beyond(self) -> NDArray[np.intp]:
        """How many of the longest timesteps are beyond the radius in each of K states, (K,).

        The radius is that of convergence. A timestep counts if it is beyond with a probability of
        1 − `LEVEL` or more.
        """
        weights = _normalised(self.evidence + self._log_prior)[0]
        of_radius = weights.reshape(len(self.inverse_radii), -1, weights.shape[1]).sum(axis=1)
        is_beyond = self.inverse_radii[:, None] * self.measured.x >= 1
        return np.asarray((is_beyond.T @ of_radius >= 1 - LEVEL).sum(axis=0))

    @cached_property
    def innovations(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """The predictions of gains from the gains at longer timesteps, and tests of them.

        The first `PREDICTED_FROM` gains are not predicted: their tail is 1.

        Returns
        -------
        For J timesteps and K states, the probability of an innovation at least as large, (J, K),
        the predictions, (J, K, 3), and their standard deviations, (J, K)
        """
        J, _, K = self.measured.gains.shape
        tails, means, errors = np.ones((J, K)), np.zeros((J, 3, K)), np.zeros((J, K))
        for j in range(PREDICTED_FROM, J):
            mean, variance, weights = self._prediction(j)
            means[j] = (weights[:, None] * mean).sum(axis=0)
            spread = ((mean - means[j]) ** 2).mean(axis=1) + variance[:, None]
            errors[j] = np.sqrt((weights * spread).sum(axis=0))
            squares = ((self.measured.gains[j] - mean) ** 2).sum(axis=1) / variance[:, None]
            tails[j] = (weights * _tail(squares)).sum(axis=0)
        units = self.measured.units
        return tails, np.swapaxes(means * units, 1, 2), errors * units

    def _prediction(self, j: int) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the predictions of gain j from the gains at longer timesteps, by n likely pairs.

        A pair is a radius of convergence and an amplitude of the series. Pairs that are improbable
        in all states are left out.

        Returns
        -------
        The mean of each pair's prediction in K states, (n, 3, K), the variance of a component of
        it, (n,), and the posterior probability of each pair in each state, given the gains at
        longer timesteps, (n, K)
        """
        known, row, K = self.before(j), self.basis[:, j], self.measured.gains.shape[2]
        weights = _normalised(known.evidence + self._log_prior)[0]
        _, squares, right, projected = known._decomposition
        # Pairs that are less probable cannot change whether a tail is below the level.
        pairs = np.flatnonzero((weights > LEVEL**2).any(axis=1))
        of_radius, of_amplitude = np.divmod(pairs, len(self.measured.amplitudes))
        amplitudes = self.measured.amplitudes[of_amplitude, None] ** 2
        seen, squares = (right @ row[:, :, None])[of_radius, :, 0], squares[of_radius, :TERMS]
        count = squares.shape[1]
        shares = amplitudes * seen
        shares[:, :count] /= 1 + amplitudes * squares
        variance = (shares * seen).sum(axis=1) + self.noise[of_radius, j] ** 2
        weighed = shares[:, None, :count] * np.sqrt(squares)[:, None]
        mean = weighed @ projected[of_radius, :count].reshape(len(pairs), count, 3 * K)
        return mean.reshape(len(pairs), 3, K), variance, weights[pairs]


def _inverse_radii(measured: Measured) -> FloatArray:
    """Return the R inverse radii of convergence that are tried, (R,).

    They are in units of 1 / longest timestep. The radii reach from four times the longest timestep
    down to `Measured.radius`. A radius with fewer than `LEAST` timesteps below it, which are too
    few to show a series, is left out.
    """
    count = np.arange(np.log(4 / measured.radius) / np.log(RATIO))
    radii = RATIO ** (count + 0.5) / 4
    within = (radii[:, None] * measured.x < 1).sum(axis=1)
    return np.asarray(radii[within >= min(LEAST, len(measured.x))])


def _tail(squares: FloatArray) -> FloatArray:
    """Return for each of `squares` the probability of a χ² as large, of 3 degrees of freedom.

    This closed form (Abramowitz & Stegun, §26.4.4) takes a quarter of the time of scipy's `chdtrc`.
    """
    root = np.sqrt(squares / 2)
    return np.asarray(erfc(root) + 2 / np.sqrt(np.pi) * root * np.exp(-squares / 2))


def _normalised(logarithms: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return probabilities that add up to 1 over the first axis, given logarithms of weights.

    `softmax` and `logsumexp` of scipy take several times as long.

    Returns
    -------
    The probabilities, and the logarithm of the sum of the weights
    """
    largest = logarithms.max(axis=0)
    weights = np.exp(logarithms - largest)
    summed = weights.sum(axis=0)
    return weights / summed, largest + np.log(summed)
