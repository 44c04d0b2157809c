"""Derivatives of steps that engines compute, in the coordinates that the reference uses.

Rows and columns are a turn of the attitude, δR = R [δθ]×, rad, then ω, rad/s, both in body axes:
docs/explanation/sensitivities.md calls these coordinates the chart.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..scenarios import FloatArray

#: Number of components of a quaternion, and of the chart of attitude and ω.
QUATERNION, CHART = 4, 6


@dataclass(frozen=True)
class Derivative:
    """One of an engine's own derivatives, at the state that a session is in.

    Attributes
    ----------
    compute : returns the derivative of the next step, (6, 6), or of dω/dt, (3, 6), and leaves the
        state unchanged; raises `EngineError` if the engine refuses
    through : returns the derivative of a given number of steps at once, (6, 6), as a tape does;
        None if users of the engine multiply the derivatives of single steps
    epsilon : change of a number in finite differences, rad and rad/s; 0 if the derivative is exact
    """

    compute: Callable[[], FloatArray]
    epsilon: float = 0.0
    through: Callable[[int], FloatArray] | None = None


def numbers_by_chart(q_wxyz: FloatArray) -> FloatArray:
    """Return the derivative of a quaternion, w x y z, and ω, body axes, by the chart, (7, 6).

    δq is q (0, δθ/2).
    """
    by_chart = np.zeros((QUATERNION + 3, CHART))
    by_chart[:QUATERNION, :3] = _product_matrix(q_wxyz) / 2
    by_chart[QUATERNION:, 3:] = np.eye(3)
    return by_chart


def in_chart(q_wxyz: FloatArray, numbers: FloatArray) -> FloatArray:
    """Return derivatives of turn and ω, (6, n), given those of a quaternion and ω, (7, n).

    δθ is twice the vector part of q̄ δq. A change of the quaternion's norm alone gives δθ = 0.
    """
    turn = 2 * _product_matrix(q_wxyz).T @ numbers[:QUATERNION] / (q_wxyz @ q_wxyz)
    return np.vstack([turn, numbers[QUATERNION:]])


def along(R: FloatArray, derivative: FloatArray) -> FloatArray:
    """Return a derivative along axes b, (3 n, 3 m), given along axes a.

    Every three rows, and every three columns, are the components of one vector.

    Parameters
    ----------
    R : the matrix that takes components along axes a to components along axes b, (3, 3)
    """
    rows, columns = (np.kron(np.eye(n // 3), R) for n in derivative.shape)
    return np.asarray(rows @ derivative @ columns.T)


def _product_matrix(q_wxyz: FloatArray) -> FloatArray:
    """Return the matrix M with q (0, v) = M v for a quaternion q and any vector v, (4, 3)."""
    w, x, y, z = q_wxyz
    return np.array([[-x, -y, -z], [w, -z, y], [z, w, -x], [-y, x, w]])
