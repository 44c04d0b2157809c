"""The changes of a scene's equations, or of how states are read, that data call for.

What a hypothesis leaves of the data, in units of what noise and a method's error make of it, is
squared and summed. A change is preferred to a simpler one if the sum falls by more than chance
makes it fall with so many more numbers, among so many changes (S. S. Wilks, Ann. Math. Statist. 9
(1938) 60).
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

#: The probability that a change is named where noise alone made the data other ones.
LEVEL = 1e-6
#: A change explains what noise and a method's error do not if no more than this fraction is left.
LEFT = 0.1
#: Changes that leave no more than this fraction are the same, but for rounding.
SAME = 1e-3
#: How many numbers are fitted, at most, if `Search.most` bounds them: with more a smooth motion of
#: some radians is matched by equations that are not its own.
MOST_OF_ALL = 10
#: Changes are fitted that leave no more than this fraction where they are taken as linear; pairs of
#: changes, no more than this fraction of what either alone leaves, and so many of them at most with
#: as many numbers.
PROMISING, PAIRS = 0.5, 3
#: How many changes are fitted of those that explain most of what a fit leaves, if it is linear.
LIKELIEST = 3


@dataclass(frozen=True, eq=False)
class Search:
    """The search for the changes that data call for.

    Attributes
    ----------
    most : how many numbers are fitted, at most, where more is left than noise and a method's error:
        many numbers make little of anything; any number if None
    part : which part of what the scene's own equations leave a change that explains it may leave
    """

    data: Data
    changes: Sequence[Change]
    most: int | None = None
    part: float = LEFT

    @cached_property
    def unchanged(self) -> Fit:
        """What the scene's own equations leave."""
        return Trial(self.data, ()).fit()

    @property
    def is_called_for(self) -> bool:
        """Whether the scene's own equations leave more than noise and a method's error."""
        rest = self.unchanged.rest
        return self.data.falls(rest, 0 * rest) > self._by_chance(1)

    def is_beyond(self, rest: FloatArray) -> bool:
        """Whether what is left, (m,), is more than noise and a method's error."""
        numbers, level = rest.size / self.data.at_once, LEVEL / len(self.changes)
        return self.data.falls(rest, 0 * rest) > float(chdtri(numbers, level))

    @cached_property
    def trials(self) -> list[Trial]:
        """Each change by itself, its numbers to be fitted."""
        return [Trial(self.data, (change,)) for change in self.changes]

    def one_or_two(self) -> Fit | None:
        """The change, or pair of changes, that explains the data; None if none does, or need be."""
        if not self.is_called_for:
            return None
        best = self.one()
        if best is not None and best.left <= 1:
            return best
        return self._simplest([*self.single, *self._pairs()])

    def one(self) -> Fit | None:
        """The change that explains the data by itself; None if none does."""
        return self._simplest(self.single)

    @cached_property
    def single(self) -> list[Fit]:
        """The fits of each change by itself that may explain the data; none if none need be."""
        if not self.is_called_for:
            return []
        enough = PROMISING**2 * self.unchanged.left
        pairs = zip(self.trials, self.linear, strict=True)
        return [trial.fit() for trial, one in pairs if one.least <= enough]

    @cached_property
    def linear(self) -> list[Linear]:
        """What each change leaves where it is taken as linear in its numbers."""
        return linear(self.trials)

    def stepwise(self, first: tuple[Change, ...], most: int) -> Fit:
        """The changes, so many of them at most, that explain more than chance does.

        From the first ones on one is added, or left out, as long as that gains anything; then one
        with numbers is replaced by one without, or two by one with one number, if that gains
        anything.
        """
        fit = Trial(self.data, first).fit()
        while True:
            best = max([fit, *self._fewer(fit), *self._one_more(fit, most)], key=self.gain)
            if best is fit:
                best = max([fit, *self._plainer(fit)], key=self.gain)
            if best is fit:
                return fit
            fit = best

    def _fewer(self, fit: Fit) -> Iterator[Fit]:
        """Fits with one of the changes left out."""
        for one in fit.changes:
            yield Trial(self.data, tuple(c for c in fit.changes if c is not one)).fit(fit)

    def _one_more(self, fit: Fit, most: int) -> Iterator[Fit]:
        """Fits with one change more, if there may be one; all if the fit explains nothing."""
        if len(fit.changes) < most:
            others = (one for one in self.changes if one not in fit.changes)
            trials = [Trial(self.data, (*fit.changes, one)) for one in others]
            likely = trials if fit.is_hopeless else self._likeliest(fit, trials)
            yield from (self._more(fit, trial) for trial in likely)

    def _plainer(self, fit: Fit) -> Iterator[Fit]:
        """Fits with fewer numbers: a change replaced by one without, or two by one with one."""
        trials = []
        for count, replaced in [(0, (one,)) for one in fit.changes if len(one.sizes)] + [
            (1, pair) for pair in combinations(fit.changes, 2)
        ]:
            kept = tuple(one for one in fit.changes if one not in replaced)
            others = (c for c in self.changes if c not in fit.changes and len(c.sizes) == count)
            trials += [Trial(self.data, (other, *kept)) for other in others]
        yield from (trial.fit(fit) for trial in self._likeliest(fit, trials))

    def _likeliest(self, fit: Fit, trials: Sequence[Trial]) -> list[Trial]:
        """The trials that may gain most on a fit of which they have some changes."""

        def gain(trial: Trial) -> float:
            chance = sum(self._by_chance(len(change.sizes)) for change in trial.changes)
            return trial.falls_if_linear(fit) - chance

        return sorted(trials, key=gain, reverse=True)[:LIKELIEST]

    def _more(self, fit: Fit, trial: Trial) -> Fit:
        """A fit with one more change; begun anew, too, where the one before leaves more than noise.

        From numbers that are wrong a search may end at others that noise hides.
        """
        one = trial.fit(fit)
        if fit.is_hopeless or fit.left <= within_noise(fit.rest.size):
            return one
        return max(one, trial.fit(), key=self.gain)

    def gain(self, fit: Fit) -> float:
        """How much more its changes explain than chance makes each of them explain."""
        chance = sum(self._by_chance(len(change.sizes)) for change in fit.changes)
        chance += float(np.sum(self.data.unlikely(fit.hypothesis) ** 2))
        return self.data.falls(self.unchanged.rest, fit.rest) - chance

    def _pairs(self) -> list[Fit]:
        """Two changes at once, of which both are needed.

        Of those with as many numbers those are fitted that leave least where they are linear.
        """
        alone, best = np.array([one.least for one in self.linear]), []
        for both, pairs in of_pairs(self.linear, self.unchanged.rest):
            needed = np.flatnonzero(both <= PROMISING**2 * alone[pairs].min(axis=1))
            best += [pairs[k] for k in needed[np.argsort(both[needed], kind="stable")[:PAIRS]]]
        # Of those alike the first is named.
        changes = [(self.changes[i], self.changes[j]) for i, j in sorted(map(tuple, best))]
        return [Trial(self.data, both).fit() for both in changes]

    def _simplest(self, fits: Sequence[Fit]) -> Fit | None:
        """The simplest fit that leaves little, if none with more numbers leaves much less."""
        count = self.unchanged.rest.size
        enough = max(within_noise(count), self.part**2 * self.unchanged.left)
        best = self.unchanged
        # Of those alike the first is named.
        for fit in sorted(fits, key=lambda fit: fit.count):
            explains = fit.left <= enough and self.beyond(self.unchanged, fit) > 0
            explains = explains and fit.is_possible and self._is_plain(fit)
            if explains and (self.beyond(best, fit) > 0 or self._is_closer(fit, best)):
                best = fit
        return None if best is self.unchanged else best

    def _is_closer(self, fit: Fit, best: Fit) -> bool:
        """Whether a fit of as few numbers leaves far less, of what is more than rounding."""
        is_more = best.left > SAME**2 * self.unchanged.left
        return fit.count == best.count and is_more and fit.left < LEFT**2 * best.left

    def _is_plain(self, fit: Fit) -> bool:
        """Whether a fit has few numbers; or leaves no more than noise, and has not too many."""
        if self.most is None or fit.count <= self.most:
            return True
        return fit.count <= MOST_OF_ALL and not self.is_beyond(fit.rest)

    def beyond(self, before: Fit, after: Fit) -> float:
        """How much less a fit leaves than chance makes its further numbers leave."""
        return self.data.falls(before.rest, after.rest) - self._by_chance(
            after.count - before.count
        )

    def _by_chance(self, numbers: int) -> float:
        return float(chdtri(max(1, numbers), LEVEL / len(self.changes)))


def within_noise(count: int) -> float:
    """The mean square of so many numbers that noise makes seldom larger."""
    return float(chdtri(count, LEVEL)) / count
