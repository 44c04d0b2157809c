"""Differences of two bodies: mass, com, tensor, and the angle between principal axes."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from ...scenarios import FloatArray
from ...scenarios.users_models import Stated
from ..checks.read_back import BodyReading

#: Relative tolerance within which an engine holds the file's link. Some engines diagonalise tensors
#: with errors of 1e-12 to 1e-6: with a tolerance of 1e-12 a third of all links would be wrong.
AGREES = 1e-5
#: Half turns about each axis: principal axes have no sign.
_SIGNS = [np.diag(signs) for signs in ((1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1))]


@dataclass(frozen=True)
class BodyDifference:
    """How far an engine's body is from the file's.

    Attributes
    ----------
    mass : relative
    com : distance, relative to the file's radius of gyration or |com|, whichever is larger
    inertia : norm of the difference of the tensors about the com, relative to the file's
    axes_deg : the smallest rotation between the principal axes; 0 if both have three equal moments
    """

    mass: float
    com: float
    inertia: float
    axes_deg: float

    @property
    def worst(self) -> float:
        """The largest of the three that are judged."""
        return max(self.mass, self.com, self.inertia)


def difference(stated: Stated, got: BodyReading) -> BodyDifference:
    """The difference of the body that an engine holds from the one that a file states."""
    size = float(np.linalg.norm(stated.inertia))
    gyration = np.sqrt(abs(np.trace(stated.inertia)) / (2 * stated.mass)) if stated.mass else 0.0
    arm = max(float(gyration), float(np.linalg.norm(stated.com)))
    return BodyDifference(
        mass=_relative(abs(got.mass - stated.mass), abs(stated.mass)),
        com=_relative(float(np.linalg.norm(got.com - stated.com)), arm),
        inertia=_relative(float(np.linalg.norm(got.inertia_com - stated.inertia)), size),
        axes_deg=float(np.degrees(angle_between_axes(stated.inertia, got.inertia_com))),
    )


def moments_alike(one: FloatArray, other: FloatArray) -> bool:
    """Whether two tensors have the same principal moments."""
    low, high = np.linalg.eigvalsh(one), np.linalg.eigvalsh(other)
    return bool(np.abs(low - high).max() <= AGREES * np.abs(low).max())


def angle_between_axes(one: FloatArray, other: FloatArray) -> float:
    """The least rotation between the principal axes of two tensors, rad.

    Axes go by the order of their moments, and turn freely where moments are alike.
    """
    (moments, axes), (other_moments, other_axes) = np.linalg.eigh(one), np.linalg.eigh(other)
    alike = [_equal_pairs(moments), _equal_pairs(other_moments)]
    free = alike[0] | alike[1]
    if free == {0, 1}:
        return 0.0
    if free:
        # Only one axis is determined; the other two may turn about it.
        lone = 2 if free == {0} else 0
        cosine = abs(axes[:, lone] @ other_axes[:, lone])
        sine = np.linalg.norm(np.cross(axes[:, lone], other_axes[:, lone]))
        return float(np.arctan2(sine, cosine))
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    other_axes[:, 2] *= np.sign(np.linalg.det(other_axes))
    turns = [other_axes @ sign @ axes.T for sign in _SIGNS]
    return float(min(Rotation.from_matrix(turn).magnitude() for turn in turns))


def _equal_pairs(moments: FloatArray) -> set[int]:
    """Which of the pairs (0, 1) and (1, 2) of ascending moments are alike."""
    gaps = np.diff(moments)
    return {k for k in (0, 1) if gaps[k] <= AGREES * np.abs(moments).max()}


def _relative(value: float, size: float) -> float:
    if size:
        return value / size
    return 0.0 if value == 0 else float("inf")
