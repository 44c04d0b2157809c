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

The order is of all states, by maximum likelihood. Radius and amplitude of each state are integrated
over, with a prior that is estimated from all states (Kiefer & Wolfowitz, Ann. Math. Stat. 27 (1956)
887).
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

#: Orders that are tried.
ORDERS = (1, 2, 3, 4, 5, 6)

T = TypeVar("T", Regression, "_Splits")


@dataclass(frozen=True, eq=False)
class GainSeries:
    """What J timesteps, long to short, show of K states.

    Attributes
    ----------
    order : of the series
    tails : the probability that a gain is as far off its prediction, (J, K); 1 where it has none
    limit_tails : likewise that the limit is as far from zero, (K,)
    limit, limit_error : of each state, at vanishing timesteps, (K, 3), and its standard error, (K,)
    predicted, predicted_to : each gain as those with longer timesteps predict it, (J, K, 3), and
        its standard deviation, (J, K)
    changes : the index of the first timestep that follows a second series, (K,); 0 where all
        timesteps follow one
    beyond : how many of the longest timesteps are certainly beyond the radius of convergence, (K,)
    is_pooled : whether the limits of the states are independent, so that they are tested together
    lone_timestep : the index of the only timestep whose gains are off; None if it is not a single
        one
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
        """The smallest tail of each state, (K,)."""
        return np.asarray(np.minimum(self.tails.min(axis=0), self.limit_tails))

    @property
    def tail(self) -> float:
        """The probability that some gain, or all limits together, are as unlikely as they are."""
        return float(min(1.0, 2 * min(self.least_tails.min() * self.tests, self.pooled_tail)))

    @property
    def pooled_tail(self) -> float:
        """The probability that the limits of all states together are as far from zero.

        This finds a fault that is too small to show in the limit of any single state.
        """
        if not self.is_pooled:
            return 1.0
        squares = (self.limit**2).sum(axis=1) / self.limit_error**2
        return float(chdtrc(3 * len(squares), squares.sum()))

    @property
    def tests(self) -> int:
        """How many tails are tested, by which the smallest is multiplied (Bonferroni)."""
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
    """Fit the model to what steps gain.

    Where one series leaves a tail below the level, two are tried, for a method that computes short
    steps by another formula than long ones: each of the two must vanish with the timestep. It is
    not known at which timestep the formula changes, so the method counts as consistent if no tail
    is below the level for one of the possible changes. As two series can follow almost any gains,
    this does not hold where a single timestep that is off explains them better, by the level: that
    is a fault.

    Parameters
    ----------
    timesteps : long to short, s, (J,)
    gains : a second, (J, K, 3)
    noise : its standard deviation in each component, (J, K)
    level : a smallest tail below it is a fault
    turns : the angle by which each step turns the body, or the angle's rank, (J, K); None if it is
        not known
    changes_elsewhere : changes that other quantities of the same steps show, (K,) each; they are
        tried first
    may_split : whether two series are tried
    is_pooled : whether the limits of the states are independent, so that they are tested together
    """
    measured = Measured.of(timesteps, gains, noise, turns)
    fit = _likeliest(lambda order: Regression.of(measured, order))
    one = _one_series(fit, is_pooled=is_pooled)
    if one.tail >= level:
        return one
    lone_timestep, total = _off_alone(measured)
    if may_split and len(timesteps) > LEAST:
        splits = _likeliest(lambda order: _Splits.of(measured, order))
        tried = [*splits.changes[splits.totals > total + np.log(level)]]
        # A single timestep that is off is not excused by a change that another quantity shows.
        for changes in tried if total > fit.total else [*changes_elsewhere, *tried]:
            two = _two_series(one, splits, changes)
            if two.tail >= level:
                return two
    off = _likeliest(lambda order: Regression.of(measured, order, has_constant=True))
    limit, limit_error, _ = off.limit
    return replace(
        one,
        limit=limit,
        limit_error=limit_error,
        lone_timestep=lone_timestep if total > max(off.total, fit.total - np.log(level)) else None,
    )


def _likeliest(fit: Callable[[int], T]) -> T:
    """The fit of the likeliest order; the likelihood is taken to have a single maximum."""
    best = fit(ORDERS[0])
    for order in ORDERS[1:]:
        other = fit(order)
        if other.total <= best.total:
            break
        best = other
    return best


def _one_series(fit: Regression, *, is_pooled: bool) -> GainSeries:
    """Tails, limits and predictions where all timesteps follow one series."""
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
    """Tails and limits where the shorter steps of a state follow a second series.

    Parameters
    ----------
    changes : the index of the first timestep that does, (K,); 0 where none does
    """
    tails, limit_tails = one.tails.copy(), one.limit_tails.copy()
    limit, limit_error = one.limit.copy(), one.limit_error.copy()
    beyond = one.beyond.copy()
    for change in np.unique(changes):
        states, parts = changes == change, splits.parts[change]
        tails[:, states] = np.concatenate([part.innovations[0] for part in parts])[:, states]
        beyond[states] = parts[0].beyond[states]
        # With fewer gains a limit cannot be told from a series.
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


def _off_alone(measured: Measured) -> tuple[int, float]:
    """The timestep that explains the gains best if it alone is off.

    Its gains may then be anything: their noise is raised to their own size.

    Returns
    -------
    Its index, and the logarithm of the likelihood of all gains
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
    """All ways that are tried to split the timesteps of each state into two series.

    Attributes
    ----------
    parts : the fits of the series, by the index of the timestep that begins the second one; first
        the fit of one series to all timesteps
    changes : that index for each state, in n ways, the likeliest first, (n, K)
    totals : the logarithm of the likelihood of the gains of all states in each way, (n,)
    """

    order: int
    parts: list[tuple[Regression, ...]]
    changes: NDArray[np.intp]
    totals: FloatArray

    @staticmethod
    def of(measured: Measured, order: int) -> "_Splits":
        """Fit series of one order in all ways."""
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
        """The logarithm of the likelihood of the gains of all states in the likeliest way."""
        return float(self.totals[0])
