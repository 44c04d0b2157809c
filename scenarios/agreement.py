"""Distances between two motions in each signal, relative to the size of the exact motion."""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from .float_array import FloatArray
from .mechanics import RECENT
from .rotation import norms
from .scenario import Scenario
from .signals import Errors, Signal, signals_of
from .trajectory import Trajectory


@dataclass(frozen=True, eq=False)
class ErrorSeries:
    """Distances of a motion from the exact motion at n samples, in each signal.

    Attributes
    ----------
    signals : the signals that the scene has
    distances : the distance in each signal, rad for the attitude, relative for the others,
        (n, signals); ``series[name]`` is the distance in one signal, (n,)
    """

    signals: tuple[Signal, ...]
    distances: FloatArray

    def __getitem__(self, name: str) -> FloatArray:
        names = [signal.name for signal in self.signals]
        column: FloatArray = self.distances[:, names.index(name)]
        return column

    def first_beyond(self, name: str, bound: float) -> int | None:
        """Return the index of the first sample at which a signal's distance exceeds a bound.

        A distance that is NaN counts as above the bound. If there is no such sample, the result is
        None.

        Parameters
        ----------
        name : name of the signal
        bound : the bound, in rad for the attitude, relative for the other signals
        """
        beyond = np.flatnonzero(~(self[name] <= bound))
        return int(beyond[0]) if len(beyond) else None

    def worst(self) -> Errors:
        """Return the largest error of each signal over all samples."""
        largest = map(float, self.distances.max(axis=0))
        return Errors(**{s.name: size for s, size in zip(self.signals, largest, strict=True)})


@dataclass(frozen=True, eq=False)
class ErrorNorm:
    """The norm of errors of a scene's motions, from its exact motion at the same samples.

    A motion is converted to an array with the values of all its signals side by side, called its
    table. Distances between motions are computed from their tables.
    """

    scenario: Scenario
    exact: Trajectory

    def table(self, motion: Trajectory) -> FloatArray:
        """Return all signals of a motion side by side, SI, (n, columns of all signals).

        There is a row for each of the motion's n samples.
        """
        return np.column_stack([self._values(signal, motion) for signal in self.signals])

    @cached_property
    def signals(self) -> tuple[Signal, ...]:
        """The signals that the scene has."""
        return signals_of(self.scenario)

    @cached_property
    def true_table(self) -> FloatArray:
        """All signals of the exact motion's n samples, SI, (n, columns of all signals)."""
        return self.table(self.exact)

    def distances(self, table: FloatArray, other: FloatArray) -> FloatArray:
        """Return the distances of two motions in each signal, given their tables.

        There is a row for each of n samples, (n, signals). The tables are those that the method
        `table` returns. Distances are in rad for the attitude, and relative for the other signals.
        Quaternions q and −q are the same attitude. If the number that a signal's distances are
        relative to is zero, a distance is 0 where both motions are equal and inf elsewhere.
        """
        apart = table - other
        first = [columns.start for columns in self._columns]
        # After a blow-up the square may be too large for a double.
        with np.errstate(over="ignore"):
            distances: FloatArray = np.sqrt(np.add.reduceat(apart * apart, first, axis=1))
        for k, (signal, columns) in enumerate(zip(self.signals, self._columns, strict=True)):
            if signal.kind == "scalar":
                distances[:, k] = np.abs(apart[:, columns.start])
            elif signal.kind == "quaternion":
                opposite = norms(table[:, columns] + other[:, columns])
                distances[:, k] = np.minimum(distances[:, k], opposite)
                # The chord between unit quaternions is 2 sin of a quarter of the angle.
                distances[:, k] = 4 * np.arcsin(np.minimum(distances[:, k] / 2, 1.0))
        if self._bases.all():
            return distances / self._bases
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(distances == 0, 0.0, distances / self._bases)

    def extrapolated(
        self, coarse: FloatArray, fine: FloatArray, orders: FloatArray | list[int]
    ) -> FloatArray:
        """Return the table in the limit dt → 0 that Richardson's extrapolation of two tables gives.

        Its quaternions are normalised (Hairer, Nørsett & Wanner I, §II.4).

        Parameters
        ----------
        coarse, fine : tables of motions with timestep dt and with timestep dt / 2
        orders : order of accuracy of each signal, (signals,)
        """
        widths = [columns.stop - columns.start for columns in self._columns]
        weights = np.repeat(1 / (2.0 ** np.asarray(orders) - 1), widths)
        limit: FloatArray = fine + weights * (fine - coarse)
        for signal, columns in zip(self.signals, self._columns, strict=True):
            if signal.kind == "quaternion":
                limit[:, columns] = _normalised(limit[:, columns])
        return limit

    def _values(self, signal: Signal, motion: Trajectory) -> FloatArray:
        """Return a signal at a motion's n samples, SI, (n,) for a scalar, else (n, columns).

        Quaternions are normalised, and have the sign nearer to the exact motion's.
        """
        values = signal.values(self.scenario, motion)
        if signal.kind != "quaternion":
            return values
        q = _normalised(values)
        same_side = np.einsum("ni,ni->n", q, signal.values(self.scenario, self.exact)) >= 0
        return np.where(same_side[:, None], q, -q)

    @cached_property
    def _bases(self) -> FloatArray:
        """The numbers that distances in each signal are relative to, (signals,)."""
        return np.array([signal.base(self.scenario, self.exact) for signal in self.signals])

    @cached_property
    def _columns(self) -> list[slice]:
        """The columns that each signal has in a table of all signals."""
        columns, end = [], 0
        for signal in self.signals:
            values = signal.values(self.scenario, self.exact)
            begin, end = end, end + (values.shape[1] if values.ndim > 1 else 1)
            columns.append(slice(begin, end))
        return columns


def error_series(scenario: Scenario, motion: Trajectory, exact: Trajectory) -> ErrorSeries:
    """Return the errors of `motion` at its own sample times, which must be those of `exact`.

    Raises
    ------
    ValueError
        If the two are not sampled at the same times: nothing is interpolated.
    """
    if not np.array_equal(motion.t, exact.t):
        raise ValueError("'motion' and 'exact' must be sampled at the same times.")
    norm = norm_of(scenario, exact)
    return ErrorSeries(norm.signals, norm.distances(norm.table(motion), norm.true_table))


def errors_between(scenario: Scenario, motion: Trajectory, exact: Trajectory) -> Errors:
    """Return the error of `motion` in each signal: its largest distance from `exact`.

    It raises ValueError if the two are not sampled at the same times.
    """
    return error_series(scenario, motion, exact).worst()


@lru_cache(maxsize=RECENT)
def norm_of(scenario: Scenario, exact: Trajectory) -> ErrorNorm:
    """Return the norm of errors from an exact motion; it is cached for all runs of the scene."""
    return ErrorNorm(scenario, exact)


def _normalised(q_wxyz: FloatArray) -> FloatArray:
    """Return n quaternions, (n, 4), divided by their norms."""
    return np.asarray(q_wxyz / norms(q_wxyz)[:, None])
