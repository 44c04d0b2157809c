"""How far one motion is from another: the four errors, each relative to a base of the truth."""

from collections.abc import Iterator
from dataclasses import dataclass, fields

import numpy as np

from .body import FloatArray
from .mechanics import angular_momentum_world, energy, energy_base
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
    """

    omega: float
    attitude: float
    angular_momentum: float
    energy: float

    def __iter__(self) -> Iterator[tuple[str, float]]:
        return iter((field.name, getattr(self, field.name)) for field in fields(self))


@dataclass(frozen=True, eq=False)
class ErrorSeries:
    """The same four, sample by sample, each (n,)."""

    omega: FloatArray
    attitude: FloatArray
    angular_momentum: FloatArray
    energy: FloatArray

    def worst(self) -> Errors:
        """The largest of each over the samples."""
        return Errors(*(float(getattr(self, field.name).max()) for field in fields(self)))


def error_series(scenario: Scenario, motion: Trajectory, truth: Trajectory) -> ErrorSeries:
    """Errors of `motion` at its own sample times, which must be those of `truth`.

    Raises
    ------
    ValueError
        If the two are not sampled at the same times: nothing is interpolated.
    """
    if not np.array_equal(motion.t, truth.t):
        raise ValueError("'motion' and 'truth' must be sampled at the same times.")
    L = angular_momentum_world(scenario, motion)
    L_true = angular_momentum_world(scenario, truth)
    energies = energy(scenario, motion) - energy(scenario, truth)
    return ErrorSeries(
        omega=_relative(_norms(motion.omega_body - truth.omega_body), _norms(truth.omega_body)),
        attitude=np.asarray((motion.R_world_body.inv() * truth.R_world_body).magnitude()),
        angular_momentum=_relative(_norms(L - L_true), _norms(L_true)),
        energy=_relative(np.abs(energies), np.array([energy_base(scenario, truth)])),
    )


def errors_between(scenario: Scenario, motion: Trajectory, truth: Trajectory) -> Errors:
    """The four errors of `motion` against `truth`."""
    return error_series(scenario, motion, truth).worst()


def _norms(vectors: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.norm(vectors, axis=1))


def _relative(differences: FloatArray, bases: FloatArray) -> FloatArray:
    """Differences over the largest base; over a base of zero, 0 where equal and inf elsewhere."""
    base = float(bases.max())
    if base > 0:
        return differences / base
    return np.where(differences == 0, 0.0, np.inf)
