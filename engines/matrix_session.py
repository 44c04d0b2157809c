"""A scene in an engine that tells attitudes as matrices."""

from abc import abstractmethod
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from ..scenarios import FloatArray
from .checks.read_back import EngineError, State
from .session import Session


class MatrixReading(NamedTuple):
    """A state as such an engine tells it: rad/s, m and m/s.

    Attributes
    ----------
    R_world_body : (3, 3)
    omega_body, com_world, velocity_world : (3,)
    """

    R_world_body: FloatArray
    omega_body: FloatArray
    com_world: FloatArray
    velocity_world: FloatArray


class MatrixSession(Session):
    """Its matrices become quaternions many at a time: one by one that takes as long as steps do."""

    @abstractmethod
    def read_matrix(self) -> MatrixReading:
        """The state now."""

    def snapshot(self) -> MatrixReading:
        """The state now, of an engine without trouble."""
        self.check()
        reading = self.read_matrix()
        if not (np.isfinite(reading.R_world_body).all() and np.isfinite(reading.omega_body).all()):
            raise EngineError("the state is no longer finite", "not-finite")
        return reading

    def read_state(self) -> State:
        """The state now."""
        return self.states([self.snapshot()]).rows(0)

    def states(self, snapshots: Sequence[MatrixReading]) -> State:
        """The states of n snapshots, one a row of each column."""
        matrices, *columns = map(np.array, zip(*snapshots, strict=True))
        return State(Rotation.from_matrix(matrices).as_quat(scalar_first=True), *columns)
