"""Derivatives that engines give of their steps, in the coordinates of the exact ones.

Rows and columns are a turn of the attitude, δR = R [δθ]×, rad, then ω, rad/s, both in body axes:
docs/explanation/sensitivities.md.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..scenarios import FloatArray

#: Numbers of a quaternion, and of the chart of the attitude and ω.
QUATERNION, CHART = 4, 6


@dataclass(frozen=True)
class Derivative:
    """One of an engine's own derivatives at the state that a session is in.

    Attributes
    ----------
    compute : returns it, (6, 6) of the next steps, or (3, 6) of dω/dt, and leaves the state as it
        is; raises `EngineError` if the engine refuses
    epsilon : the change of a number that differences are taken with, rad and rad/s; 0 of an exact
        derivative
    steps : how many steps it goes through
    """

    compute: Callable[[], FloatArray]
    epsilon: float = 0.0
    steps: int = 1


def numbers_by_chart(q_wxyz: FloatArray) -> FloatArray:
    """The derivative of a quaternion w x y z and ω in body axes by the chart, (7, 6).

    δq is q (0, δθ/2).
    """
    by_chart = np.zeros((QUATERNION + 3, CHART))
    by_chart[:QUATERNION, :3] = _vectors_after(q_wxyz) / 2
    by_chart[QUATERNION:, 3:] = np.eye(3)
    return by_chart


def in_chart(q_wxyz: FloatArray, numbers: FloatArray) -> FloatArray:
    """Derivatives of those seven numbers, (7, n), as derivatives of the chart, (6, n).

    δθ is twice the vector part of q̄ δq. A change of the quaternion's norm is no change.
    """
    turn = 2 * _vectors_after(q_wxyz).T @ numbers[:QUATERNION] / (q_wxyz @ q_wxyz)
    return np.vstack([turn, numbers[QUATERNION:]])


def along(R: FloatArray, derivative: FloatArray) -> FloatArray:
    """A derivative along axes a, (3 n, 6), along axes b, with R taking components of a to b."""
    rows, columns = (np.kron(np.eye(n // 3), R) for n in derivative.shape)
    return np.asarray(rows @ derivative @ columns.T)


def _vectors_after(q_wxyz: FloatArray) -> FloatArray:
    """The matrix M with q (0, v) = M v, (4, 3)."""
    w, x, y, z = q_wxyz
    return np.array([[-x, -y, -z], [w, -z, y], [z, w, -x], [-y, x, w]])
