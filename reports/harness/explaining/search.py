"""Searches for changes of a scene's equations, or of how states are read, that explain data.

Changes are compared by χ², the sum of squares of the residuals in units of their standard
deviation. A change with more parameters is preferred to a simpler one if it lowers χ² by more than
noise would, given the number of further parameters and the number of changes that are tried: a
likelihood-ratio test (S. S. Wilks, Ann. Math. Statist. 9 (1938) 60) with Bonferroni's correction.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import chdtri

from ....scenarios import FloatArray
from .fit import Data, Fit, Linear, Trial, linear, of_pairs
from .hypothesis import Change

#: The significance level: the probability that a search finds a change in noise alone.
SIGNIFICANCE = 1e-6
#: A change explains residuals if it reduces their root mean square to this fraction or less.
LEFT = 0.1
#: A change that reduces it to this fraction or less explains residuals exactly, up to rounding.
SAME = 1e-3
#: The most parameters of a fit whose residuals do not exceed noise, if `Search.most` is given. With
#: more parameters, wrong equations can match a smooth motion that turns by a few radians only.
MOST_OF_ALL = 10
#: A change is fitted if, linearised, it reduces the root mean square of the residuals to the
#: fraction `PROMISING` or less. A pair of changes is fitted if, linearised, its residuals are at
#: most this fraction of those of the better one of the two changes alone. Of the pairs with equal
#: numbers of parameters only the best `PAIRS` are fitted.
PROMISING, PAIRS = 0.5, 3


@dataclass(frozen=True, eq=False)
class Search:
    """The search for changes of equations, or of how states are read, that explain data.

    Attributes
    ----------
    changes : the changes that are tried
    most : the most parameters of a fit whose residuals exceed noise and a method's error, because a
        fit with many parameters explains a part of any data; no limit if None
    part : the fraction to which a change must reduce the root mean square of the residuals to
        explain them; a change that leaves no more than noise explains them in any case
    """

    data: Data
    changes: Sequence[Change]
    most: int | None = None
    part: float = LEFT

    @cached_property
    def unchanged(self) -> Fit:
        """The fit of `data.base` as it is, without any change."""
        return Trial(self.data, ()).fit()

    @property
    def is_called_for(self) -> bool:
        """Whether the residuals without any change exceed noise and a method's error."""
        residuals = self.unchanged.residuals
        return self.data.chi2_decrease(residuals, 0 * residuals) > self._critical(1)

    def exceed_noise(self, residuals: FloatArray) -> bool:
        """Return whether m residuals, (m,), are larger than noise and a method's error explain."""
        degrees, level = residuals.size / self.data.correlated, SIGNIFICANCE / len(self.changes)
        chi2 = self.data.chi2_decrease(residuals, 0 * residuals)
        return chi2 > float(chdtri(degrees, level))

    def one_or_two(self) -> Fit | None:
        """Return the fit of the change, or of the pair of changes, that explains the data.

        Pairs are tried only if no single change leaves residuals as small as noise.

        Returns
        -------
        None if no change or pair does, or if the data need no change
        """
        if not self.is_called_for:
            return None
        best = self.one()
        if best is not None and best.mean_square <= 1:
            return best
        return self._simplest([*self.single, *self._pairs()])

    def one(self) -> Fit | None:
        """Return the fit of the single change that explains the data; None if none does."""
        return self._simplest(self.single)

    @cached_property
    def single(self) -> list[Fit]:
        """The fits of single changes that are promising; none if the data need no change.

        A change is promising if, linearised, it reduces the root mean square of the residuals to
        the fraction `PROMISING` or less.
        """
        if not self.is_called_for:
            return []
        enough = PROMISING**2 * self.unchanged.mean_square
        pairs = zip(self.changes, self.linear, strict=True)
        promising = [change for change, one in pairs if one.mean_square <= enough]
        return [Trial(self.data, (change,)).fit() for change in promising]

    @cached_property
    def linear(self) -> list[Linear]:
        """The changes, each made alone and linearised, in the order of `changes`."""
        return linear(self.data, self.data.base, self.changes)

    def _pairs(self) -> list[Fit]:
        """Return the fits of pairs of changes that together explain far more than either one alone.

        Among pairs with equal numbers of parameters, only the best when linearised are fitted.
        """
        alone, best = np.array([one.mean_square for one in self.linear]), []
        for both, pairs in of_pairs(self.linear, self.unchanged.residuals):
            needed = np.flatnonzero(both <= PROMISING**2 * alone[pairs].min(axis=1))
            best += [pairs[k] for k in needed[np.argsort(both[needed], kind="stable")[:PAIRS]]]
        # Pairs stay in the order of the changes: of equally good ones the first is reported.
        changes = [(self.changes[i], self.changes[j]) for i, j in sorted(map(tuple, best))]
        return [Trial(self.data, both).fit() for both in changes]

    def _simplest(self, fits: Sequence[Fit]) -> Fit | None:
        """Return, among some fits, the one with the fewest parameters that explains the data.

        A fit with more parameters is returned instead if it lowers χ² significantly, and one with
        as many parameters if it leaves far smaller residuals. Fits that are not physical, or have
        too many parameters, are ignored.

        Returns
        -------
        None if no fit explains the data
        """
        count = self.unchanged.residuals.size
        enough = max(largest_of_noise(count), self.part**2 * self.unchanged.mean_square)
        best = self.unchanged
        # The order of fits with the same rank stays: of equally good ones the first is reported.
        for fit in sorted(fits, key=lambda fit: fit.rank):
            explains = fit.mean_square <= enough and self.improvement(self.unchanged, fit) > 0
            explains = explains and fit.is_physical and self._has_few_parameters(fit)
            if explains and (self.improvement(best, fit) > 0 or self._is_closer(fit, best)):
                best = fit
        return None if best is self.unchanged else best

    def _is_closer(self, fit: Fit, best: Fit) -> bool:
        """Return whether a fit has the same rank as `best`, and far smaller residuals.

        If the residuals of `best` are as small as rounding, it returns False.
        """
        is_more = best.mean_square > SAME**2 * self.unchanged.mean_square
        is_far_less = fit.mean_square < LEFT**2 * best.mean_square
        return fit.rank == best.rank and is_more and is_far_less

    def _has_few_parameters(self, fit: Fit) -> bool:
        """Return whether a fit has no more parameters than an explanation may have.

        It may have up to `most`, and up to `MOST_OF_ALL` if its residuals do not exceed noise.
        """
        if self.most is None or fit.rank <= self.most:
            return True
        return fit.rank <= MOST_OF_ALL and not self.exceed_noise(fit.residuals)

    def improvement(self, before: Fit, after: Fit) -> float:
        """Return by how much χ² decreases from one fit to another, less what noise may cause.

        It is positive if the fit `after`, which has more parameters, is significantly better.
        """
        decrease = self.data.chi2_decrease(before.residuals, after.residuals)
        return decrease - self._critical(after.rank - before.rank)

    def _critical(self, parameters: int) -> float:
        """Return the smallest decrease of χ² at which further parameters are significant.

        The significance level is divided by the number of changes that are tried (Bonferroni).

        Parameters
        ----------
        parameters : number of further parameters; if it is less than one, it counts as one
        """
        return float(chdtri(max(1, parameters), SIGNIFICANCE / len(self.changes)))


def largest_of_noise(count: int) -> float:
    """Return the largest mean square of residuals that are noise, at the significance level.

    Parameters
    ----------
    count : number of the residuals
    """
    return float(chdtri(count, SIGNIFICANCE)) / count
