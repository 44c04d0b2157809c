"""The model of verdicts: what steps gain is a series of the timestep that vanishes, and noise.

A step of a method of order p that is consistent with the equations of motion gains, beyond the
exact motion and per second, g(h) = Σ_{i≥p} a_i (h/H)^i, an analytic function of the timestep
(Hairer, Nørsett & Wanner I, §II.3 and §II.8). What is measured is g(h) + e(h), with noise e of
known scale (`noise.py`). The coefficients are taken to be a_i ~ N(0, s² r^2(i−p)): 1/r is the
radius of convergence, in units of the longest timestep H, and s the amplitude of a state. So gains
with all timesteps are jointly Gaussian, and each is predicted from those with longer timesteps. The
innovation of a prediction, in units of its standard deviation, is the statistic (Gauss–Richardson
extrapolation: Oates, Karvonen, Teckentrup, Strocchi & Niederer, arXiv 2401.07562). A constant added
to the series, with a flat prior, is the limit at vanishing timesteps, with its standard error.

Order and radius are of all states, by maximum likelihood. The amplitude of each state is integrated
over, with a prior that is estimated from the amplitudes of all states (Kiefer & Wolfowitz, Ann.
Math. Stat. 27 (1956) 887).
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from ....scenarios import FloatArray

#: Orders and inverse radii of convergence that are tried, and terms of the series that are kept.
ORDERS, RADII, TERMS = (1, 2, 3, 4, 5, 6), (0.5, 1.0, 2.0, 4.0), 9
#: Ratio of neighbouring amplitudes of the grid that is integrated over.
SPACING = 10**0.25
#: Share of the amplitude's prior that is the same everywhere, and steps of its estimation.
LEAK, ESTIMATIONS = 0.1, 3
#: Gains with longer timesteps that a prediction needs.
PREDICTED_FROM = 2
#: Gains that tell a limit, if steps are computed otherwise from some timestep on.
LEAST = 4


@dataclass(frozen=True, eq=False)
class GainSeries:
    """What J timesteps, long to short, show of K states.

    Attributes
    ----------
    order, radius : of the series; `radius` is the inverse radius of convergence
    tails : the probability that a gain is as far off its prediction, (J, K); 1 where it has none
    limit_tails : likewise that the limit is as far from zero, (K,)
    limit, known_to : of each state, at vanishing timesteps, (K, 3), and its standard error, (K,)
    predicted, predicted_to : each gain as those with longer timesteps predict it, (J, K, 3), and
        its standard deviation, (J, K)
    changes : the index of the timestep from which on steps are computed otherwise, (K,); 0 where
        there is none
    """

    order: int
    radius: float
    tails: FloatArray
    limit_tails: FloatArray
    limit: FloatArray
    known_to: FloatArray
    predicted: FloatArray
    predicted_to: FloatArray
    changes: NDArray[np.intp]
    is_pooled: bool = True

    @property
    def least_tails(self) -> FloatArray:
        """The smallest tail of each state, (K,)."""
        return np.asarray(np.minimum(self.tails.min(axis=0), self.limit_tails))

    @property
    def tail(self) -> float:
        """The probability that some gain, or all limits together, are as unlikely as they are."""
        return float(min(1.0, 2 * min(self.least_tails.min() * self.tests, self.pooled_tail)))

    @property
    def pooled_tail(self) -> float:
        """The probability that the limits of all states are as far from zero together.

        A fault that moves all of them a little shows in none by itself.
        """
        if not self.is_pooled:
            return 1.0
        squares = (self.limit**2).sum(axis=1) / self.known_to**2
        return float(chdtrc(3 * len(squares), squares.sum()))

    @property
    def tests(self) -> int:
        """How many tails there are that could have been small."""
        J, K = self.tails.shape
        return int((J - PREDICTED_FROM + 1) * K)


def fitted(
    timesteps: FloatArray,
    gains: FloatArray,
    noise: FloatArray,
    level: float,
    *,
    rates: FloatArray | None = None,
    may_split: bool = True,
    is_pooled: bool = True,
) -> GainSeries:
    """Fit the model to what steps gain.

    Where one series leaves a tail below the level, two are tried: of a method that computes shorter
    steps otherwise, both of which must vanish with the timestep. So may the longest timesteps be
    beyond the radius of convergence.

    Parameters
    ----------
    timesteps : long to short, s, (J,)
    gains : a second, (J, K, 3)
    noise : its standard deviation in each component, (J, K)
    level : tails below it, together, are a fault
    rates : how fast the body turns in each state, rad/s, (K,); None where it is not known
    may_split : whether two series are tried
    is_pooled : whether the limits of states are independent, and are judged together, too
    """
    measured = _Measured.of(timesteps, gains, noise, rates)
    one = replace(_one_series(measured), is_pooled=is_pooled)
    if one.tail >= level:
        return one
    if may_split and len(timesteps) > LEAST:
        two = _two_series(measured, one)
        if two.tail >= level:
            return two
    return _off_limit(measured, one)


@dataclass(frozen=True, eq=False)
class _Measured:
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
    ) -> "_Measured":
        """Scale gains by each state's noise; how it depends on timesteps is as in the noisiest."""
        units = np.median(noise / np.median(noise, axis=1, keepdims=True), axis=0)
        scaled, alike = gains / units[:, None], (noise / units).max(axis=1)
        least, largest = 0.1 * alike.min(), 1e3 * (np.abs(scaled).max() + alike.max())
        count = int(np.ceil(np.log(largest / least) / np.log(SPACING)))
        amplitudes = least * SPACING ** np.arange(count + 1)
        x = timesteps / timesteps[0]
        turns = x[:, None] * (np.ones(len(units)) if rates is None else rates)
        return _Measured(x, scaled, alike, units, amplitudes, turns)

    def changes(self, last: int) -> NDArray[np.intp]:
        """The index of the timestep from which on steps may be computed otherwise, (n, K).

        One row for each timestep, the same for all states, and one for each turn. 0 in states whose
        gains are one series: all of their steps are on one side, or those beyond `last` are.
        """
        by_timestep = np.repeat(np.arange(1, last + 1)[:, None], self.turns.shape[1], axis=1)
        by_turn = (self.turns[:, :, None] > np.unique(self.turns)).sum(axis=0).T
        found = np.unique(np.concatenate([by_timestep, by_turn]), axis=0)
        return np.where(found <= last, found, 0)


@dataclass(frozen=True, eq=False)
class _Whitened:
    """Innovations of J gains of K states, in standard deviations, at each of A amplitudes.

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
    def of(measured: _Measured, order: int, radius: float, first: int = 0) -> "_Whitened":
        """Whiten the gains from the first on.

        The Cholesky factor of their covariance, noise² + amplitude² · basis · basisᵀ, is found by
        orthogonal triangularisation, as the two terms differ by up to 10²⁶.
        """
        x, noise, gains = measured.x[first:], measured.noise[first:], measured.gains[first:]
        J, K, _ = gains.shape
        basis = x**order * (radius * x) ** np.arange(TERMS)[:, None]
        stacked = np.empty((len(measured.amplitudes), J + TERMS, J))
        stacked[:, :J] = np.diag(noise)
        stacked[:, J:] = measured.amplitudes[:, None, None] * basis
        upper = np.linalg.qr(stacked, mode="r")
        diagonal = np.diagonal(upper, axis1=1, axis2=2)
        lower = np.swapaxes(upper * np.sign(diagonal)[:, :, None], 1, 2)
        sigma = np.abs(diagonal)
        columns = np.concatenate([gains.reshape(J, -1), np.ones((J, 1))], axis=1)
        white = np.empty((len(sigma), *columns.shape))
        for j in range(J):
            known = (lower[:, j, None, :j] @ white[:, :j])[:, 0]
            white[:, j] = (columns[j] - known) / sigma[:, j, None]
        innovations = white[:, :, :-1].reshape(len(sigma), J, K, 3)
        return _Whitened(innovations, white[:, :, -1], sigma)

    def until(self, beyond: int) -> "_Whitened":
        """The first gains alone."""
        return _Whitened(
            self.innovations[:, :beyond], self.ones[:, :beyond], self.sigma[:, :beyond]
        )

    @cached_property
    def likelihoods(self) -> FloatArray:
        """The logarithm of the density of each gain, given those before it, (A, J, K)."""
        squares = (self.innovations**2).sum(axis=3)
        return np.asarray(-squares / 2 - 3 * np.log(self.sigma)[:, :, None])

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
        tails = (self._weights(prior) * chdtrc(3, (self.innovations**2).sum(axis=3))).sum(axis=0)
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
        """The probability of each amplitude, given the gains before each, (A, J, K)."""
        each = self.likelihoods
        before = np.cumsum(each, axis=1) - each + np.log(prior)[:, None, None]
        return _normalised(before)

    def limit(self, prior: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """The limit, (K, 3), its standard error, (K,), and the tail of its being zero, (K,)."""
        constants, error = self.constants
        weights = _normalised(self.evidence_with_constant + np.log(prior)[:, None])
        limit = (weights[..., None] * constants).sum(axis=0)
        spread = ((constants - limit) ** 2).mean(axis=2) + error[:, None] ** 2
        squares = ((constants / error[:, None, None]) ** 2).sum(axis=2)
        tails = (weights * chdtrc(3, squares)).sum(axis=0)
        return limit, np.sqrt((weights * spread).sum(axis=0)), tails


def _log_sum(logarithms: FloatArray) -> FloatArray:
    """The logarithm of the sum over the first axis; scipy's takes ten times as long."""
    largest = logarithms.max(axis=0)
    return np.asarray(largest + np.log(np.exp(logarithms - largest).sum(axis=0)))


def _normalised(logarithms: FloatArray) -> FloatArray:
    """Probabilities over the first axis."""
    weights = np.exp(logarithms - logarithms.max(axis=0))
    return np.asarray(weights / weights.sum(axis=0))


def _prior(evidence: FloatArray) -> tuple[FloatArray, float]:
    """The distribution of amplitudes that the states show, (A,), and how likely they are by it."""
    count = len(evidence)
    prior = np.full(count, 1 / count)
    for _ in range(ESTIMATIONS):
        posterior = _normalised(evidence + np.log(prior)[:, None])
        prior = (1 - LEAK) * posterior.mean(axis=1) + LEAK / count
    return prior, float(_log_sum(evidence + np.log(prior)[:, None]).sum())


@dataclass(frozen=True, eq=False)
class _Fit:
    """Innovations of one order and radius, and the prior of the amplitudes that goes with them."""

    total: float
    order: int
    radius: float
    prior: FloatArray
    white: _Whitened


def _most_likely(measured: _Measured, *, constant: bool) -> _Fit:
    """The most likely order, and then radius, of a series with a constant or without."""

    def tried(order: int, radius: float) -> _Fit:
        white = _Whitened.of(measured, order, radius)
        prior, total = _prior(white.evidence_with_constant if constant else white.evidence)
        return _Fit(total, order, radius, prior, white)

    first = max((tried(order, 1.0) for order in ORDERS), key=lambda one: one.total)
    others = (tried(first.order, radius) for radius in RADII if radius != 1.0)
    return max([first, *others], key=lambda one: one.total)


def _one_series(measured: _Measured) -> GainSeries:
    """What one series leaves."""
    fit = _most_likely(measured, constant=False)
    limit, known_to, limit_tails = fit.white.limit(fit.prior)
    mean, error = fit.white.predictions(measured.gains, fit.prior)
    units = measured.units
    return GainSeries(
        fit.order,
        fit.radius,
        fit.white.tails(fit.prior),
        limit_tails,
        limit * units[:, None],
        known_to * units,
        mean * units[:, None],
        error * units,
        np.zeros(len(units), dtype=int),
    )


def _off_limit(measured: _Measured, one: GainSeries) -> GainSeries:
    """The same, with the limit by the order and radius that are most likely if it is not zero."""
    fit = _most_likely(measured, constant=True)
    limit, known_to, _ = fit.white.limit(fit.prior)
    units = measured.units
    return replace(one, limit=limit * units[:, None], known_to=known_to * units)


def _two_series(measured: _Measured, one: GainSeries) -> GainSeries:
    """What is left where steps shorter than one timestep or one turn are computed otherwise.

    The timestep or turn is the most likely one, and is the same for all states, as are order and
    radius.
    """
    first = max((_Split.of(measured, order, 1.0) for order in ORDERS), key=lambda one: one.total)
    others = (_Split.of(measured, first.order, radius) for radius in RADII if radius != 1.0)
    best = max([first, *others], key=lambda one: one.total)
    tails, limit_tails = one.tails.copy(), one.limit_tails.copy()
    limit, known_to = one.limit.copy(), one.known_to.copy()
    flat = np.full(len(measured.amplitudes), 1 / len(measured.amplitudes))
    for change in np.unique(best.changes):
        states, parts = best.changes == change, best.parts[change]
        tails[:, states] = np.concatenate([part.tails(flat) for part in parts])[:, states]
        limits, errors, of_limits = zip(*(part.limit(flat) for part in parts), strict=True)
        limit[states] = (limits[-1] * measured.units[:, None])[states]
        known_to[states] = (errors[-1] * measured.units)[states]
        # Fewer gains than that tell no limit from a series.
        tested = of_limits if change == 0 or change >= LEAST else of_limits[1:]
        limit_tails[states] = np.min(tested, axis=0)[states]
    return replace(
        one,
        order=best.order,
        radius=best.radius,
        tails=tails,
        limit_tails=limit_tails,
        limit=limit,
        known_to=known_to,
        changes=best.changes,
    )


@dataclass(frozen=True, eq=False)
class _Split:
    """Gains as two series, of longer and shorter timesteps.

    Attributes
    ----------
    total : the logarithm of how likely the gains of all states are
    parts : the series of the whole, then those of which the second begins at each timestep
    changes : which of `parts` is that of each state, (K,)
    """

    total: float
    order: int
    radius: float
    parts: list[tuple[_Whitened, ...]]
    changes: NDArray[np.intp]

    @staticmethod
    def of(measured: _Measured, order: int, radius: float) -> "_Split":
        """The most likely change, by one order and radius."""
        whole, count = _Whitened.of(measured, order, radius), len(measured.x)
        starts = range(1, count - LEAST + 1)
        pairs = [(whole.until(c), _Whitened.of(measured, order, radius, c)) for c in starts]
        parts = [(whole,), *pairs]
        each = np.array([sum(_log_sum(part.evidence) for part in one) for one in parts])
        # A pair has two amplitudes, each of which may be any of the grid.
        each[1:] -= np.log(len(measured.amplitudes))
        tried = measured.changes(count - LEAST)
        totals = np.take_along_axis(each, tried, axis=0).sum(axis=1)
        best = int(totals.argmax())
        return _Split(float(totals[best]), order, radius, parts, tried[best])
