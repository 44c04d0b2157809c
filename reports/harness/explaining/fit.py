"""Fits the numbers of changes to data, by least squares.

What a hypothesis leaves of the data is in units of what noise and a method's error make of it.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from ....scenarios import FloatArray
from ...results.evidence import Explanation
from .changes import FITTED_TENSORS, GYROSCOPIC_TENSOR
from .hypothesis import Change, Hypothesis
from .other_tensors import is_of_a_body

#: What is left where numbers are nan: no motion is that far off.
NOWHERE = 1e30
#: Numbers that are seen less than this, relative to those seen best, do not count.
RANK = 1e-6
EPS, TINY = float(np.finfo(float).eps), float(np.finfo(float).tiny)
#: Evaluations of a fit at most, and a step of a scaled number from which a slope is taken.
EVALUATIONS, SMALL = 20, 1e-5
#: Relative steps at which a fit ends, and one to a part of the data.
NEAR, ROUGHLY = 1e-9, 1e-3
#: How many trials of a race that are not near the best go on, at least, if they may; or a quarter.
FINALISTS = 8
#: Numbers that leave a larger mean square of a part of the data explain none of it, and are fitted
#: to no more: further on there are local minima alone.
HOPELESS = 100.0


@dataclass(frozen=True, eq=False)
class Data(ABC):
    """Data that a change of the equations, or of how states are read, is to explain.

    Attributes
    ----------
    base : the scene's equations, with states that are read as they are
    """

    base: Hypothesis

    @abstractmethod
    def off(self, hypotheses: Sequence[Hypothesis], samples: int | None = None) -> FloatArray:
        """What each of H hypotheses leaves, in units of its scale; nan where it leads nowhere.

        Parameters
        ----------
        samples : the first ones that count; all of them if None

        Returns
        -------
        (H, ...), of any shape beyond the first axis
        """

    def unlikely(self, hypothesis: Hypothesis) -> FloatArray:  # noqa: ARG002
        """How far a hypothesis is from what is known beforehand, in standard deviations, (p,)."""
        return np.empty(0)

    @property
    def at_once(self) -> float:
        """How many of the numbers left count as one."""
        return 1.0

    @property
    def parts(self) -> Sequence[int | None]:
        """How many of the first samples numbers are fitted to, one after the other."""
        return (None,)

    def falls(self, before: FloatArray, after: FloatArray) -> float:
        """The sum of squares of what is left before a change, less that of the rest after it.

        Numbers that are one count once.
        """
        return float(np.sum(before**2) - np.sum(after**2)) / self.at_once

    def left(self, hypotheses: Sequence[Hypothesis], samples: int | None = None) -> FloatArray:
        """What each of H hypotheses leaves, in units of its scale, (H, m)."""
        off = np.nan_to_num(self.off(hypotheses, samples), nan=NOWHERE)
        return np.clip(off, -NOWHERE, NOWHERE).reshape(len(hypotheses), -1)


@dataclass(frozen=True, eq=False)
class Fit:
    """Changes made together, with the numbers for them that explain data best.

    Attributes
    ----------
    numbers : of all changes, (k,)
    covariance : of the numbers, if noise alone is left, by what is known beforehand too, (k, k)
    rest : what is left, in units of its scale, (m,)
    count : of numbers that the data show
    slopes : the derivative of what is left by each number in units of its size, (m, k)
    """

    changes: tuple[Change, ...]
    hypothesis: Hypothesis
    numbers: FloatArray
    covariance: FloatArray
    rest: FloatArray
    count: int
    slopes: FloatArray

    @cached_property
    def left(self) -> float:
        """The mean square of what is left."""
        return mean_square(self.rest)

    @property
    def errors(self) -> FloatArray:
        """Standard errors of the numbers, (k,)."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def is_hopeless(self) -> bool:
        """Whether it leaves so much that its numbers explain nothing."""
        return self.left > HOPELESS

    @property
    def is_possible(self) -> bool:
        """Whether a motion may have been computed with such tensors.

        A mistake may make a tensor that no body has; one that is fitted, and that no body has, is
        numbers that fit.
        """
        equations, kinds = self.hypothesis.equations, {change.kind for change in self.changes}
        possible = [np.linalg.eigvalsh(equations.inertia)[0] > 0]
        possible += [is_of_a_body(equations.inertia)] * bool(kinds & FITTED_TENSORS)
        # Of G, which is known up to a multiple of 1, the one nearest I was fitted.
        possible += [is_of_a_body(equations.gyroscopic)] * (GYROSCOPIC_TENSOR in kinds)
        return all(possible)

    def rows(self, change: Change) -> slice:
        """Where the numbers of one change are among those of all."""
        at = sum(len(one.sizes) for one in self.changes[: self.changes.index(change)])
        return slice(at, at + len(change.sizes))

    def numbers_of(self, change: Change) -> FloatArray:
        """The fitted numbers of one change; zeros where it is not among the changes."""
        is_made = change in self.changes
        return self.numbers[self.rows(change)] if is_made else np.zeros(len(change.sizes))

    def explanation(self, change: Change) -> Explanation:
        """One change with its fitted numbers, as it is stored."""
        return change.explanation(self.numbers_of(change))


@dataclass(frozen=True, eq=False)
class Linear:
    """What changes leave, where it is taken as linear in their k numbers.

    Attributes
    ----------
    at_none : what is left with numbers of zero, (m,)
    slopes : its derivative by each number, (m, k)
    """

    at_none: FloatArray
    slopes: FloatArray

    @cached_property
    def least(self) -> float:
        """The mean square of what the best numbers leave."""
        if not self.slopes.shape[1]:
            return mean_square(self.at_none)
        best = np.linalg.lstsq(self.slopes, self.at_none, rcond=RANK)[0]
        return mean_square(self.at_none - self.slopes @ best)


@dataclass(frozen=True, eq=False)
class Trial:
    """Changes whose numbers are to be fitted."""

    data: Data
    changes: tuple[Change, ...]

    @cached_property
    def sizes(self) -> FloatArray:
        """The sizes of all numbers, (k,)."""
        return np.concatenate([np.empty(0), *(change.sizes for change in self.changes)])

    def hypothesis(self, x: FloatArray) -> Hypothesis:
        """All changes made, with numbers in units of their sizes, (k,)."""
        hypothesis, at = self.data.base, 0
        for change in self.changes:
            end = at + len(change.sizes)
            hypothesis = change.apply(hypothesis, self.sizes[at:end] * x[at:end])
            at = end
        return hypothesis

    @property
    def around_none(self) -> list[Hypothesis]:
        """The hypotheses with numbers of zero, and with each of them a small one, k + 1."""
        none = np.zeros((1, len(self.sizes)))
        steps = SMALL * np.eye(len(self.sizes))
        return [self.hypothesis(x) for x in np.vstack([none, steps])]

    def falls_if_linear(self, before: Fit) -> float:
        """How much the sum of squares falls from that of a fit with other changes, if it is linear.

        A test of whether other changes explain more that takes no fit (C. R. Rao, Math. Proc. Camb.
        Philos. Soc. 44 (1948) 50): what both have keeps its slopes.
        """
        x, steps = self._begun(before), SMALL * np.eye(len(self.sizes))
        added = [k for k, change in enumerate(self._each) if change not in before.changes]
        left = self.data.left([self.hypothesis(one) for one in (x, *(x + steps[added]))])
        kept = [before.slopes[:, before.rows(one)] for one in self.changes if one in before.changes]
        slopes = np.hstack([*kept, (left[1:] - left[0]).T / SMALL])
        best = np.linalg.lstsq(slopes, left[0], rcond=RANK)[0]
        return self.data.falls(before.rest, left[0] - slopes @ best)

    @property
    def _each(self) -> list[Change]:
        """The change that each number is of, (k,)."""
        return [change for change in self.changes for _ in change.sizes]

    def _begun(self, before: Fit) -> FloatArray:
        """The numbers of a fit of some of the changes, in units of their sizes, (k,)."""
        each = [before.numbers_of(one) / one.sizes for one in self.changes]
        return np.concatenate([np.empty(0), *each])

    def fit(self, before: Fit | None = None) -> Fit:
        """Fit the numbers by least squares.

        Parameters
        ----------
        before : a fit of some of the changes, from whose numbers the search begins; else, and where
            they explain nothing, it begins where they are zero, with a part of the data
        """
        x, parts, most = np.zeros(len(self.sizes)), self.data.parts[:-1], EVALUATIONS
        if before is not None and not before.is_hopeless:
            x, parts = self._begun(before), ()
        for samples in parts if len(x) else ():
            x, squares = self.nearest(x, samples)
            if squares > HOPELESS:
                most = 1
                break
        return self.fit_from(x, most)

    def nearest(self, x: FloatArray, samples: int | None) -> tuple[FloatArray, float]:
        """The numbers that explain some of the first samples best, and the mean square they leave.

        Parameters
        ----------
        x : where the search for them begins, in units of their sizes, (k,), like what is returned
        """
        if not len(x):
            return x, mean_square(self.data.left([self.hypothesis(x)], samples))
        found = self._searched(x, samples, ROUGHLY, EVALUATIONS)
        return found.x, mean_square(found.fun)

    def _searched(self, x: FloatArray, samples: int | None, near: float, most: int) -> Any:
        """The numbers that leave least; slopes are computed with what is left, in less time."""

        @lru_cache(1)
        def both(numbers: bytes) -> tuple[FloatArray, FloatArray]:
            """What is left, (m,), and how far from what is known, (p,); and the slopes of these."""
            x = np.frombuffer(numbers)
            steps = np.sqrt(EPS) * np.maximum(1.0, np.abs(x))
            hypotheses = [self.hypothesis(one) for one in np.vstack([x, x + np.diag(steps)])]
            unlikely = np.stack([self.data.unlikely(one) for one in hypotheses])
            off = np.hstack([self.data.left(hypotheses, samples), unlikely])
            return off[0], (off[1:] - off[0]).T / steps

        def left(x: FloatArray) -> FloatArray:
            return both(x.tobytes())[0]

        def slopes(x: FloatArray) -> FloatArray:
            return both(x.tobytes())[1]

        return least_squares(left, x, slopes, xtol=near, max_nfev=most)

    def fit_from(self, x: FloatArray, most: int = EVALUATIONS) -> Fit:
        """Fit the numbers to all data, from given ones in units of their sizes, (k,).

        Parameters
        ----------
        most : evaluations of the fit, at most
        """
        if not len(x):
            (rest,) = self.data.left([self.hypothesis(x)])
            none = np.empty((0, 0)), rest, 0, np.empty((len(rest), 0))
            return Fit(self.changes, self.hypothesis(x), x, *none)
        found = self._searched(x, None, NEAR, most)
        x = found.x
        J = np.asarray(found.jac)
        measured = len(J) - len(self.data.unlikely(self.data.base))
        seen = np.linalg.svd(J[:measured], compute_uv=False)
        count = int(np.count_nonzero(seen > RANK * seen[0]))
        _, known, directions = np.linalg.svd(J, full_matrices=False)
        # What is neither seen nor known beforehand has a large error, not none.
        one_error = directions / np.maximum(known, EPS * (known[0] or 1.0))[:, None]
        covariance = one_error.T @ one_error
        return Fit(
            self.changes,
            self.hypothesis(x),
            self.sizes * x,
            covariance * np.outer(self.sizes, self.sizes),
            found.fun[:measured],
            count,
            J[:measured],
        )


def linear(trials: Sequence[Trial]) -> list[Linear]:
    """What each trial, of the same data, leaves if it is linear in its numbers."""
    if not trials:
        return []
    around = [trial.around_none for trial in trials]
    left = trials[0].data.left([one for each in around for one in each])
    parts = np.split(left, np.cumsum([len(each) for each in around])[:-1])
    return [Linear(part[0], (part[1:] - part[0]).T / SMALL) for part in parts]


def race(trials: Sequence[Trial], margin: float, factor: float = 1.0) -> list[Fit]:
    """Fit those of many trials of the same data that keep up with the best of them.

    They are fitted to more and more of the data (successive halving: K. Jamieson & A. Talwalkar,
    AISTATS 2016), and left out as soon as they explain less of it; all, if none explains a part.

    Parameters
    ----------
    margin : how much more than the best a trial may leave, as a sum of squares
    factor : how many times as much the best quarter of all others may leave
    """
    if not trials:
        return []
    data, running = trials[0].data, [(trial, np.zeros(len(trial.sizes))) for trial in trials]
    for samples in data.parts[:-1]:
        tried = [(*trial.nearest(x, samples), trial) for trial, x in running]
        tried = sorted(tried, key=lambda one: one[1])
        count, least = data.left([data.base], samples).size, tried[0][1]
        if least > HOPELESS:
            return []
        near = [one for one in tried if one[1] <= least + margin / count]
        far = [one for one in tried[len(near) :] if one[1] <= factor * least]
        running = [(trial, x) for x, _, trial in near + far[: max(FINALISTS, len(far) // 4)]]
    return [trial.fit_from(x) for trial, x in running]


def of_pairs(
    each: Sequence[Linear], unchanged: FloatArray
) -> Iterator[tuple[FloatArray, NDArray[np.intp]]]:
    """What two changes leave together, where both are taken as linear, for every pair of them.

    The normal equations of many pairs at once take far less time than a fit of each pair.

    Parameters
    ----------
    unchanged : what is left without any change, (m,)

    Yields
    ------
    Of the n pairs with as many numbers: the mean squares of what they leave, (n,), and their
    indices, (n, 2)
    """
    slopes = np.hstack([one.slopes for one in each])
    none = np.column_stack([unchanged, *(one.at_none for one in each)])
    squares, seen, among = none.T @ none, slopes.T @ none, slopes.T @ slopes
    counts = np.array([one.slopes.shape[1] for one in each])
    numbers = np.split(np.arange(counts.sum()), np.cumsum(counts)[:-1])
    every = np.array(list(combinations(range(len(each)), 2)), dtype=np.intp)
    for count in np.unique(counts[every].sum(axis=1)):
        pairs = every[counts[every].sum(axis=1) == count]
        # What both leave is the sum of what either leaves, less what is left unchanged.
        first, second = 1 + pairs.T
        least = squares[first, first] + squares[second, second] + squares[0, 0]
        least += 2 * (squares[first, second] - squares[first, 0] - squares[second, 0])
        if count:
            at = np.array([[*numbers[i], *numbers[j]] for i, j in pairs])
            sums = seen[at, first[:, None]] + seen[at, second[:, None]] - seen[at, 0]
            sizes, directions = np.linalg.eigh(among[at[:, :, None], at[:, None, :]])
            along = (sums[:, None] @ directions)[:, 0] ** 2
            is_seen = sizes > np.maximum(RANK**2 * sizes[:, -1:], TINY)
            explained = np.where(is_seen, along / np.where(is_seen, sizes, 1.0), 0.0).sum(axis=1)
            least = np.maximum(least - explained, EPS * least)
        yield least / len(unchanged), pairs


def mean_square(numbers: FloatArray) -> float:
    """Return the mean of the squares of numbers."""
    return float(np.mean(numbers**2))
