"""Rotations of many vectors at once, by quaternions that may be NaN, which scipy refuses."""

import numpy as np

from .float_array import FloatArray


def matrices(q_wxyz: FloatArray) -> FloatArray:
    """Return the rotation matrices of unit quaternions (Diebel 2006, Representing Attitude, §5.6).

    Parameters
    ----------
    q_wxyz : n unit quaternions, scalar first, (n, 4)

    Returns
    -------
    (n, 3, 3), taking components along the turned axes to those along the fixed ones
    """
    if len(q_wxyz) == 1:
        return matrix(q_wxyz[0])[None]
    w, x, y, z = q_wxyz.T
    R = np.empty((len(q_wxyz), 3, 3))
    R[:, 0, 0], R[:, 1, 1], R[:, 2, 2] = (
        1 - 2 * (y * y + z * z),
        1 - 2 * (x * x + z * z),
        1 - 2 * (x * x + y * y),
    )
    R[:, 0, 1], R[:, 1, 0] = 2 * (x * y - w * z), 2 * (x * y + w * z)
    R[:, 0, 2], R[:, 2, 0] = 2 * (x * z + w * y), 2 * (x * z - w * y)
    R[:, 1, 2], R[:, 2, 1] = 2 * (y * z - w * x), 2 * (y * z + w * x)
    return R


def matrix(q_wxyz: FloatArray) -> FloatArray:
    """Return the rotation matrix, (3, 3), of one unit quaternion, scalar first, (4,).

    It has the same bits as that of `matrices`, and takes a tenth of the time.
    """
    w, x, y, z = q_wxyz.tolist()
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def turned(R: FloatArray, vectors: FloatArray) -> FloatArray:
    """Return R v for n matrices R, (n, 3, 3), and n vectors v, (n, 3)."""
    return np.asarray(np.einsum("nij,nj->ni", R, vectors))


def turned_back(R: FloatArray, vectors: FloatArray) -> FloatArray:
    """Return Rᵀ v for n matrices R, (n, 3, 3), and n vectors v, (n, 3)."""
    return np.asarray(np.einsum("nji,nj->ni", R, vectors))


def norms(vectors: FloatArray) -> FloatArray:
    """Return the Euclidean norms of n vectors of k components, (n, k).

    It takes half the time of numpy's own function.
    """
    return np.asarray(np.sqrt(np.einsum("ij,ij->i", vectors, vectors)))


def conjugate(q_wxyz: FloatArray) -> FloatArray:
    """Return the quaternions of the inverse rotations, scalar first, (..., 4)."""
    return np.asarray(q_wxyz * [1.0, -1.0, -1.0, -1.0])


def times(q_wxyz: FloatArray) -> FloatArray:
    """Return the matrix M, (4, 4), of a quaternion q, with p M = p q for every quaternion p.

    In p M the quaternion p is a row. Scalars come first.
    """
    w, x, y, z = q_wxyz
    return np.array([[w, x, y, z], [-x, w, -z, y], [-y, z, w, -x], [-z, -y, x, w]])


def cross(u: FloatArray, v: FloatArray) -> FloatArray:
    """Return u × v for n pairs of rows, (n, 3), or for one pair of vectors, (3,).

    For few rows it is ten times as fast as numpy's own function.
    """
    if u.ndim == v.ndim == 1:
        (ux, uy, uz), (vx, vy, vz) = u.tolist(), v.tolist()
        return np.array([uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx])
    product = np.empty(np.broadcast_shapes(u.shape, v.shape))
    ux, uy, uz = u[..., 0], u[..., 1], u[..., 2]
    vx, vy, vz = v[..., 0], v[..., 1], v[..., 2]
    product[..., 0] = uy * vz - uz * vy
    product[..., 1] = uz * vx - ux * vz
    product[..., 2] = ux * vy - uy * vx
    return product


def across(v: FloatArray) -> FloatArray:
    """Return the matrix M, (3, 3), with u M = u × v for every vector u as a row."""
    x, y, z = v
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def rotation_vectors(q_from_wxyz: FloatArray, q_to_wxyz: FloatArray) -> FloatArray:
    """Return the rotation vectors from one attitude to another, body axes, rad, (n, 3).

    Parameters
    ----------
    q_from_wxyz, q_to_wxyz : n unit quaternions each, (n, 4); q and −q are one attitude
    """
    aw, ax, ay, az = q_from_wxyz.T
    bw, bx, by, bz = q_to_wxyz.T
    # The quaternion conj(a) b, with a = q_from and b = q_to.
    w = aw * bw + ax * bx + ay * by + az * bz
    v = np.empty((len(w), 3))
    v[:, 0] = aw * bx - bw * ax - (ay * bz - az * by)
    v[:, 1] = aw * by - bw * ay - (az * bx - ax * bz)
    v[:, 2] = aw * bz - bw * az - (ax * by - ay * bx)
    sine = norms(v)
    angle = 2 * np.arctan2(sine, np.abs(w))
    # For no rotation the vector is zero, whatever the factor is.
    return np.asarray(v * (np.copysign(angle, w) / np.where(sine == 0, 1, sine))[:, None])


def turning_of(q_wxyz: FloatArray, rates: FloatArray) -> FloatArray:
    """Return the angular velocity 2 q⁻¹ q' of given attitudes and rates, body axes, rad/s, (n, 3).

    Parameters
    ----------
    q_wxyz : n unit quaternions q, scalar first, (n, 4)
    rates : their derivatives q', 1/s, (n, 4)
    """
    w, v = q_wxyz[:, :1], q_wxyz[:, 1:]
    return np.asarray(2 * (w * rates[:, 1:] - rates[:, :1] * v - cross(v, rates[:, 1:])))
