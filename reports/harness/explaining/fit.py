"""Fits the parameters of changes to data, by nonlinear least squares.

Residuals are in units of their standard deviation, which is that of noise and a method's error
together. The sum of their squares is χ². Scaled parameters are parameters in units of
`Change.scales`.
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

#: The residual in place of nan, and the largest size of any residual: no motion is that far off.
NOT_FINITE = 1e30
#: Singular values of a Jacobian below this, relative to the largest, count as zero.
RANK = 1e-6
EPS, TINY = float(np.finfo(float).eps), float(np.finfo(float).tiny)
#: The largest number of times that a fit computes its residuals and their derivatives.
EVALUATIONS = 20
#: Relative change of the scaled parameters at which a fit ends: a fit to all data, and to a part.
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
        """Return the residuals of H hypotheses, (H, ...); nan for one that has no finite motion.

        They are the deviations of the data from what a hypothesis predicts, in units of their
        standard deviation. The shape beyond the first axis is that of the data.
        """

    @property
    def omegas(self) -> tuple[FloatArray, FloatArray] | None:
        """ω as attitudes turn, and ω as it was recorded, rad/s, body axes, (n, 3) each.

        None if the data have no recorded ω. Both are approximate: fits start from what they show.
        """
        return None

    def first(self, change: Change) -> FloatArray:
        """Return the k parameters of a change from which fits start: `Change.guess`, or zeros."""
        if change.guess is None or self.omegas is None:
            return np.zeros(len(change.scales))
        return change.guess(*self.omegas)

    def prior_residuals(self, hypotheses: Hypothesis) -> FloatArray:
        """Return the deviations of p numbers of H hypotheses from their prior means, (H, p).

        They are in units of the prior standard deviations. Without a prior, p is 0.
        """
        return np.empty((len(hypotheses), 0))

    @property
    def correlated(self) -> float:
        """How many residuals are correlated with each other, so that they count as one in χ²."""
        return 1.0

    @property
    def beginnings(self) -> Sequence["Data"]:
        """The data to be fitted in turn: the first samples, then more and more, and at last all."""
        return (self,)

    def chi2_decrease(self, before: FloatArray, after: FloatArray) -> float:
        """Return the decrease of χ² by a change of the equations, or of how states are read.

        Parameters
        ----------
        before, after : the residuals without and with the change, of the same shape, in units of
            their standard deviation
        """
        return float(self.chi2_decreases(before.ravel(), after.reshape(1, -1))[0])

    def chi2_decreases(self, before: FloatArray, after: FloatArray) -> FloatArray:
        """Return the decreases of χ² by each of M changes, (M,).

        The changes are those of the equations, or of how states are read. Residuals are in units of
        their standard deviation.

        Parameters
        ----------
        before : the m residuals without a change, (m,)
        after : the residuals with each change, (M, m)
        """
        return np.asarray(np.sum(before**2) - np.sum(after**2, axis=1)) / self.correlated

    def residuals(self, hypotheses: Hypothesis) -> FloatArray:
        """Return the m residuals of each of H hypotheses, those of `deviations`, in rows, (H, m).

        They are limited to ± `NOT_FINITE`, which also takes the place of nan.
        """
        finite = np.nan_to_num(self.deviations(hypotheses), nan=NOT_FINITE)
        return np.clip(finite, -NOT_FINITE, NOT_FINITE).reshape(len(hypotheses), -1)


@dataclass(frozen=True, eq=False)
class Fit:
    """Changes that are made together, with the parameters with which they fit data best.

    Attributes
    ----------
    changes : the changes of the equations, or of how states are read
    hypothesis : the one hypothesis that the changes with these parameters lead to
    parameters : the parameters of all changes, in the order of `changes`, not scaled, (k,)
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
        """Standard errors of all k parameters, not scaled, (k,)."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def explains_nothing(self) -> bool:
        """Whether the residuals are so large that the fitted parameters mean nothing."""
        return self.mean_square > UNEXPLAINED

    @property
    def is_physical(self) -> bool:
        """Whether a mistake can have led to these changes with these parameters.

        The tensor of inertia must be positive definite, but need not be one that a rigid body can
        have. Each change states what else is required (`Change.is_possible`).
        """
        if not np.linalg.eigvalsh(self.hypothesis.inertia)[0] > 0:
            return False
        parameters = map(self.parameters_of, self.changes)
        each = zip(self.changes, parameters, strict=True)
        return all(change.is_possible(self.hypothesis, fitted) for change, fitted in each)

    def columns(self, change: Change) -> slice:
        """Return where one change's parameters are in `parameters`, as a slice."""
        at = sum(len(one.scales) for one in self.changes[: self.changes.index(change)])
        return slice(at, at + len(change.scales))

    def parameters_of(self, change: Change) -> FloatArray:
        """Return the k fitted parameters of one change, (k,); zeros if it is not in `changes`."""
        is_made = change in self.changes
        return self.parameters[self.columns(change)] if is_made else np.zeros(len(change.scales))

    def explanation(self, change: Change) -> Explanation:
        """Return one change with its fitted parameters, in the form in which it is stored."""
        return change.explanation(self.parameters_of(change))


@dataclass(frozen=True, eq=False)
class Linear:
    """A change whose residuals are approximated as linear in its k parameters.

    Attributes
    ----------
    residuals : residuals with the first parameters (`Data.first`), in units of their standard
        deviation, (m,)
    jacobian : derivatives of the residuals by the scaled parameters, (m, k)
    """

    residuals: FloatArray
    jacobian: FloatArray

    @cached_property
    def mean_square(self) -> float:
        """The mean square of the residuals with the parameters that make it smallest."""
        if not self.jacobian.shape[1]:
            return mean_square(self.residuals)
        best = np.linalg.lstsq(self.jacobian, self.residuals, rcond=RANK)[0]
        return mean_square(self.residuals - self.jacobian @ best)


@dataclass(frozen=True, eq=False)
class Trial:
    """Changes of equations, or of how states are read, whose k parameters are fitted together."""

    data: Data
    changes: tuple[Change, ...]

    @cached_property
    def scales(self) -> FloatArray:
        """The typical sizes of the k parameters of all changes, `Change.scales`, (k,)."""
        return np.concatenate([np.empty(0), *(change.scales for change in self.changes)])

    def hypotheses(self, x: FloatArray) -> Hypothesis:
        """Return the hypotheses that result if all changes are made in `data.base`.

        Parameters
        ----------
        x : k scaled parameters of all changes in H hypotheses, (H, k)
        """
        hypotheses, parameters, at = self.data.base.repeated(len(x)), self.scales * x, 0
        for change in self.changes:
            end = at + len(change.scales)
            hypotheses = change.apply(hypotheses, parameters[:, at:end])
            at = end
        return hypotheses

    def at(self, before: Fit) -> Hypothesis:
        """Return the hypothesis that the changes make with the parameters of another fit.

        Parameters
        ----------
        before : a fit of some of the changes; the others have their first parameters
        """
        return self.hypotheses(self._start(before)[None])[0]

    def _start(self, before: Fit | None) -> FloatArray:
        """Return k scaled parameters, (k,): those of a fit of some changes, the others' first.

        Without a fit, all are the first parameters of the changes (`Data.first`).
        """
        each = [
            before.parameters_of(one) if before and one in before.changes else self.data.first(one)
            for one in self.changes
        ]
        return np.concatenate([np.empty(0), *each]) / self.scales

    def fit(self, before: Fit | None = None) -> Fit:
        """Fit the parameters by least squares.

        Parameters
        ----------
        before : a fit of some of the changes, whose parameters the fit starts from. If it is None,
            the fit starts from the first parameters of each change (`Data.first`) with the first
            samples, and goes on to more and more of them.
            If the mean square of the residuals of a part exceeds `UNEXPLAINED`, the fit ends, and
            the residuals of all data are computed with the parameters of that part
        """
        if before is not None:
            return self._fit_from(self._start(before))
        x = self._start(None)
        for data in self.data.beginnings[:-1] if len(x) else ():
            found = Trial(data, self.changes)._least_squares(x, ROUGH, EVALUATIONS)
            x = found.x
            if mean_square(found.fun) > UNEXPLAINED:
                return self._fit_from(x, evaluations=1)
        return self._fit_from(x)

    def _least_squares(self, x: FloatArray, tolerance: float, evaluations: int) -> Any:
        """Return what `scipy.optimize.least_squares` returns, started from k scaled parameters x.

        Parameters
        ----------
        x : (k,)
        tolerance : relative change of the scaled parameters at which the fit ends
        evaluations : how often residuals are computed at most
        """

        # Residuals and Jacobian are computed together, in one call for all finite differences,
        # which takes less time.
        @lru_cache(1)
        def both(parameters: bytes) -> tuple[FloatArray, FloatArray]:
            """Return m residuals and p prior residuals, (m + p,), and their Jacobian, (m + p, k).

            Parameters
            ----------
            parameters : the scaled parameters as bytes, by which the result is cached
            """
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
        """Fit the parameters to all data, starting from k scaled parameters x, (k,).

        Parameters
        ----------
        evaluations : how often residuals and their derivatives are computed at most
        """
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
    """Return each change with its residuals, linearised around its first parameters.

    Parameters
    ----------
    data : the data whose deviations from the changed hypotheses are the residuals
    base : the hypothesis in which each change is made alone
    """
    if not changes:
        return []
    around = [change.around(base, data.first(change)) for change in changes]
    residuals = data.residuals(Hypothesis.joined(around))
    parts = np.split(residuals, np.cumsum([len(each) for each in around])[:-1])
    return [Linear(part[0], (part[1:] - part[0]).T / SMALL) for part in parts]


def of_pairs(
    each: Sequence[Linear], unchanged: FloatArray
) -> Iterator[tuple[FloatArray, NDArray[np.intp]]]:
    """Yield the mean squares of the residuals of all pairs of linearised changes made together.

    The normal equations of many pairs at once take far less time than a fit of each pair.

    Parameters
    ----------
    each : the linearised changes
    unchanged : the m residuals without any change, (m,)

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
        # To first order, the residuals of both changes are the sum of those of each change alone,
        # less those without any change.
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
