"""Distances between two motions in each signal, relative to a base of the exact one."""

from collections.abc import Iterator
from dataclasses import dataclass, fields
from functools import cached_property, lru_cache

import numpy as np

from .float_array import FloatArray
from .mechanics import RECENT, angular_momentum_world, energy, energy_base
from .scenario import Scenario
from .trajectory import Trajectory


@dataclass(frozen=True)
class Errors:
    """One number a signal.

    Attributes
    ----------
    omega : max |ω_e − ω_r| / max |ω_r|, body axes
    attitude : max angle of R_eᵀ R_r, rad
    angular_momentum : max |L_e − L_r| / max |L_r|, world axes
    energy : max |E_e − E_r| / (max T_r + m |g| max |r_com|)
    com : max |r_e − r_r| / max(the longest way of r_r from its start, k), world axes
    velocity : max |v_e − v_r| / max(max |v_r|, k max |ω_r|), world axes, of the com

    The radius of gyration k = √(tr I / 2m), I about the fixed point, is there for a com that stays
    where it is.
    """

    omega: float
    attitude: float
    angular_momentum: float
    energy: float
    com: float
    velocity: float

    def __iter__(self) -> Iterator[tuple[str, float]]:
        return iter((field.name, getattr(self, field.name)) for field in fields(self))


@dataclass(frozen=True, eq=False)
class ErrorSeries:
    """The same, sample by sample, each (n,)."""

    omega: FloatArray
    attitude: FloatArray
    angular_momentum: FloatArray
    energy: FloatArray
    com: FloatArray
    velocity: FloatArray

    def worst(self) -> Errors:
        """The largest of each over the samples."""
        return Errors(*(float(getattr(self, field.name).max()) for field in fields(self)))


#: Columns of each signal in a table of them all, in the order of `Errors`.
WIDTHS = {"omega": 3, "attitude": 4, "angular_momentum": 3, "energy": 1, "com": 3, "velocity": 3}
_FIRST_COLUMNS = np.cumsum([0, *WIDTHS.values()])[:-1]
_ATTITUDE = list(WIDTHS).index("attitude")
_ENERGY = list(WIDTHS).index("energy")
_QUATERNION = slice(_FIRST_COLUMNS[_ATTITUDE], _FIRST_COLUMNS[_ATTITUDE] + 4)


@dataclass(frozen=True, eq=False)
class ErrorNorm:
    """The norm of errors against an exact motion: motions as tables of signals, their distances."""

    scenario: Scenario
    exact: Trajectory

    def table(self, motion: Trajectory) -> FloatArray:
        """All signals of a motion, SI, (n, 17); quaternions with the sign of the exact ones."""
        return _table(self.scenario, motion, self.exact)

    @cached_property
    def true_table(self) -> FloatArray:
        """The table of the exact motion, SI, (n, 17)."""
        return self.table(self.exact)

    def distances(self, table: FloatArray, other: FloatArray) -> FloatArray:
        """Between two motions of n samples, by signal in the order of `Errors`, (n, 6).

        Over a base of zero they are 0 where equal and inf elsewhere.
        """
        apart = table - other
        # Of what has blown up the square may be too large for a double.
        with np.errstate(over="ignore"):
            distances: FloatArray = np.sqrt(np.add.reduceat(apart * apart, _FIRST_COLUMNS, axis=1))
        distances[:, _ENERGY] = np.abs(apart[:, _FIRST_COLUMNS[_ENERGY]])
        # The chord between unit quaternions is 2 sin of a quarter of the angle.
        half_chord = np.minimum(distances[:, _ATTITUDE] / 2, 1.0)
        distances[:, _ATTITUDE] = 4 * np.arcsin(half_chord)
        if self._bases.all():
            return distances / self._bases
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(distances > 0, distances / self._bases, 0.0)

    def extrapolated(
        self, coarse: FloatArray, fine: FloatArray, orders: FloatArray | list[int]
    ) -> FloatArray:
        """Richardson's limit of dt and dt / 2 (Hairer, Nørsett & Wanner I, §II.4), a table.

        Parameters
        ----------
        orders : of accuracy, by signal, (6,)
        """
        weights = np.repeat(1 / (2.0 ** np.asarray(orders) - 1), list(WIDTHS.values()))
        limit: FloatArray = fine + weights * (fine - coarse)
        limit[:, _QUATERNION] = _normalised(limit[:, _QUATERNION])
        return limit

    @cached_property
    def _bases(self) -> FloatArray:
        """What distances are relative to, (6,)."""
        speed = _longest(self.exact.omega_body)
        gyration = radius_of_gyration(self.scenario)
        way = _longest(self.exact.com_world - self.exact.com_world[0])
        fast = _longest(self.exact.velocity_world)
        L = _longest(angular_momentum_world(self.scenario, self.exact))
        joule = energy_base(self.scenario, self.exact)
        return np.array([speed, 1.0, L, joule, max(way, gyration), max(fast, gyration * speed)])


def radius_of_gyration(scenario: Scenario) -> float:
    """√(tr I / 2m), m; I about the pivot, or the com where there is none."""
    body = scenario.body
    inertia = body.inertia_origin if scenario.has_pivot else body.inertia_com
    return float(np.sqrt(np.trace(inertia) / (2 * body.mass)))


def error_series(scenario: Scenario, motion: Trajectory, exact: Trajectory) -> ErrorSeries:
    """Errors of `motion` at its own sample times, which must be those of `exact`.

    Raises
    ------
    ValueError
        If the two are not sampled at the same times: nothing is interpolated.
    """
    if not np.array_equal(motion.t, exact.t):
        raise ValueError("'motion' and 'exact' must be sampled at the same times.")
    norm = _norm_of(scenario, exact)
    return ErrorSeries(*norm.distances(norm.table(motion), norm.true_table).T)


def errors_between(scenario: Scenario, motion: Trajectory, exact: Trajectory) -> Errors:
    """The errors of `motion` against `exact`, the largest of each signal."""
    return error_series(scenario, motion, exact).worst()


@lru_cache(maxsize=RECENT)
def _norm_of(scenario: Scenario, exact: Trajectory) -> ErrorNorm:
    return ErrorNorm(scenario, exact)


def _table(scenario: Scenario, motion: Trajectory, exact: Trajectory) -> FloatArray:
    q = _normalised(motion.q_world_body_wxyz)
    same_side = np.einsum("ni,ni->n", q, exact.q_world_body_wxyz) >= 0
    return np.column_stack(
        [
            motion.omega_body,
            np.where(same_side[:, None], q, -q),
            angular_momentum_world(scenario, motion),
            energy(scenario, motion),
            motion.com_world,
            motion.velocity_world,
        ]
    )


def _normalised(q_wxyz: FloatArray) -> FloatArray:
    norms = np.sqrt(np.einsum("ni,ni->n", q_wxyz, q_wxyz))
    return np.asarray(q_wxyz / norms[:, None])


def _longest(vectors: FloatArray) -> float:
    return float(np.sqrt(np.einsum("ni,ni->n", vectors, vectors).max()))
