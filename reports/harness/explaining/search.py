"""Searches for the changes of a scene's equations, or of how states are read, that data call for.

Changes are compared by χ², the sum of squares of the residuals in units of their standard
deviation. A change is preferred to a simpler one if it lowers χ² by more than chance does with as
many more parameters, among as many changes: a likelihood-ratio test (S. S. Wilks, Ann. Math.
Statist. 9 (1938) 60) with Bonferroni's correction.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

import numpy as np
from scipy.special import chdtri

from ....scenarios import FloatArray
from .fit import Data, Fit, Linear, Trial, linear, of_pairs
from .hypothesis import Change

#: The significance level: the probability that noise alone makes a search find a change.
SIGNIFICANCE = 1e-6
#: A change explains residuals if it reduces their root mean square to this fraction or less.
LEFT = 0.1
#: A change that reduces them to this fraction or less explains them exactly, but for rounding.
SAME = 1e-3
#: The most parameters of a fit that leaves no more than noise, if `Search.most` is given. A smooth
#: motion of some radians can be matched with more of them by equations that are not its own.
MOST_OF_ALL = 10
#: A change is fitted if it reduces the residuals to this fraction where it is linearised; a pair of
#: changes, if it does that to the residuals of either change alone. Of the pairs with as many
#: parameters the best `PAIRS` are fitted.
PROMISING, PAIRS = 0.5, 3
#: How many changes of one kind are fitted in each step of a stepwise search: the best linearised.
LIKELIEST = 3


@dataclass(frozen=True, eq=False)
class Search:
    """The search for the changes that data call for.

    Attributes
    ----------
    most : the most parameters of a fit that leaves more than noise and a method's error, as many
        parameters explain a little of anything; no limit if None
    part : the fraction to which a change must reduce the residuals to explain them
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

    @cached_property
    def trials(self) -> list[Trial]:
        """Each change by itself, before it is fitted."""
        return [Trial(self.data, (change,)) for change in self.changes]

    def one_or_two(self) -> Fit | None:
        """The change, or pair of changes, that explains the data.

        Returns
        -------
        None if none does, or if none is called for
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
        """The fits of single changes that may explain the data; none if none is called for."""
        if not self.is_called_for:
            return []
        enough = PROMISING**2 * self.unchanged.mean_square
        pairs = zip(self.trials, self.linear, strict=True)
        return [trial.fit() for trial, one in pairs if one.mean_square <= enough]

    @cached_property
    def linear(self) -> list[Linear]:
        """Each change by itself, linearised."""
        return linear(self.trials)

    def stepwise(self, first: tuple[Change, ...], most: int) -> Fit:
        """The best set of changes by stepwise regression.

        In each step a change is added or left out, whichever improves the score most. Where neither
        does, one with parameters is replaced by one without, or two by one with one parameter.

        Parameters
        ----------
        first : the changes that the search starts from
        most : how many changes there may be
        """
        fit = Trial(self.data, first).fit()
        while True:
            best = max([fit, *self._fewer(fit), *self._one_more(fit, most)], key=self.score)
            if best is fit:
                best = max([fit, *self._plainer(fit)], key=self.score)
            if best is fit:
                return fit
            fit = best

    def _fewer(self, fit: Fit) -> Iterator[Fit]:
        """Fits with one of the changes left out."""
        for one in fit.changes:
            yield Trial(self.data, tuple(c for c in fit.changes if c is not one)).fit(fit)

    def _one_more(self, fit: Fit, most: int) -> Iterator[Fit]:
        """Fits with one more change, if there may be one.

        The likeliest are fitted, or all where the fit so far explains nothing.
        """
        if len(fit.changes) < most:
            others = (one for one in self.changes if one not in fit.changes)
            trials = [Trial(self.data, (*fit.changes, one)) for one in others]
            likely = trials if fit.explains_nothing else self._likeliest(fit, trials)
            yield from (self._more(fit, trial) for trial in likely)

    def _plainer(self, fit: Fit) -> Iterator[Fit]:
        """Fits with one change that has no parameters for another, or with one for two changes."""
        trials = []
        for count, replaced in [(0, (one,)) for one in fit.changes if len(one.scales)] + [
            (1, pair) for pair in combinations(fit.changes, 2)
        ]:
            kept = tuple(one for one in fit.changes if one not in replaced)
            others = (c for c in self.changes if c not in fit.changes and len(c.scales) == count)
            trials += [Trial(self.data, (other, *kept)) for other in others]
        yield from (trial.fit(fit) for trial in self._likeliest(fit, trials))

    def _likeliest(self, fit: Fit, trials: Sequence[Trial]) -> list[Trial]:
        """The trials, which share changes with a fit, that lower its χ² most to first order."""

        def score(trial: Trial) -> float:
            penalty = sum(self._critical(len(change.scales)) for change in trial.changes)
            return trial.chi2_decrease_if_linear(fit) - penalty

        return sorted(trials, key=score, reverse=True)[:LIKELIEST]

    def _more(self, fit: Fit, trial: Trial) -> Fit:
        """Fit a trial that has one more change than `fit`, starting from the parameters of `fit`.

        If the residuals of `fit` exceed noise, those parameters may lead to a local minimum: the
        trial is fitted from zero, too, and the fit with the higher score is returned.
        """
        one = trial.fit(fit)
        if fit.explains_nothing or fit.mean_square <= largest_of_noise(fit.residuals.size):
            return one
        return max(one, trial.fit(), key=self.score)

    def score(self, fit: Fit) -> float:
        """How much its changes lower χ², less what chance makes each of them lower it."""
        penalty = sum(self._critical(len(change.scales)) for change in fit.changes)
        penalty += float(np.sum(self.data.prior_residuals(fit.hypothesis) ** 2))
        return self.data.chi2_decrease(self.unchanged.residuals, fit.residuals) - penalty

    def _pairs(self) -> list[Fit]:
        """Fits of pairs of changes both of which are needed.

        Of the pairs with as many parameters the best linearised ones are fitted.
        """
        alone, best = np.array([one.mean_square for one in self.linear]), []
        for both, pairs in of_pairs(self.linear, self.unchanged.residuals):
            needed = np.flatnonzero(both <= PROMISING**2 * alone[pairs].min(axis=1))
            best += [pairs[k] for k in needed[np.argsort(both[needed], kind="stable")[:PAIRS]]]
        # Of those alike the first is named.
        changes = [(self.changes[i], self.changes[j]) for i, j in sorted(map(tuple, best))]
        return [Trial(self.data, both).fit() for both in changes]

    def _simplest(self, fits: Sequence[Fit]) -> Fit | None:
        """The fit with the fewest parameters that explains the data, unless more explain far more.

        Returns
        -------
        None if no fit explains the data
        """
        count = self.unchanged.residuals.size
        enough = max(largest_of_noise(count), self.part**2 * self.unchanged.mean_square)
        best = self.unchanged
        # Of those alike the first is named.
        for fit in sorted(fits, key=lambda fit: fit.rank):
            explains = fit.mean_square <= enough and self.improvement(self.unchanged, fit) > 0
            explains = explains and fit.is_physical and self._has_few_parameters(fit)
            if explains and (self.improvement(best, fit) > 0 or self._is_closer(fit, best)):
                best = fit
        return None if best is self.unchanged else best

    def _is_closer(self, fit: Fit, best: Fit) -> bool:
        """Whether a fit of as few parameters leaves far less than the best, which leaves some."""
        is_more = best.mean_square > SAME**2 * self.unchanged.mean_square
        is_far_less = fit.mean_square < LEFT**2 * best.mean_square
        return fit.rank == best.rank and is_more and is_far_less

    def _has_few_parameters(self, fit: Fit) -> bool:
        """Whether a fit has no more parameters than it may have, given what it leaves."""
        if self.most is None or fit.rank <= self.most:
            return True
        return fit.rank <= MOST_OF_ALL and not self.exceed_noise(fit.residuals)

    def improvement(self, before: Fit, after: Fit) -> float:
        """How much further parameters lower χ², less what chance makes them lower it."""
        decrease = self.data.chi2_decrease(before.residuals, after.residuals)
        return decrease - self._critical(after.rank - before.rank)

    def _critical(self, parameters: int) -> float:
        """The decrease of χ² by so many parameters that is significant among all changes."""
        return float(chdtri(max(1, parameters), SIGNIFICANCE / len(self.changes)))


def largest_of_noise(count: int) -> float:
    """The largest mean square that noise makes of so many residuals, at the significance level."""
    return float(chdtri(count, SIGNIFICANCE)) / count
