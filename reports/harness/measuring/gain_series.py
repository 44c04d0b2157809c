"""The model by which gains are judged: a power series that vanishes with the timestep, plus noise.

The gain of a step of a method of order p that is consistent with the equations of motion is g(h) =
Σ_{i≥p} a_i (h/H)^i, an analytic function of the timestep h (Hairer, Nørsett & Wanner I, §II.3 and
§II.8). The measured gain is g(h) + e(h), with noise e of known scale (`noise.py`). The coefficients
have the prior a_i ~ N(0, s² r^2(i−p)). Here H is the longest timestep, 1/r the radius of
convergence in units of H, and s the amplitude of the coefficients; r and s differ from state to
state. So the gains at all timesteps are jointly Gaussian, and each gain is predicted from the gains
at longer timesteps. The test statistic is the innovation of a prediction, in units of its standard
deviation (Gauss–Richardson extrapolation: Oates, Karvonen, Teckentrup, Strocchi & Niederer, arXiv
2401.07562). The limit at vanishing timesteps, and its standard error, are those of a constant added
to the series, with a flat prior.

One order is estimated for all states, by maximum likelihood. Radius and amplitude of each state are
integrated over, with a prior that is estimated from all states (Kiefer & Wolfowitz, Ann. Math.
Stat. 27 (1956) 887).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from ....scenarios import FloatArray
from .regression import LEAST, PREDICTED_FROM, Measured, Regression

#: Orders of the series that are tried.
ORDERS = (1, 2, 3, 4, 5, 6)

T = TypeVar("T", Regression, "_Splits")


@dataclass(frozen=True, eq=False)
class GainSeries:
    """The series fitted to the gains of one quantity, at J timesteps, long to short, from K states.

    Attributes
    ----------
    order : the order of the series
    tails : the probability of an innovation at least as large as that of each gain, (J, K); 1 where
        a gain is not predicted
    limit_tails : the probability of an estimate at least as far from zero if the limit is zero,
        (K,)
    limit : the limit of each state's gains at vanishing timesteps, in the unit of the gains, (K, 3)
    limit_error : the standard error of each component of that limit, (K,)
    predicted : the prediction of each gain from the gains at longer timesteps, (J, K, 3)
    predicted_to : the standard deviation of that prediction, (J, K)
    changes : the index of the first timestep that follows a second series, (K,); 0 where all
        timesteps follow one series
    beyond : how many of the longest timesteps are certainly beyond the radius of convergence, (K,)
    is_pooled : whether the limits of the states are independent, so that they are tested together
    lone_timestep : the index of the only timestep whose gains do not fit the series; None if no
        single timestep explains the misfit
    """

    order: int
    tails: FloatArray
    limit_tails: FloatArray
    limit: FloatArray
    limit_error: FloatArray
    predicted: FloatArray
    predicted_to: FloatArray
    changes: NDArray[np.intp]
    beyond: NDArray[np.intp]
    is_pooled: bool = True
    lone_timestep: int | None = None

    @property
    def least_tails(self) -> FloatArray:
        """The smallest of the tails of gains and limit, for each of K states, (K,)."""
        return np.asarray(np.minimum(self.tails.min(axis=0), self.limit_tails))

    @property
    def tail(self) -> float:
        """The tail of all tests together (Bonferroni): of gains, limits, and the pooled limits."""
        return float(min(1.0, 2 * min(self.least_tails.min() * self.tests, self.pooled_tail)))

    @property
    def pooled_tail(self) -> float:
        """The tail of a χ² test of whether the limits of all states are zero; 1 if not pooled.

        It finds a fault that is too small to show in the limit of any single state.
        """
        if not self.is_pooled:
            return 1.0
        squares = (self.limit**2).sum(axis=1) / self.limit_error**2
        return float(chdtrc(3 * len(squares), squares.sum()))

    @property
    def tests(self) -> int:
        """The number of tests of single gains and limits, for Bonferroni's correction."""
        J, K = self.tails.shape
        return int((J - PREDICTED_FROM + 1) * K)


def fitted(
    timesteps: FloatArray,
    gains: FloatArray,
    noise: FloatArray,
    level: float,
    *,
    turns: FloatArray | None = None,
    changes_elsewhere: Sequence[NDArray[np.intp]] = (),
    may_split: bool = True,
    is_pooled: bool = True,
) -> GainSeries:
    """Fit power series in the timestep to the gains of steps in one quantity.

    If the tail of a fit by one series is below the level, two series are tried, for a method that
    computes short steps by another formula than long steps. Each of the two must vanish with the
    timestep. The change point, at which the formula changes, is unknown: the method counts as
    consistent if the tail reaches the level for one of the possible change points. As two series
    can follow almost any gains, they are not accepted if the gains are more likely by a factor
    1/`level` under the assumption that a single timestep deviates from one series: such a timestep
    is a fault.

    Parameters
    ----------
    timesteps : J timesteps, long to short, s, (J,)
    gains : gains of the steps from K states, in any unit, (J, K, 3)
    noise : standard deviation of each component of a gain, (J, K)
    level : the significance level; a tail below it is a fault
    turns : the angle by which each step turns the body, or the angle's rank, (J, K), as a change
        point may be an angle; if it is None, change points are timesteps
    changes_elsewhere : change points, as in `GainSeries.changes`, that other quantities of the same
        steps show, (K,) each; they are tried first
    may_split : whether two series are tried
    is_pooled : whether the limits of all states are tested together, too, as independent ones
    """
    measured = Measured.of(timesteps, gains, noise, turns)
    fit = _likeliest(lambda order: Regression.of(measured, order))
    one = _one_series(fit, is_pooled=is_pooled)
    if one.tail >= level:
        return one
    lone_timestep, total = _lone_deviation(measured)
    if may_split and len(timesteps) > LEAST:
        splits = _likeliest(lambda order: _Splits.of(measured, order))
        tried = [*splits.changes[splits.totals > total + np.log(level)]]
        # A change point that another quantity shows does not excuse a single deviating timestep.
        for changes in tried if total > fit.total else [*changes_elsewhere, *tried]:
            two = _two_series(one, splits, changes)
            if two.tail >= level:
                return two
    with_limit = _likeliest(lambda order: Regression.of(measured, order, has_constant=True))
    limit, limit_error, _ = with_limit.limit
    return replace(
        one,
        limit=limit,
        limit_error=limit_error,
        lone_timestep=lone_timestep
        if total > max(with_limit.total, fit.total - np.log(level))
        else None,
    )


def _likeliest(fit: Callable[[int], T]) -> T:
    """Return the fit of a series with the most likely order.

    The orders in `ORDERS` are tried from the lowest up, until the likelihood decreases.

    Parameters
    ----------
    fit : returns the fit with a given order
    """
    best = fit(ORDERS[0])
    for order in ORDERS[1:]:
        other = fit(order)
        if other.total <= best.total:
            break
        best = other
    return best


def _one_series(fit: Regression, *, is_pooled: bool) -> GainSeries:
    """Return the result of a fit in which the gains at all timesteps follow one series.

    Parameters
    ----------
    is_pooled : whether the limits of the states are independent, so that they are tested together
    """
    limit, limit_error, limit_tails = fit.limit
    return GainSeries(
        fit.order,
        fit.innovations[0],
        limit_tails,
        limit,
        limit_error,
        *fit.innovations[1:],
        np.zeros(len(limit), dtype=int),
        fit.beyond,
        is_pooled,
    )


def _two_series(one: GainSeries, splits: "_Splits", changes: NDArray[np.intp]) -> GainSeries:
    """Return the result of a fit in which the shorter steps of some states follow a second series.

    Parameters
    ----------
    one : the result with one series, whose predictions are kept
    splits : fits of two series, for each index at which the second may begin
    changes : for each of K states, the index of the first timestep that follows the second series,
        (K,); 0 where all timesteps follow one series
    """
    tails, limit_tails = one.tails.copy(), one.limit_tails.copy()
    limit, limit_error = one.limit.copy(), one.limit_error.copy()
    beyond = one.beyond.copy()
    for change in np.unique(changes):
        states, parts = changes == change, splits.parts[change]
        tails[:, states] = np.concatenate([part.innovations[0] for part in parts])[:, states]
        beyond[states] = parts[0].beyond[states]
        # With fewer gains a limit cannot be told from the terms of a series.
        found = [part.limit for part in parts if len(part.measured.x) >= LEAST]
        finest, error, _ = found[-1]
        limit[states], limit_error[states] = finest[states], error[states]
        limit_tails[states] = np.min([of_limit for _, _, of_limit in found], axis=0)[states]
    return replace(
        one,
        order=splits.order,
        tails=tails,
        limit_tails=limit_tails,
        limit=limit,
        limit_error=limit_error,
        changes=changes,
        beyond=beyond,
    )


def _lone_deviation(measured: Measured) -> tuple[int, float]:
    """Return the timestep without whose gains the model fits best.

    Each timestep's gains are left out in effect, by raising their noise to their own size.

    Returns
    -------
    The index of the timestep, and the logarithm of the likelihood of all gains with that noise
    """

    def total(j: int) -> float:
        noise = measured.noise.copy()
        noise[j] += np.abs(measured.gains[j]).max()
        others = replace(measured, noise=noise)
        return _likeliest(lambda order: Regression.of(others, order)).total

    totals = [total(j) for j in range(len(measured.x))]
    return int(np.argmax(totals)), max(totals)


@dataclass(frozen=True, eq=False)
class _Splits:
    """Fits of series to gains, for n ways of splitting the timesteps of each of K states in two.

    Attributes
    ----------
    order : the order of all series
    parts : the fits of one or two series: at index j, the second series begins at timestep j; at
        index 0, one series is fitted to all timesteps
    changes : for each way and each state, the index in `parts` of the fits that it uses; the most
        likely way comes first, (n, K)
    totals : the logarithm of the likelihood of the gains of all states in each way, (n,)
    """

    order: int
    parts: list[tuple[Regression, ...]]
    changes: NDArray[np.intp]
    totals: FloatArray

    @staticmethod
    def of(measured: Measured, order: int) -> "_Splits":
        """Fit series of a given order to the gains, with timesteps split in all ways.

        The ways are those of `Measured.changes`.
        """
        count = len(measured.x)
        edges = [(0, count), *((0, change, count) for change in range(1, count))]
        parts = [
            tuple(Regression.of(measured.part(*ends), order) for ends in pairwise(of_one))
            for of_one in edges
        ]
        each = np.array([sum(part.each for part in one) for one in parts])
        tried = measured.changes(count - LEAST)
        totals = np.take_along_axis(each, tried, axis=0).sum(axis=1)
        likeliest = np.argsort(-totals)
        return _Splits(order, parts, tried[likeliest], totals[likeliest])

    @property
    def total(self) -> float:
        """The logarithm of the likelihood of all gains, for the likeliest split of timesteps."""
        return float(self.totals[0])
