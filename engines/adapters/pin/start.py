"""The start in the coordinates of Pinocchio's joints."""

import numpy as np
from scipy.spatial.transform import Rotation

from ....scenarios import FloatArray, Scenario


def start_of(scenario: Scenario) -> tuple[FloatArray, FloatArray]:
    """Coordinates and velocities of the joint.

    Of a free body they are where its origin is, then its attitude x y z w; and the origin's
    velocity along body axes, then ω. On a pivot they are attitude and ω alone.
    """
    start, com = scenario.start, scenario.body.com
    w, x, y, z = start.q_world_body_wxyz
    q = np.array((x, y, z, w))
    if scenario.has_pivot:
        return q, np.array(start.omega_body)
    R_world_body = Rotation.from_quat(q).as_matrix()
    origin_velocity = R_world_body.T @ start.velocity_world - np.cross(start.omega_body, com)
    origin = start.position_world - R_world_body @ com
    return np.array([*origin, *q]), np.array([*origin_velocity, *start.omega_body])
