"""Finds changes that explain a motion together with a method's error, however large that error is.

But for the next term of its series, a method's error is a combination of elementary differentials
(`leading_error.py`). What is left of the residuals after a fit of these is compared with the size
of that next term alone.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from .....scenarios import FloatArray
from ...explaining.fit import RANK, Data, Fit, Trial, linear
from ...explaining.hypothesis import Change, Hypothesis
from ...explaining.search import LEFT, Search
from ..samples.intervals import Intervals, root_mean_squares
from ..samples.mistakes import FITS
from .leading_error import LARGEST, leading_errors

#: Factor by which the errors of methods that are fitted once changes are made may exceed the size
#: that was assumed of them to find the changes.
ROOM = 2.0


@dataclass(frozen=True, eq=False)
class BesideMethods(Data):
    """Intervals in which the leading errors of methods count like noise of a known size.

    Attributes
    ----------
    directions : orthonormal columns that span these errors, (6 S, n)
    sizes : standard deviations of the errors along each column, in units of the intervals' scale,
        (n,)
    """

    intervals: Intervals
    directions: FloatArray
    sizes: FloatArray

    @staticmethod
    def of(intervals: Intervals, errors: FloatArray) -> "BesideMethods":
        """Return the intervals with errors of methods that have coefficients up to `LARGEST`.

        Parameters
        ----------
        errors : the errors with coefficients of one, rad and rad/s, (k, S, 6)
        """
        columns = (LARGEST * errors / intervals.scale).reshape(len(errors), -1).T
        directions, sizes, _ = np.linalg.svd(columns, full_matrices=False)
        return BesideMethods(intervals.base, intervals, directions, sizes)

    @property
    def correlated(self) -> float:
        """How many residuals count as one in χ²: as many as in `intervals`."""
        return self.intervals.correlated

    def deviations(self, hypotheses: Hypothesis) -> FloatArray:
        """The residuals of H hypotheses, as in `Data`, (H, S, 6).

        They are in units of the intervals' scale and the errors of methods together.
        """
        each = self.intervals.deviations(hypotheses)
        flat = each.reshape(len(hypotheses), -1)
        of_methods = (flat @ self.directions) * (1 - 1 / np.hypot(1.0, self.sizes))
        return np.asarray(flat - of_methods @ self.directions.T).reshape(each.shape)


def within_error(
    data: Intervals,
    changes: Sequence[Change],
    most: int,
    orders: Sequence[int],
    timestep: float | None,
    next_term: float,
) -> Fit | None:
    """Return the change, or pair, that explains what methods' errors leave of residuals; or None.

    A fit counts only if the errors of methods beside it are about as large as was assumed.

    Parameters
    ----------
    most : the most parameters of a fit
    orders, timestep : orders of the methods that may have computed the motion, and their timestep,
        s; None if unknown
    next_term : the next term of a method's error, relative to the leading one
    """
    errors = leading_errors(data, orders, timestep)
    for size in _sizes(data, errors, changes):
        found, size = _beside(data, errors, changes, most, next_term, size)
        if found is not None and found.rank <= most:
            fitted = _fitted_size(data, errors, data.deviations(found.hypothesis[None]))
            if (fitted <= ROOM * np.maximum(size, data.noise)).all():
                return found
    return None


def refitted(
    data: Intervals, found: Fit, order: int, timestep: float | None, next_term: float
) -> Fit | None:
    """Return a fit of the same changes together with the errors of methods of an order.

    Parameters
    ----------
    found : a fit of the changes alone
    order, timestep, next_term : as in `within_error`

    Returns
    -------
    None if the residuals exceed the next term of these errors
    """
    of_changes = replace(data, base=found.hypothesis)
    errors = leading_errors(of_changes, [order], timestep)
    size = root_mean_squares(data.deviations(found.hypothesis[None])[0] * data.scale)
    with_next_term = data.with_error(np.maximum(next_term * size, FITS))
    fit = Trial(BesideMethods.of(with_next_term, errors), found.changes).fit(found)
    return fit if fit.mean_square <= 1 else None


def _beside(
    data: Intervals,
    errors: FloatArray,
    changes: Sequence[Change],
    most: int,
    next_term: float,
    size: FloatArray,
) -> tuple[Fit | None, FloatArray]:
    """Return the change, or pair, that explains what methods' errors of some size leave.

    Parameters
    ----------
    errors : the errors with coefficients of one, rad and rad/s, (k, S, 6)
    most, next_term : as in `within_error`
    size : size of methods' errors if there is no change, rad and rad/s, (2,). If these errors are
        far smaller with some change, that smaller size is used

    Returns
    -------
    The fit, None if no change explains the residuals, and the size that was used, (2,)
    """
    while True:
        with_next_term = data.with_error(np.maximum(next_term * size, FITS))
        beside = BesideMethods.of(with_next_term, errors)
        search = Search(beside, changes, most, part=0.0)
        found = search.one_or_two()
        fitted = [
            _fitted_size(data, errors, data.deviations(fit.hypothesis[None]))
            for fit in search.single
        ]
        least = min(
            fitted, key=lambda one: float(np.max(one / np.maximum(size, FITS))), default=size
        )
        if (least > LEFT * size).any() or (size <= FITS).all():
            return found, size
        size = least


def _sizes(data: Intervals, errors: FloatArray, changes: Sequence[Change]) -> list[FloatArray]:
    """Return the sizes that the errors of methods may have, rad and rad/s, (2,) each.

    The first is the size without any change, the last is the least size that a single change
    leaves, and the one between is the geometric mean of both.
    """
    most = _fitted_size(data, errors, data.deviations(data.base[None]))
    units = np.maximum(most, FITS)
    of_changes = []
    for one in linear(data, data.base, changes):
        columns = one.jacobian.T.reshape(-1, *data.scale.shape) * data.scale
        of_changes.append(_fitted_size(data, errors, one.residuals, columns))
    least = min(of_changes, key=lambda size: float(np.sum((size / units) ** 2)))
    return [most, np.sqrt(most * least), least]


def _fitted_size(
    data: Intervals, errors: FloatArray, deviation: FloatArray, others: FloatArray | None = None
) -> FloatArray:
    """Return the size of methods' errors when these are fitted to residuals, rad and rad/s, (2,).

    Parameters
    ----------
    errors : errors of methods with coefficients of one, rad and rad/s, (k, S, 6)
    deviation : the residuals, in units of the intervals' scale, 6 S numbers
    others : further columns that are fitted to the residuals, rad and rad/s, (m, S, 6)
    """
    every = errors if others is None else np.concatenate([errors, others])
    columns = (every / data.scale).reshape(len(every), -1).T
    columns = columns / np.maximum(np.linalg.norm(columns, axis=0), np.finfo(float).tiny)
    best = np.linalg.lstsq(columns, deviation.ravel(), rcond=RANK)[0]
    fitted = columns[:, : len(errors)] @ best[: len(errors)]
    return root_mean_squares(fitted.reshape(data.scale.shape) * data.scale)
