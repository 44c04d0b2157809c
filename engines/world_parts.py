"""Functions that the stand-alone modules of adapters share; scripts contain them as well.

They need numpy alone.
"""

from typing import Any

import numpy as np

from ..scenarios.effects.push import is_pushed as is_pushed
from ..scenarios.effects.push import push as push

#: Inertia of the drive that keeps a rotor's spin, in units of the rotor's moment about its axis:
#: whatever ω changes by, the spin changes only by a few ulp of that.
DRIVE = 2.0**50


def drive(rotor: Any) -> float:
    """Return the armature of a rotor's hinge, kg m²: 0 if the hinge is not driven.

    `rotor` is the rotor's entry in the scene's record. An armature is an inertia that resists
    changes of the spin. That of a driven hinge is so large that the spin stays constant.
    """
    return DRIVE * float(rotor["inertia"][1]) if rotor["hinge"] == "driven" else 0.0


def rotor_tensor(rotor: Any) -> Any:
    """Return the tensor of inertia of a scene record's rotor about its com, kg m², (3, 3)."""
    across, along = rotor["inertia"]
    axis = np.array(rotor["axis"])
    return across * np.eye(3) + (along - across) * np.outer(axis, axis)


def matrix(q: Any) -> Any:
    """Return the rotation matrix, (3, 3), of a quaternion w x y z of any norm."""
    w, x, y, z = q
    n = w * w + x * x + y * y + z * z
    return np.eye(3) + 2 / n * np.array(
        [
            [-y * y - z * z, x * y - w * z, x * z + w * y],
            [x * y + w * z, -x * x - z * z, y * z - w * x],
            [x * z - w * y, y * z + w * x, -x * x - y * y],
        ]
    )


def quaternion(R: Any) -> Any:
    """Return the unit quaternion w x y z, (4,), of a rotation matrix, (3, 3).

    The method is that of Shepperd, J. Guidance 1 (1978) 223.
    """
    squares = (1 + np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) @ np.diag(R)) / 4
    k = int(np.argmax(squares))
    products = np.array(
        [
            [0.0, R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]],
            [R[2, 1] - R[1, 2], 0.0, R[0, 1] + R[1, 0], R[0, 2] + R[2, 0]],
            [R[0, 2] - R[2, 0], R[0, 1] + R[1, 0], 0.0, R[1, 2] + R[2, 1]],
            [R[1, 0] - R[0, 1], R[0, 2] + R[2, 0], R[1, 2] + R[2, 1], 0.0],
        ]
    )
    q = products[k] / (4 * np.sqrt(squares[k]))
    q[k] = np.sqrt(squares[k])
    return q / np.linalg.norm(q)


def rotation_vector(q: Any) -> Any:
    """Return the rotation vector, axis times angle, rad, (3,), of a unit quaternion w x y z."""
    w, vector = q[0], np.array(q[1:])
    sine = np.linalg.norm(vector)
    return vector * (2 * np.arctan2(sine, abs(w)) / sine * np.copysign(1, w) if sine else 0.0)
