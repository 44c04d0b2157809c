"""Stepwise regression: the set of changes that the samples of a measured motion call for.

Noise hides what each change explains by itself, so that changes are added, left out and exchanged
until no such step improves the fit.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from .....scenarios import FloatArray
from ...explaining.fit import RANK, Data, Fit, Trial, linear, mean_square
from ...explaining.hypothesis import Change
from ...explaining.search import PROMISING, Search

#: How many trials are fitted in each step of a regression: the best if linearised.
LIKELIEST = 3


@dataclass(frozen=True, eq=False)
class Stepwise(Search):
    """A search by stepwise regression.

    Attributes
    ----------
    usual : the changes that such data often call for, and that therefore count as simpler
    """

    usual: Sequence[Change] = ()

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
            search, of_all = replace(self, data=data), data is self.data
            fit = search.stepwise(Trial(data, fit.changes).fit(fit), most, () if of_all else kept)
            if fit.explains_nothing:
                return Trial(self.data, fit.changes).fit(fit)
        return fit

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
            decreases = self.data.chi2_decreases(self.unchanged.residuals, residuals)
            for other, decrease in zip(others, decreases.tolist(), strict=True):
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
        """Fits of the changes `kept` and one other change, simpler than a given fit; often none.

        The data in `Data.beginnings` are taken in turn, until the given fit explains them
        significantly better than the changes `kept` do alone. The changes that are promising in
        these data, as `_promising` says, are fitted to them and to all later ones. A fit is dropped
        as soon as the given fit explains the data significantly better.
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
        `alone` or of `fit`, whichever gives the larger reduction.
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
        of_prior = float(np.sum(self.data.prior_residuals(fit.hypothesis[None]) ** 2))
        return decrease - self._penalty(fit.changes) - of_prior

    def _penalty(self, changes: Sequence[Change]) -> float:
        """The largest decrease of χ² that these changes make by chance alone, added up."""
        return sum(self._critical(len(change.scales)) for change in changes)


def residuals_if_linear(
    data: Data, before: Fit, kept: tuple[Change, ...], others: Sequence[Change]
) -> FloatArray:
    """The residuals after a fit of `kept` and each of M other changes, to first order, (M, m).

    They are in units of their standard deviation. No fit is made, as in the score test (C. R. Rao,
    Math. Proc. Camb. Philos. Soc. 44 (1948) 50): the changes that are kept keep the derivatives of
    the earlier fit.

    Parameters
    ----------
    before : the earlier fit
    kept : the changes of that fit to which each of the others is added
    """
    each = linear(data, Trial(data, kept).at(before), others)
    columns = [before.jacobian[:, before.columns(one)] for one in kept]
    jacobian = np.hstack([np.empty((len(before.residuals), 0)), *columns])
    basis, sizes, _ = np.linalg.svd(jacobian, full_matrices=False)
    basis = basis[:, sizes > RANK * sizes.max(initial=0.0)]
    left = np.array([one.residuals for one in each]).reshape(len(each), len(before.residuals))
    left -= left @ basis @ basis.T
    counts = np.array([one.jacobian.shape[1] for one in each])
    # The changes with equally many parameters together, as each takes less time than a call.
    for count in np.unique(counts[counts > 0]):
        at = np.flatnonzero(counts == count)
        jacobians = np.stack([each[k].jacobian for k in at])
        beside = jacobians - basis @ (basis.T @ jacobians)
        # What the kept changes explain as well has no direction of its own.
        own = np.linalg.norm(beside, axis=1) > RANK * np.linalg.norm(jacobians, axis=1)
        directions, sizes, _ = np.linalg.svd(beside * own[:, None], full_matrices=False)
        directions *= (sizes > RANK * sizes[:, :1])[:, None]
        left[at] -= (directions @ (np.swapaxes(directions, 1, 2) @ left[at, :, None]))[..., 0]
    return left


def _without(changes: tuple[Change, ...], count: int) -> list[tuple[Change, ...]]:
    """All subsets of changes in which `count` of them are left out; none if there are fewer."""
    return [*combinations(changes, len(changes) - count)] if len(changes) >= count else []
