"""Searches for the changes of a scene's equations, or of how states are read, that data call for.

Changes are compared by χ², the sum of squares of the residuals in units of their standard
deviation. A change is preferred to a simpler one if it lowers χ² by more than chance does with as
many more parameters, among as many changes: a likelihood-ratio test (S. S. Wilks, Ann. Math.
Statist. 9 (1938) 60) with Bonferroni's correction.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import chdtri

from ....scenarios import FloatArray
from .fit import Data, Fit, Linear, Trial, linear, of_pairs
from .hypothesis import Change

#: The significance level: the probability that noise alone makes a search find a change.
SIGNIFICANCE = 1e-6
#: A change explains residuals if it reduces their root mean square to this fraction or less.
LEFT = 0.1
#: A change that reduces it to this fraction or less explains residuals exactly, but for rounding.
SAME = 1e-3
#: The most parameters of a fit whose residuals do not exceed noise, if `Search.most` is given. With
#: more of them, equations that are not a motion's own can match it if it is smooth and turns by
#: some radians only.
MOST_OF_ALL = 10
#: A change is fitted if, linearised, it reduces the root mean square of the residuals to the
#: fraction `PROMISING` or less. A pair of changes is fitted if it so reduces the residuals that the
#: better one of its changes leaves. Of the pairs with equal numbers of parameters only the best
#: `PAIRS` are fitted.
PROMISING, PAIRS = 0.5, 3


@dataclass(frozen=True, eq=False)
class Search:
    """The search for the changes that data call for.

    Attributes
    ----------
    changes : the changes that are tried
    most : the most parameters of a fit whose residuals exceed noise and a method's error, because a
        fit with many parameters explains a part of anything; no limit if None
    part : the fraction to which a change must reduce the root mean square of the residuals to
        explain them; a change that leaves no more than noise explains them in any case
    """

    data: Data
    changes: Sequence[Change]
    most: int | None = None
    part: float = LEFT

    @cached_property
    def unchanged(self) -> Fit:
        """The fit without any change."""
        return Trial(self.data, ()).fit()

    @property
    def is_called_for(self) -> bool:
        """Whether the residuals without any change exceed noise and a method's error."""
        residuals = self.unchanged.residuals
        return self.data.chi2_decrease(residuals, 0 * residuals) > self._critical(1)

    def exceed_noise(self, residuals: FloatArray) -> bool:
        """Whether residuals, (m,), are larger than noise and a method's error make them."""
        degrees, level = residuals.size / self.data.correlated, SIGNIFICANCE / len(self.changes)
        chi2 = self.data.chi2_decrease(residuals, 0 * residuals)
        return chi2 > float(chdtri(degrees, level))

    def one_or_two(self) -> Fit | None:
        """The change, or pair of changes, that explains the data.

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
        """The single change that explains the data; None if none does."""
        return self._simplest(self.single)

    @cached_property
    def single(self) -> list[Fit]:
        """The fits of single changes that may explain the data; none if they need no change."""
        if not self.is_called_for:
            return []
        enough = PROMISING**2 * self.unchanged.mean_square
        pairs = zip(self.changes, self.linear, strict=True)
        promising = [change for change, one in pairs if one.mean_square <= enough]
        return [Trial(self.data, (change,)).fit() for change in promising]

    @cached_property
    def linear(self) -> list[Linear]:
        """Each change by itself, linearised."""
        return linear(self.data, self.data.base, self.changes)

    def _pairs(self) -> list[Fit]:
        """Fits of pairs of changes both of which are needed.

        Among pairs with equal numbers of parameters, only the best when linearised are fitted.
        """
        alone, best = np.array([one.mean_square for one in self.linear]), []
        for both, pairs in of_pairs(self.linear, self.unchanged.residuals):
            needed = np.flatnonzero(both <= PROMISING**2 * alone[pairs].min(axis=1))
            best += [pairs[k] for k in needed[np.argsort(both[needed], kind="stable")[:PAIRS]]]
        # Of equally good pairs the first is named.
        changes = [(self.changes[i], self.changes[j]) for i, j in sorted(map(tuple, best))]
        return [Trial(self.data, both).fit() for both in changes]

    def _simplest(self, fits: Sequence[Fit]) -> Fit | None:
        """The fit with the fewest parameters that explains the data, unless another is far better.

        A fit with more parameters is far better if it lowers χ² significantly; one with as many
        also if it leaves far smaller residuals.

        Returns
        -------
        None if no fit explains the data
        """
        count = self.unchanged.residuals.size
        enough = max(largest_of_noise(count), self.part**2 * self.unchanged.mean_square)
        best = self.unchanged
        # Of fits of the same rank the first is named.
        for fit in sorted(fits, key=lambda fit: fit.rank):
            explains = fit.mean_square <= enough and self.improvement(self.unchanged, fit) > 0
            explains = explains and fit.is_physical and self._has_few_parameters(fit)
            if explains and (self.improvement(best, fit) > 0 or self._is_closer(fit, best)):
                best = fit
        return None if best is self.unchanged else best

    def _is_closer(self, fit: Fit, best: Fit) -> bool:
        """Whether a fit has the same rank as `best`, and far smaller residuals.

        It is false if the residuals of `best` are as small as rounding.
        """
        is_more = best.mean_square > SAME**2 * self.unchanged.mean_square
        is_far_less = fit.mean_square < LEFT**2 * best.mean_square
        return fit.rank == best.rank and is_more and is_far_less

    def _has_few_parameters(self, fit: Fit) -> bool:
        """Whether a fit has at most as many parameters as fits with such residuals may have."""
        if self.most is None or fit.rank <= self.most:
            return True
        return fit.rank <= MOST_OF_ALL and not self.exceed_noise(fit.residuals)

    def improvement(self, before: Fit, after: Fit) -> float:
        """The decrease of χ² from a fit to one with more parameters, less the largest by chance."""
        decrease = self.data.chi2_decrease(before.residuals, after.residuals)
        return decrease - self._critical(after.rank - before.rank)

    def _critical(self, parameters: int) -> float:
        """The smallest decrease of χ² at which a number of further parameters are significant.

        The significance level is divided by the number of changes that are tried (Bonferroni).
        Less than one further parameter counts as one.
        """
        return float(chdtri(max(1, parameters), SIGNIFICANCE / len(self.changes)))


def largest_of_noise(count: int) -> float:
    """The largest mean square of a number of residuals of noise, at the significance level."""
    return float(chdtri(count, SIGNIFICANCE)) / count
