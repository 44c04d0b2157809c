"""Converts attitude and ω to angles and rates of hinges about z, y and x in series, and back."""

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from ...scenarios import FloatArray

#: Number of components of a quaternion, and number of the angles that replace it.
QUATERNION, ANGLES = 4, 3


def hinged(
    qpos: Sequence[float] | FloatArray, qvel: Sequence[float] | FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return coordinates and velocities of a body on three hinges, given those on a ball joint.

    The quaternion is replaced by angles a, b, c, rad, of the hinges about z, y and x, and ω by
    their rates, rad/s: R = Rz(a) Ry(b) Rx(c) and ω = M (ȧ, ḃ, ċ), where M depends on the angles
    (Diebel 2006, §5.6.12).

    Parameters
    ----------
    qpos : n coordinates of slides, then a quaternion w, x, y, z, (n + 4,)
    qvel : n velocities of slides, then ω, rad/s, body axes, (n + 3,)

    Returns
    -------
    The coordinates and the velocities; the last three are those of the hinges, (n + 3,) each
    """
    place, q = np.split(np.asarray(qpos, dtype=float), [-QUATERNION])
    speed, omega_body = np.split(np.asarray(qvel, dtype=float), [-ANGLES])
    angles = Rotation.from_quat(q, scalar_first=True).as_euler("ZYX")
    rates = np.linalg.solve(_omega_of_rates(angles[None])[0], omega_body)
    return np.concatenate([place, angles]), np.concatenate([speed, rates])


def unhinged(qpos: FloatArray, qvel: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return coordinates and velocities on a ball joint, given those on three hinges.

    This is the inverse of `hinged`, for n states at once.

    Parameters
    ----------
    qpos : n rows of coordinates that end with the angles of hinges about z, y and x, rad
    qvel : n rows of velocities that end with the rates of these hinges, rad/s

    Returns
    -------
    n rows of coordinates that end with a quaternion w, x, y, z, and n rows of velocities that end
    with ω, rad/s, body axes
    """
    angles = qpos[:, -ANGLES:]
    q = Rotation.from_euler("ZYX", angles).as_quat(scalar_first=True)
    omega_body = np.einsum("nij,nj->ni", _omega_of_rates(angles), qvel[:, -ANGLES:])
    return np.hstack([qpos[:, :-ANGLES], q]), np.hstack([qvel[:, :-ANGLES], omega_body])


def _omega_of_rates(angles: FloatArray) -> FloatArray:
    """Return n matrices that take rates of the hinges to ω in body axes, (n, 3, 3).

    Parameters
    ----------
    angles : n rows of angles of the hinges about z, y and x, rad, (n, 3)
    """
    _, b, c = angles.T
    zero, one = np.zeros_like(b), np.ones_like(b)
    rows = [
        [-np.sin(b), zero, one],
        [np.sin(c) * np.cos(b), np.cos(c), zero],
        [np.cos(c) * np.cos(b), -np.sin(c), zero],
    ]
    return np.moveaxis(np.array(rows), 2, 0)
