"""Rotations of many vectors at once, by quaternions that may be NaN: scipy's refuse those."""

import numpy as np

from ..scenarios import FloatArray


def rotated(q_wxyz: FloatArray, vectors: FloatArray) -> FloatArray:
    """Vectors turned by unit quaternions.

    q v q* multiplied out for q = (w, u), w² + u² = 1: v + 2 w (u × v) + 2 u × (u × v).

    Parameters
    ----------
    q_wxyz, vectors : (n, 4) and (n, 3); either may be of one row, for all rows of the other
    """
    w, u = q_wxyz[:, :1], q_wxyz[:, 1:]
    twice = 2.0 * np.cross(u, vectors)
    return np.asarray(vectors + w * twice + np.cross(u, twice))


def product(p_wxyz: FloatArray, q_wxyz: FloatArray) -> FloatArray:
    """Hamilton products p q, row by row, (n, 4); either factor may be of one row."""
    pw, pu = p_wxyz[:, :1], p_wxyz[:, 1:]
    qw, qu = q_wxyz[:, :1], q_wxyz[:, 1:]
    scalar = pw * qw - (pu * qu).sum(axis=1, keepdims=True)
    vector = pw * qu + qw * pu + np.cross(pu, qu)
    return np.hstack([scalar, vector])


def conjugate(q_wxyz: FloatArray) -> FloatArray:
    """Inverses of unit quaternions, (n, 4)."""
    return np.asarray(q_wxyz * np.array([1.0, -1.0, -1.0, -1.0]))
