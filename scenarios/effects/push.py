"""The torques that whoever integrates a scene applies by hand. Goes into scripts as it stands."""

from typing import Any

import numpy as np

from ..float_array import FloatArray


def push(scene: Any, R_world_body: FloatArray, omega_body: FloatArray) -> FloatArray:
    """Torque of all effects but gravity and constraints, N m, world axes, (3,).

    Parameters
    ----------
    scene : a `Scenario`, or what else has its `drag` (N m s), `torque_body` and `torque_world`
    R_world_body : takes body to world components, (3, 3)
    omega_body : rad/s, (3,)
    """
    with_the_body = np.asarray(scene.torque_body) - scene.drag * np.asarray(omega_body)
    return np.asarray(scene.torque_world + R_world_body @ with_the_body)
