"""Distances between two motions in each signal, relative to a base of the exact one."""

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
    """Distances from the exact motion sample by sample, (n, signals); by a signal's name, (n,)."""

    signals: tuple[Signal, ...]
    distances: FloatArray

    def __getitem__(self, name: str) -> FloatArray:
        names = [signal.name for signal in self.signals]
        column: FloatArray = self.distances[:, names.index(name)]
        return column

    def first_beyond(self, name: str, bound: float) -> int | None:
        """The first sample at which a signal is further off than that; None if at none."""
        beyond = np.flatnonzero(~(self[name] <= bound))
        return int(beyond[0]) if len(beyond) else None

    def worst(self) -> Errors:
        """The largest of each over the samples."""
        largest = map(float, self.distances.max(axis=0))
        return Errors(**{s.name: size for s, size in zip(self.signals, largest, strict=True)})


@dataclass(frozen=True, eq=False)
class ErrorNorm:
    """The norm of errors against an exact motion: motions as tables of signals, their distances."""

    scenario: Scenario
    exact: Trajectory

    def table(self, motion: Trajectory) -> FloatArray:
        """All signals of a motion side by side, SI, (n, columns of all)."""
        return np.column_stack([self._values(signal, motion) for signal in self.signals])

    @cached_property
    def signals(self) -> tuple[Signal, ...]:
        """The signals that the scene has."""
        return signals_of(self.scenario)

    @cached_property
    def true_table(self) -> FloatArray:
        """The table of the exact motion."""
        return self.table(self.exact)

    def distances(self, table: FloatArray, other: FloatArray) -> FloatArray:
        """The distances of two motions of n samples, (n, signals); q and −q are one attitude.

        Over a base of zero they are 0 where equal and inf elsewhere.
        """
        apart = table - other
        first = [columns.start for columns in self._columns]
        # Of what has blown up the square may be too large for a double.
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
        """Richardson's limit of dt and dt / 2 (Hairer, Nørsett & Wanner I, §II.4), a table.

        Parameters
        ----------
        orders : of accuracy, by signal, (signals,)
        """
        widths = [columns.stop - columns.start for columns in self._columns]
        weights = np.repeat(1 / (2.0 ** np.asarray(orders) - 1), widths)
        limit: FloatArray = fine + weights * (fine - coarse)
        for signal, columns in zip(self.signals, self._columns, strict=True):
            if signal.kind == "quaternion":
                limit[:, columns] = _normalised(limit[:, columns])
        return limit

    def _values(self, signal: Signal, motion: Trajectory) -> FloatArray:
        """A signal of a motion; quaternions of unit norm, with the sign of the exact ones."""
        values = signal.values(self.scenario, motion)
        if signal.kind != "quaternion":
            return values
        q = _normalised(values)
        same_side = np.einsum("ni,ni->n", q, signal.values(self.scenario, self.exact)) >= 0
        return np.where(same_side[:, None], q, -q)

    @cached_property
    def _bases(self) -> FloatArray:
        """What distances are relative to, (signals,)."""
        return np.array([signal.base(self.scenario, self.exact) for signal in self.signals])

    @cached_property
    def _columns(self) -> list[slice]:
        """The columns of each signal in a table of them all."""
        columns, end = [], 0
        for signal in self.signals:
            values = signal.values(self.scenario, self.exact)
            begin, end = end, end + (values.shape[1] if values.ndim > 1 else 1)
            columns.append(slice(begin, end))
        return columns


def error_series(scenario: Scenario, motion: Trajectory, exact: Trajectory) -> ErrorSeries:
    """Errors of `motion` at its own sample times, which must be those of `exact`.

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
    """The errors of `motion` against `exact`, the largest of each signal."""
    return error_series(scenario, motion, exact).worst()


@lru_cache(maxsize=RECENT)
def norm_of(scenario: Scenario, exact: Trajectory) -> ErrorNorm:
    """The norm of errors against an exact motion; kept, for all its runs are compared by it."""
    return ErrorNorm(scenario, exact)


def _normalised(q_wxyz: FloatArray) -> FloatArray:
    return np.asarray(q_wxyz / norms(q_wxyz)[:, None])
