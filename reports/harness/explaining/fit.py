"""Fits the numbers of changes to data, by least squares.

What a hypothesis leaves of the data is in units of what noise and a method's error make of it.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from scipy.optimize import least_squares

from ....scenarios import FloatArray
from ...results.evidence import Explanation
from .changes import FITTED_TENSORS, GYROSCOPIC_TENSOR
from .hypothesis import Change, Hypothesis
from .other_tensors import is_of_a_body

Function = Callable[[FloatArray], FloatArray]
#: What is left where numbers are nan: no motion is that far off.
NOWHERE = 1e30
#: Numbers that are seen less than this, relative to those seen best, do not count.
RANK = 1e-6
EPS = float(np.finfo(float).eps)
#: Evaluations of a fit at most, and a step of a scaled number from which a slope is taken.
EVALUATIONS, SMALL = 20, 1e-5
#: Relative steps at which a fit ends, and one to a part of the data.
NEAR, ROUGHLY = 1e-9, 1e-3
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

    def with_other(self, other: "Linear", unchanged: FloatArray) -> "Linear":
        """What both leave together; without either so much is left unchanged, (m,)."""
        at_none = self.at_none + other.at_none - unchanged
        return Linear(at_none, np.hstack([self.slopes, other.slopes]))


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
        each = [change for change in self.changes for _ in change.sizes]
        added = [k for k, change in enumerate(each) if change not in before.changes]
        left = self.data.left([self.hypothesis(one) for one in (x, *(x + steps[added]))])
        kept = [before.slopes[:, before.rows(one)] for one in self.changes if one in before.changes]
        slopes = np.hstack([*kept, (left[1:] - left[0]).T / SMALL])
        best = np.linalg.lstsq(slopes, left[0], rcond=RANK)[0]
        return self.data.falls(before.rest, left[0] - slopes @ best)

    def _begun(self, before: Fit) -> FloatArray:
        """The numbers of a fit of some of the changes, in units of their sizes, (k,)."""
        each = [before.numbers_of(one) / one.sizes for one in self.changes]
        return np.concatenate([np.empty(0), *each])

    def _minimised(self, samples: int | None) -> tuple[Function, Function]:
        """What is minimised, and its slopes, which are computed at once: that takes less time.

        Returns
        -------
        Functions of the numbers: what is left, (m,), then how far the numbers are from what is
        known beforehand, (p,); and the derivative of all these by each number, (m + p, k)
        """

        @lru_cache(1)
        def both(numbers: bytes) -> tuple[FloatArray, FloatArray]:
            x = np.frombuffer(numbers)
            steps = np.sqrt(EPS) * np.maximum(1.0, np.abs(x))
            hypotheses = [self.hypothesis(one) for one in np.vstack([x, x + np.diag(steps)])]
            unlikely = np.stack([self.data.unlikely(one) for one in hypotheses])
            off = np.hstack([self.data.left(hypotheses, samples), unlikely])
            return off[0], (off[1:] - off[0]).T / steps

        return lambda x: both(x.tobytes())[0], lambda x: both(x.tobytes())[1]

    def fit(self, before: Fit | None = None) -> Fit:
        """Fit the numbers by least squares.

        Parameters
        ----------
        before : a fit of some of the changes, from whose numbers the search begins; else, and where
            they explain nothing, it begins where they are zero, with a part of the data
        """
        x, parts, most = np.zeros(len(self.sizes)), self.data.parts, EVALUATIONS
        if not len(x):
            (rest,) = self.data.left([self.hypothesis(x)])
            none = np.empty((0, 0)), rest, 0, np.empty((len(rest), 0))
            return Fit(self.changes, self.hypothesis(x), x, *none)
        if before is not None and not before.is_hopeless:
            x, parts = self._begun(before), (None,)
        for samples in parts:
            if most == 1 and samples is not None:
                continue
            left, slopes = self._minimised(samples)
            near = NEAR if samples is None else ROUGHLY
            found = least_squares(left, x, slopes, xtol=near, max_nfev=most)
            x = found.x
            if len(parts) > 1 and np.mean(found.fun**2) > HOPELESS:
                most = 1
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


def mean_square(numbers: FloatArray) -> float:
    """Return the mean of the squares of numbers."""
    return float(np.mean(numbers**2))
