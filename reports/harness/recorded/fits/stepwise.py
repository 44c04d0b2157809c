"""Finds the set of changes that a measured motion calls for, by stepwise regression.

A change (`Change`) is one of the equations of motion, or of how states are read. Noise hides what
each change explains by itself. So changes are added, removed and replaced until no such step
improves the fit.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from .....scenarios import FloatArray
from ...explaining.fit import RANK, Data, Fit, Trial, linear, mean_square
from ...explaining.hypothesis import Change
from ...explaining.search import PROMISING, Search

#: The number of additions or replacements that are fitted in each step of a regression: those that
#: are best when linearised.
LIKELIEST = 3


@dataclass(frozen=True, eq=False)
class Stepwise(Search):
    """A search for changes of equations, or of how states are read, by stepwise regression.

    Attributes
    ----------
    usual : the changes that data of this kind most often require. They count as simpler than others
        with as many parameters
    """

    usual: Sequence[Change] = ()

    def from_first_samples(self, most: int, kept: tuple[Change, ...] = ()) -> Fit:
        """Return the fit of the best set of changes, by regression on more and more of the data.

        The regression begins with the first samples, where the motion is nearly linear in the
        parameters, and goes on from the changes and parameters that explain them. It is given up if
        residuals become so large that the parameters mean nothing.

        Parameters
        ----------
        most : the largest number of changes
        kept : changes to begin with. They may be removed only when all data are fitted
        """
        fit = Trial(self.data.beginnings[0], kept).fit()
        for data in self.data.beginnings:
            search, of_all = replace(self, data=data), data is self.data
            fit = search.stepwise(Trial(data, fit.changes).fit(fit), most, () if of_all else kept)
            if fit.explains_nothing:
                return Trial(self.data, fit.changes).fit(fit)
        return fit

    def stepwise(self, fit: Fit, most: int, kept: tuple[Change, ...] = ()) -> Fit:
        """Return the fit of the best set of changes, by regression that starts from another fit.

        In each step a change is added, removed or replaced, whichever improves the score most.

        Parameters
        ----------
        fit : the fit from whose changes and parameters the regression starts
        most : the largest number of changes
        kept : changes that are not removed
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
        """Yield fits of one further change together with all or some of the changes of a fit.

        At most `LIKELIEST` are yielded: those that improve the score most when linearised.

        Parameters
        ----------
        subsets : sets of changes to which one is added: all changes of the fit, then subsets of
            them
        most : the largest number of changes
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
        """Return a fit, or a simpler one that the Bayesian information criterion prefers.

        In a simpler fit one change replaces another one, or two others. The criterion is that of G.
        Schwarz, Ann. Statist. 6 (1978) 461.

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
        """Return fits of the changes `kept` and one other, that are simpler than a given fit.

        The parts of the data in `Data.beginnings` are taken in turn, until the given fit explains
        a part significantly better than the changes `kept` do alone. The other changes that are
        promising there, by `_promising`, are fitted to this part and to all later ones. A fit is
        dropped as soon as the given fit explains a part significantly better. Often none is left.
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
        """Yield fits of the changes of `alone` together with each promising one of `others`.

        The mean square of the residuals of `alone` exceeds that of `fit`. A change is promising if,
        linearised, it reduces this excess to the fraction `PROMISING`² or less. Its fit starts from
        the parameters of `alone` or of `fit`, whichever leave smaller residuals.
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
        """Return the number of parameters of changes, plus one for each change not in `usual`."""
        return sum(len(one.scales) + (one not in self.usual) for one in changes)

    def _information(self, fit: Fit) -> float:
        """Return the Bayesian information criterion of a fit, less a constant; least is best."""
        count = fit.residuals.size / self.data.correlated
        decrease = self.data.chi2_decrease(self.unchanged.residuals, fit.residuals)
        return self._complexity(fit.changes) * float(np.log(count)) - decrease

    def score(self, fit: Fit) -> float:
        """Return how much better a fit is than one without changes; the largest score is best.

        It is the decrease of χ², less the largest decrease by chance, less χ² of the prior.
        """
        decrease = self.data.chi2_decrease(self.unchanged.residuals, fit.residuals)
        of_prior = float(np.sum(self.data.prior_residuals(fit.hypothesis[None]) ** 2))
        return decrease - self._penalty(fit.changes) - of_prior

    def _penalty(self, changes: Sequence[Change]) -> float:
        """Return the sum of the largest decreases of χ² that changes make by chance alone."""
        return sum(self._critical(len(change.scales)) for change in changes)


def residuals_if_linear(
    data: Data, before: Fit, kept: tuple[Change, ...], others: Sequence[Change]
) -> FloatArray:
    """Return the residuals with the changes `kept` and each of M others, to first order, (M, m).

    They are in units of their standard deviation. No fit is made, as in the score test (C. R. Rao,
    Math. Proc. Camb. Philos. Soc. 44 (1948) 50). The derivatives by the parameters of `kept` are
    those of an earlier fit.

    Parameters
    ----------
    data : the data to be explained, with m residuals
    before : the earlier fit
    kept : some or all changes of the earlier fit
    others : the M changes, of which one at a time is added to `kept`
    """
    each = linear(data, Trial(data, kept).at(before), others)
    columns = [before.jacobian[:, before.columns(one)] for one in kept]
    jacobian = np.hstack([np.empty((len(before.residuals), 0)), *columns])
    basis, sizes, _ = np.linalg.svd(jacobian, full_matrices=False)
    basis = basis[:, sizes > RANK * sizes.max(initial=0.0)]
    left = np.array([one.residuals for one in each]).reshape(len(each), len(before.residuals))
    left -= left @ basis @ basis.T
    counts = np.array([one.jacobian.shape[1] for one in each])
    # Changes with equally many parameters are computed together, which saves calls of numpy.
    for count in np.unique(counts[counts > 0]):
        at = np.flatnonzero(counts == count)
        jacobians = np.stack([each[k].jacobian for k in at])
        beside = jacobians - basis @ (basis.T @ jacobians)
        # A parameter that the changes `kept` can replace is left out.
        own = np.linalg.norm(beside, axis=1) > RANK * np.linalg.norm(jacobians, axis=1)
        directions, sizes, _ = np.linalg.svd(beside * own[:, None], full_matrices=False)
        directions *= (sizes > RANK * sizes[:, :1])[:, None]
        left[at] -= (directions @ (np.swapaxes(directions, 1, 2) @ left[at, :, None]))[..., 0]
    return left


def _without(changes: tuple[Change, ...], count: int) -> list[tuple[Change, ...]]:
    """Return all subsets of changes that lack `count` of them; none if there are fewer changes."""
    return [*combinations(changes, len(changes) - count)] if len(changes) >= count else []
