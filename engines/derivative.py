"""Derivatives of steps that engines compute, in the coordinates that the reference uses: the chart.

Three rows and columns are for a small turn δθ of the attitude R, rad, with δR = R [δθ]×. Three are
for ω, rad/s. Both are in body axes (docs/explanation/sensitivities.md).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..scenarios import FloatArray

#: Number of components of a quaternion, and of the chart of attitude and ω.
QUATERNION, CHART = 4, 6


@dataclass(frozen=True)
class Derivative:
    """A derivative that an engine itself computes, at the present state of a session.

    Attributes
    ----------
    compute : returns the derivative of the next step, (6, 6), or of dω/dt, (3, 6), and leaves the
        state unchanged; raises `EngineError` if the engine refuses
    through : returns the derivative of the next n steps, (6, 6), given n: of all steps at once, as
        automatic differentiation can; None if users have to multiply derivatives of single steps
    epsilon : change of a coordinate in finite differences, rad or rad/s; 0 if the derivative is not
        by finite differences
    """

    compute: Callable[[], FloatArray]
    epsilon: float = 0.0
    through: Callable[[int], FloatArray] | None = None


def numbers_by_chart(q_wxyz: FloatArray) -> FloatArray:
    """Return the derivative of a quaternion and ω, seven numbers, by the chart, (7, 6).

    A turn δθ of the chart changes the quaternion q by δq = q (0, δθ/2), a product of quaternions.

    Parameters
    ----------
    q_wxyz : the attitude, a unit quaternion w x y z, (4,)
    """
    by_chart = np.zeros((QUATERNION + 3, CHART))
    by_chart[:QUATERNION, :3] = _product_matrix(q_wxyz) / 2
    by_chart[QUATERNION:, 3:] = np.eye(3)
    return by_chart


def in_chart(q_wxyz: FloatArray, numbers: FloatArray) -> FloatArray:
    """Return the derivatives of the chart's six numbers by n variables, (6, n).

    The turn δθ is twice the vector part of q̄ δq / |q|², with q the attitude. A change of the norm
    of q alone gives δθ = 0.

    Parameters
    ----------
    q_wxyz : the attitude, a quaternion w x y z of any norm, (4,)
    numbers : the derivatives of this quaternion and of ω, body axes, by the n variables, (7, n)
    """
    turn = 2 * _product_matrix(q_wxyz).T @ numbers[:QUATERNION] / (q_wxyz @ q_wxyz)
    return np.vstack([turn, numbers[QUATERNION:]])


def along(R: FloatArray, derivative: FloatArray) -> FloatArray:
    """Return a derivative of n vectors by m vectors, (3 n, 3 m), converted from axes a to axes b.

    Every three rows, and every three columns, are the components of one vector.

    Parameters
    ----------
    R : the matrix that takes components along axes a to components along axes b, (3, 3)
    derivative : the derivative in axes a, (3 n, 3 m)
    """
    rows, columns = (np.kron(np.eye(n // 3), R) for n in derivative.shape)
    return np.asarray(rows @ derivative @ columns.T)


def _product_matrix(q_wxyz: FloatArray) -> FloatArray:
    """Return the matrix M, (4, 3), of a quaternion q, with q (0, v) = M v for every vector v."""
    w, x, y, z = q_wxyz
    return np.array([[-x, -y, -z], [w, -z, y], [z, w, -x], [-y, x, w]])
