"""The principal axes of an inertia tensor, in extended precision."""

from collections.abc import Sequence

from mpmath import mp, mpf

from .exact import DIGITS, Quaternion, Tensor, Vector, conjugate, cross, dot

IDENTITY: Quaternion = (mpf(1), mpf(0), mpf(0), mpf(0))


def principal_axes(tensor: Tensor) -> tuple[Vector, Quaternion]:
    """Principal moments and the rotation from body to principal components.

    A tensor that is diagonal keeps its axes and the order of its moments, so that bodies given by
    principal moments are not rotated at all, and equal moments stay exactly equal.

    Returns
    -------
    moments : kg m², in the order of the axes
    q_axes_body : unit quaternion w, x, y, z: body components to principal components
    """
    off_diagonal = [tensor[i][j] for i in range(3) for j in range(3) if i != j]
    if not any(off_diagonal):
        return (tensor[0][0], tensor[1][1], tensor[2][2]), IDENTITY
    with mp.workdps(DIGITS):
        moments, columns = mp.eigsy(mp.matrix(tensor))
        first, second, third = (tuple(columns[i, k] for i in range(3)) for k in range(3))
        if dot(cross(first, second), third) < 0:
            third = (-third[0], -third[1], -third[2])
        R_body_axes = [[axis[i] for axis in (first, second, third)] for i in range(3)]
        q_body_axes = from_matrix(R_body_axes)
    return (moments[0], moments[1], moments[2]), conjugate(q_body_axes)


def from_matrix(R: Sequence[Sequence[mpf]]) -> Quaternion:
    """Unit quaternion of a rotation matrix, through its largest component.

    The four candidates are the columns of 4 q qᵀ; the one with the largest diagonal loses no
    digits (Shepperd, J. Guidance and Control 1 (1978) 223).
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
