"""Searches for the changes of a scene's equations, or of how states are read, that data call for.

Changes are compared by χ², the sum of squares of the residuals in units of their standard
deviation. A change is preferred to a simpler one if it lowers χ² by more than chance does with as
many more parameters, among as many changes: a likelihood-ratio test (S. S. Wilks, Ann. Math.
Statist. 9 (1938) 60) with Bonferroni's correction.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations

import numpy as np
from scipy.special import chdtri

from ....scenarios import FloatArray
from .fit import Data, Fit, Linear, Trial, linear, mean_square, of_pairs, residuals_if_linear
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
#: A change is fitted if, linearised, it reduces the root mean square of the residuals to this
#: fraction or less; a pair of changes, if it so reduces that of either change alone. Of the pairs
#: with equal numbers of parameters the best `PAIRS` are fitted.
PROMISING, PAIRS = 0.5, 3
#: How many trials are fitted in each step of a stepwise regression: the best if linearised.
LIKELIEST = 3


@dataclass(frozen=True, eq=False)
class Search:
    """The search for the changes that data call for.

    Attributes
    ----------
    changes : the changes that are tried
    most : the most parameters of a fit whose residuals exceed noise and a method's error, as many
        parameters explain a little of anything; no limit if None
    part : the fraction to which a change must reduce the residuals to explain them
    usual : the changes that such data often call for, and that therefore count as simpler
    """

    data: Data
    changes: Sequence[Change]
    most: int | None = None
    part: float = LEFT
    usual: Sequence[Change] = ()

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

    def from_first_samples(self, most: int, kept: tuple[Change, ...] = ()) -> Fit:
        """The best set of changes by stepwise regression on more and more of the data.

        The regression begins with the first samples, where the motion is nearly linear in the
        parameters, and goes on from the changes and parameters that explain them. It ends where
        residuals are so large that no parameters mean anything.

        Parameters
        ----------
        most : how many changes there may be
        kept : changes to begin with, which may be left out only once all data are used
        """
        fit = Trial(self.data.beginnings[0], kept).fit()
        for data in self.data.beginnings:
            search = replace(self, data=data)
            fit = search.stepwise(Trial(data, fit.changes).fit(fit), most, kept)
            if fit.explains_nothing:
                return Trial(self.data, fit.changes).fit(fit)
        return self.stepwise(fit, most) if kept else fit

    def stepwise(self, fit: Fit, most: int, kept: tuple[Change, ...] = ()) -> Fit:
        """The best set of changes by stepwise regression, which begins with the changes of a fit.

        In each step a change is added, left out, or takes the place of another, whichever improves
        the score most.

        Parameters
        ----------
        most, kept : as in `from_first_samples`
        """
        while True:
            one_less = [one for one in _without(fit.changes, 1) if set(kept) <= set(one)]
            fewer = [Trial(self.data, one).fit(fit) for one in one_less]
            others = self._others(fit, [fit.changes, *one_less], most)
            best = max([fit, *fewer, *others], key=self.score)
            if best is fit:
                return fit
            fit = best

    def _others(self, fit: Fit, subsets: Sequence[tuple[Change, ...]], most: int) -> Iterator[Fit]:
        """Fits of one more change together with some or all of the changes of a fit.

        Only the `LIKELIEST` that, linearised, improve the score most are fitted.

        Parameters
        ----------
        subsets : all changes of the fit, then the subsets of them to which a change is added
        most : how many changes there may be
        """
        trials: list[tuple[float, Trial]] = []
        others = [one for one in self.changes if one not in fit.changes]
        for some in subsets if len(fit.changes) < most else subsets[1:]:
            residuals = residuals_if_linear(self.data, fit, some, others)
            for other, left in zip(others, residuals, strict=True):
                decrease = self.data.chi2_decrease(self.unchanged.residuals, left)
                changes = (*some, other)
                trials.append((decrease - self._penalty(changes), Trial(self.data, changes)))
        trials.sort(key=lambda one: -one[0])
        yield from (one.fit(fit) for score, one in trials[:LIKELIEST] if score > self.score(fit))

    def simplified(self, fit: Fit, but: Change) -> Fit:
        """The fit, or a simpler one that the Bayesian information criterion prefers.

        In a simpler fit one change takes the place of another, or of two (G. Schwarz, Ann. Statist.
        6 (1978) 461).

        Parameters
        ----------
        but : a change that is not replaced
        """
        subsets = [*_without(fit.changes, 1), *_without(fit.changes, 2)]
        subsets = [one for one in subsets if but in one or but not in fit.changes]
        simpler = [one for kept in subsets for one in self._simpler(fit, kept) if one.is_physical]
        best = min([fit, *simpler], key=self._information)
        return fit if best is fit else self.simplified(best, but)

    def _simpler(self, fit: Fit, kept: tuple[Change, ...]) -> list[Fit]:
        """Fits, simpler than a given one, of the changes that are kept and one other change.

        The other change is chosen by the first of the data in `Data.beginnings` that the kept
        changes explain less well than the given fit: it must be promising there. In these data and
        all later ones χ² must not be significantly larger than that of the given fit.
        """
        room = self._complexity(fit.changes) - self._complexity(kept)
        others = [one for one in self.changes if one not in fit.changes]
        others = [one for one in others if self._complexity([one]) < room]
        alone, fits = None, None
        for data in self.data.beginnings if others else ():
            search, of_fit = replace(self, data=data), Trial(data, fit.changes).fit(fit)
            if fits is None:
                alone = Trial(data, kept).fit(alone)
                if search.improvement(alone, of_fit) <= 0:
                    continue
                fits = [*search._promising(alone, of_fit, others)]
            else:
                fits = [Trial(data, one.changes).fit(one) for one in fits]
            fits = [one for one in fits if search.improvement(one, of_fit) <= 0]
        return fits or []

    def _promising(self, alone: Fit, fit: Fit, others: Sequence[Change]) -> Iterator[Fit]:
        """Fits of the changes of `alone` together with each promising one of some other changes.

        A change is promising if, linearised, it reduces the excess of the mean square of `alone`
        over that of `fit` to the fraction `PROMISING`² or less. The parameters start from those of
        `alone` or of `fit`, from which that reduction is larger.
        """
        enough = fit.mean_square + PROMISING**2 * (alone.mean_square - fit.mean_square)
        starts = alone, fit
        each = [residuals_if_linear(self.data, one, alone.changes, others) for one in starts]
        for other, *left in zip(others, *each, strict=True):
            squares = [mean_square(one) for one in left]
            if min(squares) <= enough:
                start = starts[int(np.argmin(squares))]
                yield Trial(self.data, (*alone.changes, other)).fit(start)

    def _complexity(self, changes: Sequence[Change]) -> int:
        """The number of parameters of changes, plus one for each change that is not in `usual`."""
        return sum(len(one.scales) + (one not in self.usual) for one in changes)

    def _information(self, fit: Fit) -> float:
        """The Bayesian information criterion of a fit, up to a constant; the least is best."""
        count = fit.residuals.size / self.data.correlated
        decrease = self.data.chi2_decrease(self.unchanged.residuals, fit.residuals)
        return self._complexity(fit.changes) * float(np.log(count)) - decrease

    def score(self, fit: Fit) -> float:
        """The decrease of χ² by the changes of a fit, less that by chance, less the prior's χ²."""
        decrease = self.data.chi2_decrease(self.unchanged.residuals, fit.residuals)
        of_prior = float(np.sum(self.data.prior_residuals(fit.hypothesis) ** 2))
        return decrease - self._penalty(fit.changes) - of_prior

    def _penalty(self, changes: Sequence[Change]) -> float:
        """The largest decrease of χ² that these changes make by chance alone, added up."""
        return sum(self._critical(len(change.scales)) for change in changes)

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
        """Whether a fit of the same rank has far smaller residuals than the best fit so far.

        It is false if the residuals of the best fit are as small as rounding.
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
        """The decrease of χ² by the further parameters of a second fit, less that by chance."""
        decrease = self.data.chi2_decrease(before.residuals, after.residuals)
        return decrease - self._critical(after.rank - before.rank)

    def _critical(self, parameters: int) -> float:
        """The decrease of χ² from which on a number of further parameters are significant.

        As many changes are tried as `changes` has (Bonferroni).
        """
        return float(chdtri(max(1, parameters), SIGNIFICANCE / len(self.changes)))


def largest_of_noise(count: int) -> float:
    """The largest mean square of a number of residuals of noise, at the significance level."""
    return float(chdtri(count, SIGNIFICANCE)) / count


def _without(changes: tuple[Change, ...], count: int) -> list[tuple[Change, ...]]:
    """All subsets of changes in which `count` of them are left out; none if there are fewer."""
    return [*combinations(changes, len(changes) - count)] if len(changes) >= count else []
