"""Changes that explain what no method's error does, though that may be as large as the difference.

A method's error is spanned by elementary differentials (`leading_error.py`), but for the next term
of its series: what is left beside them is compared with that term alone.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ....scenarios import FloatArray
from ..explaining.fit import RANK, Data, Fit, Trial, linear
from ..explaining.hypothesis import Change, Hypothesis
from ..explaining.search import LEFT, Search
from .intervals import Intervals, root_mean_squares
from .leading_error import LARGEST, leading_errors
from .mistakes import FITS

#: With changes that explain the rest, methods may make so much more than their error was taken for:
#: without them it is the best fit of both together.
ROOM = 2.0


@dataclass(frozen=True, eq=False)
class BesideMethods(Data):
    """Intervals in which leading errors of methods count as errors.

    Attributes
    ----------
    directions : orthonormal columns that span these errors, (6 S, n)
    sizes : how large the errors may be along each, in units of the intervals' scale, (n,)
    """

    intervals: Intervals
    directions: FloatArray
    sizes: FloatArray

    @staticmethod
    def of(intervals: Intervals, errors: FloatArray) -> "BesideMethods":
        """Take errors of methods, (k, S, 6), with coefficients of up to `LARGEST`, into account."""
        columns = (LARGEST * errors / intervals.scale).reshape(len(errors), -1).T
        directions, sizes, _ = np.linalg.svd(columns, full_matrices=False)
        return BesideMethods(intervals.base, intervals, directions, sizes)

    @property
    def correlated(self) -> float:
        """As in `Data`: the next term of a method's error counts as one number."""
        return self.intervals.correlated

    def deviations(
        self, hypotheses: Sequence[Hypothesis], samples: int | None = None
    ) -> FloatArray:
        """As in `Data`, in units of the scale and of the errors of methods together, (H, 6 S)."""
        off = self.intervals.deviations(hypotheses).reshape(len(hypotheses), -1)
        of_methods = (off @ self.directions) * (1 - 1 / np.hypot(1.0, self.sizes))
        return np.asarray(off - of_methods @ self.directions.T)[:, :samples]


def within_error(
    data: Intervals,
    changes: Sequence[Change],
    most: int,
    orders: Sequence[int],
    timestep: float | None,
    next_term: float,
) -> Fit | None:
    """Return the change, or two, that explain what no method leaves; None if none does.

    Parameters
    ----------
    most : how many numbers are fitted, at most
    orders, timestep : of methods that may have made the motion; s, None if unknown
    next_term : the next term of a method's error, relative to the leading one
    """
    errors = leading_errors(data, orders, timestep)
    for size in _sizes(data, errors, changes):
        found, size = _beside(data, errors, changes, most, next_term, size)
        if found is not None and found.rank <= most:
            made = _made(data, errors, data.deviations([found.hypothesis]))
            if (made <= ROOM * np.maximum(size, data.noise)).all():
                return found
    return None


def refitted(
    data: Intervals, found: Fit, order: int, timestep: float | None, next_term: float
) -> Fit | None:
    """Return changes fitted beside the errors of methods of an order; None if more is left.

    Parameters
    ----------
    found : a fit of the changes alone
    order, timestep, next_term : as in `within_error`
    """
    of_changes = replace(data, base=found.hypothesis)
    errors = leading_errors(of_changes, [order], timestep)
    size = root_mean_squares(data.deviations([found.hypothesis])[0] * data.scale)
    nearly = data.with_error(np.maximum(next_term * size, FITS))
    fit = Trial(BesideMethods.of(nearly, errors), found.changes).fit(found)
    return fit if fit.mean_square <= 1 else None


def _beside(
    data: Intervals,
    errors: FloatArray,
    changes: Sequence[Change],
    most: int,
    next_term: float,
    size: FloatArray,
) -> tuple[Fit | None, FloatArray]:
    """Return the change, or two, that explain what methods do not, and how large their error is.

    Parameters
    ----------
    size : of the methods' error without any change, rad and rad/s, (2,); if some change leaves far
        less to methods, then it is no larger than that
    """
    while True:
        nearly = data.with_error(np.maximum(next_term * size, FITS))
        beside = BesideMethods.of(nearly, errors)
        search = Search(beside, changes, most, part=0.0)
        found = search.one_or_two()
        made = [_made(data, errors, data.deviations([fit.hypothesis])) for fit in search.single]
        least = min(made, key=lambda one: float(np.max(one / np.maximum(size, FITS))), default=size)
        if (least > LEFT * size).any() or (size <= FITS).all():
            return found, size
        size = least


def _sizes(data: Intervals, errors: FloatArray, changes: Sequence[Change]) -> list[FloatArray]:
    """Return how large the error of methods may be, in attitude, rad, and ω, rad/s, (2,) each.

    That is as large as without any change, or as with the change that leaves least of it, or
    between these.
    """
    most = _made(data, errors, data.deviations([data.base]))
    units = np.maximum(most, FITS)
    of_changes = []
    for one in linear([Trial(data, (change,)) for change in changes]):
        columns = one.jacobian.T.reshape(-1, *data.scale.shape) * data.scale
        of_changes.append(_made(data, errors, one.residuals, columns))
    least = min(of_changes, key=lambda size: float(np.sum((size / units) ** 2)))
    return [most, np.sqrt(most * least), least]


def _made(
    data: Intervals, errors: FloatArray, off: FloatArray, others: FloatArray | None = None
) -> FloatArray:
    """Return the size of what methods explain of what is left, rad and rad/s, (2,).

    Parameters
    ----------
    off : what is left, in units of the intervals' scale, of 6 S numbers
    others : what else explains it, rad and rad/s, (m, S, 6)
    """
    every = errors if others is None else np.concatenate([errors, others])
    columns = (every / data.scale).reshape(len(every), -1).T
    columns = columns / np.maximum(np.linalg.norm(columns, axis=0), np.finfo(float).tiny)
    best = np.linalg.lstsq(columns, off.ravel(), rcond=RANK)[0]
    made = columns[:, : len(errors)] @ best[: len(errors)]
    return root_mean_squares(made.reshape(data.scale.shape) * data.scale)
