"""A motion, sampled at increasing times."""

from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .float_array import FloatArray, read_only
from .rotation import matrices, turned

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation


@dataclass(frozen=True, eq=False)
class Trajectory:
    """States of a rigid body at n increasing times; its arrays are read-only copies.

    Attributes
    ----------
    t : (n,) s, increasing
    q_world_body_wxyz : (n, 4) unit quaternions, scalar first: body to world components
    omega_body : (n, 3) rad/s, body axes
    com_world : (n, 3) m, position of the centre of mass
    velocity_world : (n, 3) m/s, velocity of the centre of mass
    spins : (n, rotors) rad/s, spins of rotors relative to the body; (n, 0) by default

    Raises
    ------
    ValueError
        If shapes disagree, times do not increase, a value is not finite, or a quaternion is not
        of unit norm.
    """

    t: FloatArray
    q_world_body_wxyz: FloatArray
    omega_body: FloatArray
    com_world: FloatArray
    velocity_world: FloatArray
    spins: FloatArray = field(default_factory=lambda: np.empty(0))

    #: Tolerance of a quaternion's norm: engines normalise to a few ulp at best, single-precision
    #: ones to 1e-7.
    UNIT_NORM_SLACK = 1e-6

    def __post_init__(self) -> None:
        for one in fields(self):
            object.__setattr__(self, one.name, read_only(getattr(self, one.name)))
        if self.t.ndim != 1:
            raise ValueError(f"'t' must have one dimension, got {self.t.ndim}.")
        n = len(self.t)
        if not self.spins.size:
            object.__setattr__(self, "spins", read_only(np.empty((n, 0))))
        if self.spins.shape[:-1] != (n,):
            raise ValueError(f"'spins' must have shape ({n}, parts), got {self.spins.shape}.")
        for name, width in _WIDTHS.items():
            shape = getattr(self, name).shape
            if shape != (n, width):
                raise ValueError(f"'{name}' must have shape ({n}, {width}), got {shape}.")
        if not all(np.isfinite(getattr(self, one.name)).all() for one in fields(self)):
            raise ValueError("a trajectory must be finite throughout.")
        if n and not (np.diff(self.t) > 0).all():
            raise ValueError("'t' must increase.")
        norms = np.linalg.norm(self.q_world_body_wxyz, axis=1)
        if n and np.abs(norms - 1).max() > self.UNIT_NORM_SLACK:
            raise ValueError("'q_world_body_wxyz' must have unit norm.")

    def __reduce__(self) -> tuple[type["Trajectory"], tuple[FloatArray, ...]]:
        """Pickle by the constructor, because arrays that NumPy unpickles itself are writable."""
        return Trajectory, tuple(getattr(self, one.name) for one in fields(self))

    @property
    def R_world_body(self) -> "Rotation":
        """The n attitudes as one scipy `Rotation`, body to world."""
        # Imported here, because scipy's import takes as long as all of spincheck's own modules.
        from scipy.spatial.transform import Rotation

        return Rotation.from_quat(self.q_world_body_wxyz, scalar_first=True)

    def to_world(self, vectors_body: FloatArray) -> FloatArray:
        """Return the world components, (n, 3), of vectors given in body components at each sample.

        One vector, (3,), may stand for n equal ones.
        """
        rows = np.broadcast_to(vectors_body, (len(self.t), 3))
        return turned(self._world_from_body, rows)

    @cached_property
    def _world_from_body(self) -> FloatArray:
        """The rotation matrices of the n attitudes, body to world components, (n, 3, 3)."""
        q = self.q_world_body_wxyz
        return matrices(q / np.linalg.norm(q, axis=1, keepdims=True))

    def until(self, n: int) -> "Trajectory":
        """Return the trajectory of the first n samples; itself if it has no more than n."""
        if n >= len(self.t):
            return self
        return Trajectory(**{one.name: getattr(self, one.name)[:n] for one in fields(self)})

    def every(self, n: int) -> "Trajectory":
        """Return the trajectory of the first sample and each n-th sample after it."""
        return Trajectory(**{one.name: getattr(self, one.name)[::n] for one in fields(self)})

    def at(self, samples: NDArray[np.intp]) -> "Trajectory":
        """Return the trajectory of k samples, given their indices, (k,), which must increase."""
        return Trajectory(**{f.name: getattr(self, f.name)[samples] for f in fields(self)})


_WIDTHS = {"q_world_body_wxyz": 4, "omega_body": 3, "com_world": 3, "velocity_world": 3}
