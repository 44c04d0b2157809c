"""How one signal of a ladder approaches the truth, measured as rungs are added.

Whatever takes the length of a motion is worked out once, when its rung comes; a judgement then
costs a few numbers a rung.
"""

from abc import ABC, abstractmethod
from typing import final

import numpy as np
from scipy.spatial.transform import Rotation

from ...scenarios import FloatArray, Trajectory
from ..results.records import Signal

EPS = float(np.finfo(float).eps)


class RichardsonSequence:
    """A ladder in one signal, coarse to fine, each rung half the one before.

    Attributes
    ----------
    timesteps, errors, roundoff_bounds : s, distance from the exact motion, and what rounding may
        do; one a rung
    limit_distances : (n,) distance from the truth of each limit that two neighbours extrapolate to,
        sample by sample; one for each rung after the first
    limit_increments : distance of each such limit from the one before; one for each rung after
        the second
    """

    def __init__(
        self, signal: Signal, truth: Trajectory, declared_order: int, uncertainty: float
    ) -> None:
        self.signal = signal
        self.truth = truth
        self.declared_order = declared_order
        self.uncertainty = uncertainty
        self.timesteps: list[float] = []
        self.errors: list[float] = []
        self.roundoff_bounds: list[float] = []
        self.limit_distances: list[FloatArray] = []
        self.limit_increments: list[float] = []
        self._measure = _MEASURES[signal]
        self._true = self._measure.values(truth)
        self._finest: FloatArray | None = None
        self._limit: FloatArray | None = None

    def __len__(self) -> int:
        return len(self.errors)

    def add(self, timestep: float, motion: Trajectory, floor: float) -> None:
        """Take the next rung: its timestep, s, motion, and the error rounding may have caused."""
        measure, values = self._measure, self._measure.values(motion)
        self.timesteps.append(timestep)
        self.errors.append(float(measure.off(values, self._true).max()))
        self.roundoff_bounds.append(floor)
        if self._finest is not None:
            limit = measure.limit(self._finest, values, 1.0 / (2**self.declared_order - 1))
            self.limit_distances.append(measure.off(limit, self._true))
            if self._limit is not None:
                self.limit_increments.append(float(measure.off(self._limit, limit).max()))
            self._limit = limit
        self._finest = values


def com_growth(truth: Trajectory, arm: float, attitude_growth: float) -> float:
    """What one ulp in each number of a state does to the com, relative to the longest way it goes.

    Parameters
    ----------
    arm : m, from the body's origin, where an engine may keep the position, to the com
    attitude_growth : rad, what one ulp does to the attitude
    """
    times = truth.t[-1] - truth.t[0]
    far = np.linalg.norm(truth.com_world, axis=1).max()
    fast = np.linalg.norm(truth.velocity_world, axis=1).max()
    return float(EPS * (far + fast * times) + attitude_growth * arm) / longest_way(truth)


def longest_way(truth: Trajectory) -> float:
    """Of the com from where it starts, m."""
    return float(np.linalg.norm(truth.com_world - truth.com_world[0], axis=1).max())


class _Measure(ABC):
    """How motions are compared in one signal, by arrays of a row a sample."""

    @abstractmethod
    def values(self, motion: Trajectory) -> FloatArray:
        """The signal itself."""

    @abstractmethod
    def off(self, values: FloatArray, truth: FloatArray) -> FloatArray:
        """Distance from one to the other, (n,), as the errors of runs have it."""

    @abstractmethod
    def limit(self, coarse: FloatArray, fine: FloatArray, weight: float) -> FloatArray:
        """Richardson's limit of dt and dt / 2 (Hairer, Nørsett & Wanner I, §II.4).

        Parameters
        ----------
        weight : 1 / (2^p - 1), of the way from coarse to fine, that is left to go
        """


@final
class _Omega(_Measure):
    """Vectors, relative to the largest of the truth's."""

    def values(self, motion: Trajectory) -> FloatArray:
        return motion.omega_body

    def off(self, values: FloatArray, truth: FloatArray) -> FloatArray:
        base = np.linalg.norm(truth, axis=1).max()
        distance = np.asarray(np.linalg.norm(values - truth, axis=1))
        return distance / base if base else (distance > 0).astype(float)

    def limit(self, coarse: FloatArray, fine: FloatArray, weight: float) -> FloatArray:
        return np.asarray(fine + weight * (fine - coarse), dtype=float)


@final
class _Attitude(_Measure):
    """Unit quaternions, scalar first; limits lie along the rotation from the coarse to the fine."""

    def values(self, motion: Trajectory) -> FloatArray:
        return motion.q_world_body_wxyz

    def off(self, values: FloatArray, truth: FloatArray) -> FloatArray:
        return np.asarray((_rotations(values).inv() * _rotations(truth)).magnitude())

    def limit(self, coarse: FloatArray, fine: FloatArray, weight: float) -> FloatArray:
        R_world_fine = _rotations(fine)
        turn = (_rotations(coarse).inv() * R_world_fine).as_rotvec()
        limit = R_world_fine * Rotation.from_rotvec(weight * turn)
        return np.asarray(limit.as_quat(scalar_first=True))


@final
class _Com(_Measure):
    """Positions, relative to the longest way of the truth's from its start."""

    def values(self, motion: Trajectory) -> FloatArray:
        return motion.com_world

    def off(self, values: FloatArray, truth: FloatArray) -> FloatArray:
        way = np.linalg.norm(truth - truth[0], axis=1).max()
        return np.asarray(np.linalg.norm(values - truth, axis=1) / way)

    def limit(self, coarse: FloatArray, fine: FloatArray, weight: float) -> FloatArray:
        return np.asarray(fine + weight * (fine - coarse), dtype=float)


def _rotations(q_world_body_wxyz: FloatArray) -> Rotation:
    return Rotation.from_quat(q_world_body_wxyz, scalar_first=True)


_MEASURES: dict[Signal, _Measure] = {"omega": _Omega(), "attitude": _Attitude(), "com": _Com()}
