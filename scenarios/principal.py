"""The principal axes of an inertia tensor, in extended precision."""

from functools import lru_cache

from mpmath import mp, mpf

from .exact import DIGITS, Quaternion, Tensor, Vector, cross, dot

#: Relative tolerance of equal numbers. Tensors are computed from doubles with DIGITS digits, so
#: that results which agree to this tolerance differ only by rounding: different doubles differ by
#: far more.
EQUAL_TO_WORKING_PRECISION = mpf(10) ** (10 - DIGITS)

#: Number of tensors whose axes are kept.
KEPT = 64
ONE, NONE = mpf(1), mpf(0)
IDENTITY: Tensor = ((ONE, NONE, NONE), (NONE, ONE, NONE), (NONE, NONE, ONE))


@lru_cache(maxsize=KEPT)
def principal_axes(tensor: Tensor) -> tuple[Vector, Tensor]:
    """Return the principal moments of an inertia tensor, and right-handed principal axes.

    A tensor that is diagonal keeps its axes and the order of its moments, so that bodies given by
    principal moments are not rotated at all. Moments of any other tensor are in ascending order,
    and made exactly equal where they differ only by rounding.

    Returns
    -------
    moments : kg m², in the order of the axes
    R_body_axes : takes components along the principal axes to body components; its columns are
        the axes
    """
    if not any(tensor[i][j] for i in range(3) for j in range(3) if i != j):
        return (tensor[0][0], tensor[1][1], tensor[2][2]), IDENTITY
    with mp.workdps(DIGITS):
        moments, columns = mp.eigsy(mp.matrix(tensor))
        x, y, z = (tuple(columns[i, k] for i in range(3)) for k in range(3))
        if dot(cross(x, y), z) < 0:
            z = (-z[0], -z[1], -z[2])
        first, second, third = zip(x, y, z, strict=True)
        return _merged(moments[0], moments[1], moments[2]), (first, second, third)


def _merged(low: mpf, middle: mpf, high: mpf) -> Vector:
    """Return ascending moments, made equal where they differ only by the eigenvalues' rounding."""
    if middle - low <= EQUAL_TO_WORKING_PRECISION * middle:
        middle = low
    if high - middle <= EQUAL_TO_WORKING_PRECISION * high:
        high = middle
    return (low, middle, high)


def from_matrix(R: Tensor) -> Quaternion:
    """Return the unit quaternion of a rotation matrix, in extended precision.

    It is the column of 4 q qᵀ with the largest diagonal entry, normalised, which loses no digits
    (Shepperd, J. Guidance and Control 1 (1978) 223).
    """
    trace = R[0][0] + R[1][1] + R[2][2]
    diagonal = [1 + trace, *(1 + 2 * R[k][k] - trace for k in range(3))]
    w = [diagonal[0], R[2][1] - R[1][2], R[0][2] - R[2][0], R[1][0] - R[0][1]]
    x = [w[1], diagonal[1], R[0][1] + R[1][0], R[0][2] + R[2][0]]
    y = [w[2], x[2], diagonal[2], R[1][2] + R[2][1]]
    z = [w[3], x[3], y[3], diagonal[3]]
    best = max(range(4), key=lambda k: diagonal[k])
    column = (w, x, y, z)[best]
    norm = 2 * mp.sqrt(diagonal[best])
    return (column[0] / norm, column[1] / norm, column[2] / norm, column[3] / norm)
