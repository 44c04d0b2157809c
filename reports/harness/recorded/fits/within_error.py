"""Finds changes that explain a motion together with a method's error, however large that error is.

A change (`Change`) is one of the equations, or of how states are read. The leading term of a
method's error is a combination of elementary differentials (`leading_error.py`), which are fitted
to the residuals. What this fit leaves may be as large as the next term of the error.
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

#: A size of methods' errors is assumed to find changes. The errors that are fitted beside these
#: changes may be larger by this factor.
ROOM = 2.0


@dataclass(frozen=True, eq=False)
class BesideMethods(Data):
    """S intervals in which the leading errors of methods count like noise of a known size.

    Attributes
    ----------
    intervals : the intervals, whose scale is that of all other errors
    directions : orthonormal columns that span the leading errors of methods, (6 S, n)
    sizes : standard deviations of these errors along each column, in units of `intervals.scale`,
        (n,)
    """

    intervals: Intervals
    directions: FloatArray
    sizes: FloatArray

    @staticmethod
    def of(intervals: Intervals, errors: FloatArray) -> "BesideMethods":
        """Return S intervals with leading errors of methods.

        Parameters
        ----------
        errors : the errors by each of k elementary differentials with a coefficient of one, rad and
            rad/s, (k, S, 6); the coefficients are taken to have standard deviations of `LARGEST`
        """
        columns = (LARGEST * errors / intervals.scale).reshape(len(errors), -1).T
        directions, sizes, _ = np.linalg.svd(columns, full_matrices=False)
        return BesideMethods(intervals.base, intervals, directions, sizes)

    @property
    def correlated(self) -> float:
        """The number of residuals that count as one in χ², which is that of `intervals`."""
        return self.intervals.correlated

    def deviations(self, hypotheses: Hypothesis) -> FloatArray:
        """Return the residuals of H hypotheses in S intervals, (H, S, 6).

        They are in units of their standard deviation: that of all other errors, `intervals.scale`,
        to which the standard deviation of methods' errors is added along `directions`.
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
    """Return the fit of a change, or a pair, that explains a motion beside methods' errors.

    The changes are those of the equations, or of how states are read. None is returned if none
    explains the motion. Several sizes of the errors are assumed in turn. A fit counts only if the
    errors that are then fitted beside it are no larger than assumed, but for a factor of `ROOM`.

    Parameters
    ----------
    data : the intervals of the motion
    changes : the changes that are tried
    most : the most parameters of a fit
    orders : orders of the methods that may have computed the motion
    timestep : timestep of these methods, s; None if unknown
    next_term : size of the next term of a method's error, relative to the leading term
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
    """Fit changes of the equations again, together with leading errors of methods of one order.

    Parameters
    ----------
    data : the intervals of the motion
    found : a fit of the changes alone
    order, timestep : order of the methods, and their timestep, s; None if unknown
    next_term : size of the next term of a method's error, relative to the leading term

    Returns
    -------
    The fit; None if its residuals exceed the next term of these errors
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
    """Fit a change, or a pair, that explains a motion together with method errors of a given size.

    Parameters
    ----------
    data : the S intervals of the motion
    errors : the methods' errors by each of k elementary differentials with a coefficient of one,
        rad and rad/s, (k, S, 6)
    changes : the changes that are tried
    most : the most parameters of a fit
    next_term : size of the next term of a method's error, relative to the leading term
    size : assumed size of methods' errors, rad and rad/s, (2,). If far smaller errors fit beside
        some change, that smaller size is assumed instead

    Returns
    -------
    The fit, or None if no change explains the motion; and the size that was assumed last, (2,)
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
    """Return three sizes that the errors of methods may have, rad and rad/s, (2,) each.

    The first is fitted without any change. The last is the smallest that is fitted beside a single
    change, linearised. The second is the geometric mean of these two.

    Parameters
    ----------
    data : the S intervals of the motion
    errors : the errors by each of k elementary differentials with a coefficient of one, rad and
        rad/s, (k, S, 6)
    changes : the changes that are tried
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
    """Return the root mean square size of methods' errors that fit residuals, rad and rad/s, (2,).

    Parameters
    ----------
    data : the S intervals of the motion
    errors : the errors by each of k elementary differentials with a coefficient of one, rad and
        rad/s, (k, S, 6)
    deviation : the residuals, in units of `data.scale`, 6 S numbers
    others : m further columns that are fitted together with the errors, rad and rad/s, (m, S, 6);
        none if None
    """
    every = errors if others is None else np.concatenate([errors, others])
    columns = (every / data.scale).reshape(len(every), -1).T
    columns = columns / np.maximum(np.linalg.norm(columns, axis=0), np.finfo(float).tiny)
    best = np.linalg.lstsq(columns, deviation.ravel(), rcond=RANK)[0]
    fitted = columns[:, : len(errors)] @ best[: len(errors)]
    return root_mean_squares(fitted.reshape(data.scale.shape) * data.scale)
