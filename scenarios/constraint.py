"""What holds a body: a point of it that keeps its place along some of the world's axes."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .exact import ZERO, Vector
from .float_array import FloatArray, read_only


@dataclass(frozen=True, eq=False)
class Constraint:
    """A point of the body that keeps its place, by a force that does no work.

    Attributes
    ----------
    is_held : along which of the world's axes; along none of them the body is free
    lever_exact : from that point to the centre of mass, m, body axes; of a free body, from its
        origin
    place_exact : of the point, m, world axes; not looked at along the others
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
        """Whether nothing is held."""
        return not any(self.is_held)

    @cached_property
    def lever(self) -> FloatArray:
        """Vector from that point to the centre of mass, m, body axes, (3,)."""
        return read_only(self.lever_exact)

    def com_world(self, lever_world: FloatArray, flown_world: FloatArray) -> FloatArray:
        """Where attitudes put the centre of mass, m, (n, 3) or (3,).

        Parameters
        ----------
        lever_world : m, the lever at these attitudes
        flown_world : m, the place along axes that are not held
        """
        place_world = np.array(self.place_exact, dtype=float)
        return np.where(self.is_held, place_world + lever_world, flown_world)

    def velocity_world(self, swing_world: FloatArray, flown_world: FloatArray) -> FloatArray:
        """The velocity of the centre of mass, m/s, (n, 3) or (3,).

        Parameters
        ----------
        swing_world : m/s, ω × lever
        flown_world : m/s, the velocity along axes that are not held
        """
        return np.where(self.is_held, swing_world, flown_world)
