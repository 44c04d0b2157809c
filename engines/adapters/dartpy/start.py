"""The start as DART's joints are given it."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from ....scenarios import FloatArray, Scenario


@dataclass(frozen=True, eq=False)
class Start:
    """Attitude and motion of a body, and for a free one where its origin is.

    Attributes
    ----------
    rotation_vector, R_world_body : rad, (3,), and (3, 3)
    omega_body : rad/s
    origin_world : m
    velocity_body : of the origin, m/s
    """

    rotation_vector: FloatArray
    R_world_body: FloatArray
    omega_body: FloatArray
    origin_world: FloatArray
    velocity_body: FloatArray


def start_of(scenario: Scenario) -> Start:
    """The start in the quantities that DART takes."""
    start, com = scenario.start, np.array(scenario.body.com)
    attitude = Rotation.from_quat(start.q_world_body_wxyz, scalar_first=True)
    R_world_body = attitude.as_matrix()
    return Start(
        attitude.as_rotvec(),
        R_world_body,
        np.array(start.omega_body),
        start.position_world - R_world_body @ com,
        R_world_body.T @ start.velocity_world - np.cross(start.omega_body, com),
    )
