"""A rigid body: mass, centre of mass and inertia tensor, exact and as doubles."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from mpmath import mp, mpf

from .exact import DIGITS, ZERO, Tensor, Vector, add, exact, steiner, vector
from .float_array import FloatArray, read_only

#: Relative slack of the triangle inequality: decimals such as 0.1 + 0.2 ≥ 0.3 must pass it after
#: rounding to double.
TRIANGLE_SLACK = 4 * np.finfo(float).eps
#: Number of tensors whose principal moments are kept.
KEPT = 64


@dataclass(frozen=True, eq=False)
class Body:
    """A rigid body in its own frame; its numbers are checked when it is made.

    Attributes
    ----------
    mass_exact : mass, kg
    com_exact : centre of mass from the body's origin, m, body axes
    inertia_com_exact : inertia tensor about the centre of mass, kg m², body axes

    Raises
    ------
    ValueError
        If the mass or a moment is not positive, a moment exceeds the sum of the others, or the
        tensor about the origin leaves the range of doubles.
    """

    mass_exact: mpf
    com_exact: Vector
    inertia_com_exact: Tensor

    def __post_init__(self) -> None:
        if not np.isfinite(self.inertia_origin).all():
            raise ValueError("mass, com and inertia are too large: the tensor overflows")
        moments = self.principal_moments
        if moments[0] <= 0 or not self.mass_exact > 0:
            raise ValueError(
                f"principal moments about the com must be positive, got {_triple(moments)} kg m²"
            )
        # Halved before adding, so that the sum of two of the largest doubles does not overflow.
        if moments[2] / 2 > (moments[0] / 2 + moments[1] / 2) * (1 + TRIANGLE_SLACK):
            raise ValueError(
                "no principal moment about the com may exceed the sum of the other two, "
                f"got {_triple(moments)} kg m²"
            )

    @property
    def mass(self) -> float:
        """Mass, kg."""
        return float(self.mass_exact)

    @cached_property
    def com(self) -> FloatArray:
        """Centre of mass from the body's origin, m, body axes, (3,)."""
        return read_only(self.com_exact)

    @cached_property
    def inertia_com(self) -> FloatArray:
        """Inertia tensor about the centre of mass, kg m², body axes, (3, 3)."""
        return read_only(self.inertia_com_exact)

    @cached_property
    def inertia_origin_exact(self) -> Tensor:
        """Inertia tensor about the body's origin, kg m², body axes (parallel-axis theorem)."""
        return add(self.inertia_com_exact, steiner(self.mass_exact, self.com_exact))

    @cached_property
    def inertia_origin(self) -> FloatArray:
        """Inertia tensor about the body's origin, kg m², body axes, (3, 3)."""
        return read_only(self.inertia_origin_exact)

    @cached_property
    def principal_moments(self) -> FloatArray:
        """Principal moments about the centre of mass, ascending, kg m², (3,)."""
        return _ascending(self.inertia_com_exact)


@lru_cache(maxsize=KEPT)
def _ascending(tensor: Tensor) -> FloatArray:
    """Return the principal moments of a tensor, ascending, kg m², (3,).

    They are cached, because bodies that differ only in their com have the same tensor.
    """
    with mp.workdps(DIGITS):
        if all(tensor[i][j] == 0 for i in range(3) for j in range(3) if i != j):
            moments = sorted(tensor[i][i] for i in range(3))
        else:
            moments = sorted(mp.eigsy(mp.matrix(tensor), eigvals_only=True))
    return read_only(moments)


def body_about_com(mass: float, com: Sequence[float], inertia: Sequence[Sequence[float]]) -> Body:
    """Return a body whose inertia tensor is given about its centre of mass.

    Parameters
    ----------
    mass : kg
    com : from the body's origin, m, body axes, (3,)
    inertia : kg m², body axes, (3, 3)

    Raises
    ------
    ValueError
        If no such body exists: its mass or a moment is not positive, or a moment exceeds the sum
        of the others.
    """
    return Body(mpf(mass), vector(com), _tensor(inertia))


def body_about_origin(
    mass: float, com: Sequence[float], inertia: Sequence[Sequence[float]]
) -> Body:
    """Return a body whose inertia tensor is given about its own origin.

    Parameters
    ----------
    mass : kg
    com : from the body's origin, m, body axes, (3,)
    inertia : about the body's origin, kg m², body axes, (3, 3)

    Raises
    ------
    ValueError
        If no such body exists: its mass or a moment is not positive, or a moment exceeds the sum
        of the others.
    """
    arm = vector(com)
    return Body(mpf(mass), arm, add(_tensor(inertia), steiner(mpf(mass), arm), sign=-1))


def body_of_particles(particles: Sequence[Sequence[float]]) -> Body:
    """Return the rigid body of point masses, given as rows of mass, kg, and x, y, z, m.

    I_jk = Σ m (r² δ_jk − r_j r_k), summed in extended precision (Goldstein, Classical Mechanics,
    §5.3). ValueError is raised if no such body exists, for example for particles on one line.
    """
    with mp.workdps(DIGITS):
        rows = [exact(row) for row in particles]
        mass = mp.fsum(row[0] for row in rows)
        com = tuple(mp.fsum(row[0] * row[1 + k] for row in rows) / mass for k in range(3))
        inertia: Tensor = (ZERO, ZERO, ZERO)
        for m, *position in rows:
            arm = tuple(position[k] - com[k] for k in range(3))
            inertia = add(inertia, steiner(m, arm))
    return Body(mass, com, inertia)


def _tensor(rows: Sequence[Sequence[float]]) -> Tensor:
    """Return the rows of a tensor in extended precision, without rounding."""
    first, second, third = (vector(row) for row in rows)
    return (first, second, third)


def _triple(moments: FloatArray) -> str:
    return ", ".join(f"{moment:.6g}" for moment in moments)
