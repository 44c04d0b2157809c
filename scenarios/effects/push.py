"""Drag and constant torques, for engines to apply as external torques.

Generated scripts contain the text of these functions as it stands.
"""

from typing import Any

import numpy as np


def push(scene: Any, R_world_body: Any, omega_world: Any) -> Any:
    """Return the torque of drag and of the constant torques, N m, world axes.

    It is that in one state, (3,), or in n states, (n, 3).

    Parameters
    ----------
    scene : record with `drag`, N m s, `torque_body` and `torque_world`, N m, or the dictionary
        `Scenario.pushed`
    R_world_body : the matrix that takes components along the axes of `torque_body` to world
        components, (3, 3) or (n, 3, 3)
    omega_world : ω, rad/s, world axes, (3,) or (n, 3)
    """
    turned = R_world_body @ np.array(scene["torque_body"])
    return turned + np.array(scene["torque_world"]) - scene["drag"] * np.array(omega_world)


def is_pushed(scene: Any) -> bool:
    """Whether a scene, in either form that `push` takes, has a torque or drag that is not zero."""
    return bool(np.any([*scene["torque_body"], *scene["torque_world"], scene["drag"]]))
