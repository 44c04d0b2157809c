"""What holds a body: a point of it that keeps its place along some of the world's axes."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .exact import ZERO, Vector
from .float_array import FloatArray, read_only


@dataclass(frozen=True, eq=False)
class Constraint:
    """A point of the body that keeps its place, held by a force that does no work.

    Attributes
    ----------
    is_held : for each axis of the world, whether the point is held along it; a free body is held
        along none
    lever_exact : vector to the centre of mass from the point, or from the origin of a free body, m,
        body axes
    place_exact : place of the point, m, world axes; only the axes along which it is held count
    """

    is_held: tuple[bool, bool, bool]
    lever_exact: Vector
    place_exact: Vector = ZERO

    @property
    def is_pivot(self) -> bool:
        """Whether the point is fixed, so that the body turns about it."""
        return all(self.is_held)

    @property
    def is_free(self) -> bool:
        """Whether the body is free: no point of it is held along any axis."""
        return not any(self.is_held)

    @cached_property
    def lever(self) -> FloatArray:
        """Vector to the com from the point, or from a free body's origin, m, body axes, (3,)."""
        return read_only(self.lever_exact)

    def com_world(self, lever_world: FloatArray, flown_world: FloatArray) -> FloatArray:
        """Return the position of the centre of mass at n attitudes, m, (n, 3), or at one, (3,).

        Parameters
        ----------
        lever_world : vector from the held point to the centre of mass at these attitudes, m, world
            axes; not used for a free body
        flown_world : position of the centre of mass in free flight, m, which is returned along axes
            that are not held
        """
        place_world = np.array(self.place_exact, dtype=float)
        return np.where(self.is_held, place_world + lever_world, flown_world)

    def velocity_world(self, swing_world: FloatArray, flown_world: FloatArray) -> FloatArray:
        """Return the velocity of the centre of mass in n states, m/s, (n, 3), or in one, (3,).

        Parameters
        ----------
        swing_world : ω × r in these states, with r the vector from the held point to the centre of
            mass, m/s, world axes
        flown_world : velocity of the centre of mass in free flight, m/s, which is returned along
            axes that are not held
        """
        return np.where(self.is_held, swing_world, flown_world)
