"""Fits the parameters of changes to data, by nonlinear least squares.

Residuals are in units of their standard deviation, which noise and a method's error make. Their
sum of squares is χ². Scaled parameters are parameters in units of `Change.scales`.
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
from .hypothesis import SMALL, Change, Hypothesis

#: The residual that stands for nan, and the largest size of a residual: no motion is that far off.
NOT_FINITE = 1e30
#: Singular values of a Jacobian below this, relative to the largest, count as zero.
RANK = 1e-6
EPS, TINY = float(np.finfo(float).eps), float(np.finfo(float).tiny)
#: The largest number of times that a fit computes its residuals and their derivatives.
EVALUATIONS = 20
#: Tolerances of scaled parameters at which a fit ends: to all data, and to a part of them.
TOLERANCE, ROUGH = 1e-9, 1e-3
#: If a fit to a part of the data leaves a larger mean square than this, it is not continued: with
#: more of the data there are only local minima.
UNEXPLAINED = 100.0


@dataclass(frozen=True, eq=False)
class Data(ABC):
    """Data that a change of the equations, or of how states are read, is to explain.

    Attributes
    ----------
    base : the hypothesis in which changes are made: the scene's equations, and states that are read
        without mistakes, unless other changes have been made before
    """

    base: Hypothesis

    @abstractmethod
    def deviations(self, hypotheses: Hypothesis) -> FloatArray:
        """The residuals of H hypotheses; nan where a hypothesis leads to no finite motion.

        Returns
        -------
        (H, ...), of any shape beyond the first axis
        """

    def prior_residuals(self, hypotheses: Hypothesis) -> FloatArray:
        """The deviations of p numbers of H hypotheses from their prior means, (H, p).

        They are in units of the prior standard deviations; empty if there is no prior.
        """
        return np.empty((len(hypotheses), 0))

    @property
    def correlated(self) -> float:
        """How many residuals are correlated, so that together they count as one in χ²."""
        return 1.0

    @property
    def beginnings(self) -> Sequence["Data"]:
        """The first samples, then more and more of them, to be fitted in turn; all data at last."""
        return (self,)

    def chi2_decrease(self, before: FloatArray, after: FloatArray) -> float:
        """The decrease of χ² from the residuals before a change to those after it, in any shape."""
        return float(self.chi2_decreases(before.ravel(), after.reshape(1, -1))[0])

    def chi2_decreases(self, before: FloatArray, after: FloatArray) -> FloatArray:
        """The decreases of χ² from the residuals before M changes, (m,), to those after, (M, m)."""
        return np.asarray(np.sum(before**2) - np.sum(after**2, axis=1)) / self.correlated

    def residuals(self, hypotheses: Hypothesis) -> FloatArray:
        """The residuals of H hypotheses, all of them finite, (H, m)."""
        finite = np.nan_to_num(self.deviations(hypotheses), nan=NOT_FINITE)
        return np.clip(finite, -NOT_FINITE, NOT_FINITE).reshape(len(hypotheses), -1)


@dataclass(frozen=True, eq=False)
class Fit:
    """Changes made together, with the parameters that explain the data best.

    Attributes
    ----------
    hypothesis : the result of the changes with these parameters, one hypothesis
    parameters : the parameters of all changes, in the order of these, not scaled, (k,)
    covariance : covariance of the parameters given the data and the prior, (k, k); it is right only
        if the residuals are noise
    residuals : in units of their standard deviation, (m,)
    rank : how many parameters the data determine
    jacobian : derivatives of the residuals by the scaled parameters, (m, k)
    """

    changes: tuple[Change, ...]
    hypothesis: Hypothesis
    parameters: FloatArray
    covariance: FloatArray
    residuals: FloatArray
    rank: int
    jacobian: FloatArray

    @cached_property
    def mean_square(self) -> float:
        """The mean square of the residuals."""
        return mean_square(self.residuals)

    @property
    def errors(self) -> FloatArray:
        """Standard errors of the parameters, (k,)."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def explains_nothing(self) -> bool:
        """Whether the residuals are so large that the fitted parameters mean nothing."""
        return self.mean_square > UNEXPLAINED

    @property
    def is_physical(self) -> bool:
        """Whether a motion may have been computed with these changes and parameters.

        The tensor of inertia must be positive definite, though a mistake may lead to one that no
        rigid body has. Each change states what else is required (`Change.is_possible`).
        """
        if not np.linalg.eigvalsh(self.hypothesis.inertia)[0] > 0:
            return False
        parameters = map(self.parameters_of, self.changes)
        each = zip(self.changes, parameters, strict=True)
        return all(change.is_possible(self.hypothesis, fitted) for change, fitted in each)

    def columns(self, change: Change) -> slice:
        """The indices of one change's parameters among all parameters."""
        at = sum(len(one.scales) for one in self.changes[: self.changes.index(change)])
        return slice(at, at + len(change.scales))

    def parameters_of(self, change: Change) -> FloatArray:
        """The fitted parameters of one change; zeros if it is not among the changes."""
        is_made = change in self.changes
        return self.parameters[self.columns(change)] if is_made else np.zeros(len(change.scales))

    def explanation(self, change: Change) -> Explanation:
        """One change with its fitted parameters, as it is stored."""
        return change.explanation(self.parameters_of(change))


@dataclass(frozen=True, eq=False)
class Linear:
    """A change whose residuals are taken as linear in its k parameters.

    Attributes
    ----------
    residuals : residuals with parameters of zero, in units of their standard deviation, (m,)
    jacobian : derivatives of the residuals by the scaled parameters, (m, k)
    """

    residuals: FloatArray
    jacobian: FloatArray

    @cached_property
    def mean_square(self) -> float:
        """The mean square of the residuals with the best parameters."""
        if not self.jacobian.shape[1]:
            return mean_square(self.residuals)
        best = np.linalg.lstsq(self.jacobian, self.residuals, rcond=RANK)[0]
        return mean_square(self.residuals - self.jacobian @ best)


@dataclass(frozen=True, eq=False)
class Trial:
    """Changes whose parameters are to be fitted."""

    data: Data
    changes: tuple[Change, ...]

    @cached_property
    def scales(self) -> FloatArray:
        """The scales of all parameters, (k,)."""
        return np.concatenate([np.empty(0), *(change.scales for change in self.changes)])

    def hypotheses(self, x: FloatArray) -> Hypothesis:
        """The hypotheses that all changes make of `data.base`, with scaled parameters x, (H, k)."""
        hypotheses, parameters, at = self.data.base.repeated(len(x)), self.scales * x, 0
        for change in self.changes:
            end = at + len(change.scales)
            hypotheses = change.apply(hypotheses, parameters[:, at:end])
            at = end
        return hypotheses

    def at(self, before: Fit) -> Hypothesis:
        """The hypothesis with the parameters of a fit of some of the changes, the others zero."""
        return self.hypotheses(self._start(before)[None])[0]

    def _start(self, before: Fit) -> FloatArray:
        """The scaled parameters of a fit of some of the changes; zeros for the others, (k,)."""
        each = [before.parameters_of(one) / one.scales for one in self.changes]
        return np.concatenate([np.empty(0), *each])

    def fit(self, before: Fit | None = None) -> Fit:
        """Fit the parameters by least squares.

        Parameters
        ----------
        before : a fit of some of the changes, whose parameters the fit starts from. If it is None,
            the fit starts from zero with the first samples, and goes on to more and more of them.
            If the mean square of the residuals of a part exceeds `UNEXPLAINED`, the fit ends, and
            the residuals of all data are computed with the parameters of that part
        """
        if before is not None:
            return self._fit_from(self._start(before))
        x = np.zeros(len(self.scales))
        for data in self.data.beginnings[:-1] if len(x) else ():
            found = Trial(data, self.changes)._least_squares(x, ROUGH, EVALUATIONS)
            x = found.x
            if mean_square(found.fun) > UNEXPLAINED:
                return self._fit_from(x, evaluations=1)
        return self._fit_from(x)

    def _least_squares(self, x: FloatArray, tolerance: float, evaluations: int) -> Any:
        """The result of `scipy.optimize.least_squares`, started from scaled parameters, (k,).

        Parameters
        ----------
        tolerance : relative change of the scaled parameters at which the fit ends
        evaluations : how often residuals are computed at most
        """

        # The residuals of all finite differences are computed at once, which takes less time.
        @lru_cache(1)
        def both(parameters: bytes) -> tuple[FloatArray, FloatArray]:
            """The residuals and prior residuals, (m + p,), and their Jacobian."""
            x = np.frombuffer(parameters)
            steps = np.sqrt(EPS) * np.maximum(1.0, np.abs(x))
            hypotheses = self.hypotheses(np.vstack([x, x + np.diag(steps)]))
            prior = self.data.prior_residuals(hypotheses)
            residuals = np.hstack([self.data.residuals(hypotheses), prior])
            return residuals[0], (residuals[1:] - residuals[0]).T / steps

        def residuals(x: FloatArray) -> FloatArray:
            return both(x.tobytes())[0]

        def jacobian(x: FloatArray) -> FloatArray:
            return both(x.tobytes())[1]

        return least_squares(residuals, x, jacobian, xtol=tolerance, max_nfev=evaluations)

    def _fit_from(self, x: FloatArray, evaluations: int = EVALUATIONS) -> Fit:
        """Fit the parameters to all data, starting from scaled parameters x, (k,)."""
        if not len(x):
            hypotheses = self.hypotheses(x[None])
            (residuals,) = self.data.residuals(hypotheses)
            none = np.empty((0, 0)), residuals, 0, np.empty((len(residuals), 0))
            return Fit(self.changes, hypotheses[0], x, *none)
        found = self._least_squares(x, TOLERANCE, evaluations)
        x = found.x
        J = np.asarray(found.jac)
        measured = len(J) - self.data.prior_residuals(self.data.base[None]).size
        seen = np.linalg.svd(J[:measured], compute_uv=False)
        rank = int(np.count_nonzero(seen > RANK * seen[0]))
        _, known, directions = np.linalg.svd(J, full_matrices=False)
        # A direction that neither the data nor the prior determine has a large error, not none.
        one_error = directions / np.maximum(known, EPS * (known[0] or 1.0))[:, None]
        covariance = one_error.T @ one_error
        return Fit(
            self.changes,
            self.hypotheses(x[None])[0],
            self.scales * x,
            covariance * np.outer(self.scales, self.scales),
            found.fun[:measured],
            rank,
            J[:measured],
        )


def linear(data: Data, base: Hypothesis, changes: Sequence[Change]) -> list[Linear]:
    """Each change made alone in the hypothesis `base`, linearised around parameters of zero."""
    if not changes:
        return []
    around = [change.around(base) for change in changes]
    residuals = data.residuals(Hypothesis.joined(around))
    parts = np.split(residuals, np.cumsum([len(each) for each in around])[:-1])
    return [Linear(part[0], (part[1:] - part[0]).T / SMALL) for part in parts]


def of_pairs(
    each: Sequence[Linear], unchanged: FloatArray
) -> Iterator[tuple[FloatArray, NDArray[np.intp]]]:
    """The mean squares of all pairs of linearised trials made together.

    The normal equations of many pairs at once take far less time than a fit of each pair.

    Parameters
    ----------
    unchanged : the residuals without any change, (m,)

    Yields
    ------
    For each total number of parameters: the mean squares of the residuals of the n pairs that have
    it, (n,), and the indices of these pairs in `each`, (n, 2)
    """
    jacobian = np.hstack([one.jacobian for one in each])
    zero = np.column_stack([unchanged, *(one.residuals for one in each)])
    squares, seen, among = zero.T @ zero, jacobian.T @ zero, jacobian.T @ jacobian
    counts = np.array([one.jacobian.shape[1] for one in each])
    parameters = np.split(np.arange(counts.sum()), np.cumsum(counts)[:-1])
    every = np.array(list(combinations(range(len(each)), 2)), dtype=np.intp)
    for count in np.unique(counts[every].sum(axis=1)):
        pairs = every[counts[every].sum(axis=1) == count]
        # The residuals of both are the sum of those of either, less those without any change.
        first, second = 1 + pairs.T
        least = squares[first, first] + squares[second, second] + squares[0, 0]
        least += 2 * (squares[first, second] - squares[first, 0] - squares[second, 0])
        if count:
            at = np.array([[*parameters[i], *parameters[j]] for i, j in pairs])
            sums = seen[at, first[:, None]] + seen[at, second[:, None]] - seen[at, 0]
            sizes, directions = np.linalg.eigh(among[at[:, :, None], at[:, None, :]])
            along = (sums[:, None] @ directions)[:, 0] ** 2
            is_seen = sizes > np.maximum(RANK**2 * sizes[:, -1:], TINY)
            explained = np.where(is_seen, along / np.where(is_seen, sizes, 1.0), 0.0).sum(axis=1)
            least = np.maximum(least - explained, EPS * least)
        yield least / len(unchanged), pairs


def mean_square(values: FloatArray) -> float:
    """Return the mean of the squares of values of any shape."""
    return float(np.mean(values**2))
