"""What a wrong tensor does: the exact motions of both bodies, tumbling from one start."""

from functools import lru_cache

import numpy as np

from ....reference import IntegrationError, solve_ode
from ....scenarios import FloatArray, Scenario, Trajectory, loads
from ....scenarios.body import body_about_com
from .records import TIMES

#: One turn a second about an axis that is none of the principal ones: ω along the file's principal
#: axes, ascending, rad/s.
START = 2 * np.pi * np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0)
#: A scene to put the bodies into: free, from rest in its own axes.
_SCENE = """spincheck = 1
title = "Tumbling"
source = "docs/models.md"
[body]
mass = 1.0
inertia = [1.0, 1.0, 1.0]
[start]
rotation_vector_deg = [0.0, 0.0, 0.0]
omega_body = {omega}
[window]
duration = 3.0
samples = 2
"""


def attitude_apart_deg(stated: FloatArray, held: FloatArray) -> dict[float, float] | None:
    """The angle between the two bodies after each of `TIMES` s, degrees.

    Parameters
    ----------
    stated, held : tensors about the com in the link's axes, (3, 3); their size has no part in it

    Returns
    -------
    None where one of them is a tensor that no body has, which has no motion
    """
    axes = np.linalg.eigh(stated)[1]
    omega = axes @ START
    motions = [_motion(tensor, omega) for tensor in (stated, held)]
    one, other = motions
    if one is None or other is None:
        return None
    angles = np.degrees((one.R_world_body.inv() * other.R_world_body).magnitude())
    return {time: float(angle) for time, angle in zip(TIMES, angles[1:], strict=True)}


def _motion(tensor: FloatArray, omega: FloatArray) -> Trajectory | None:
    trace = float(np.trace(tensor))
    if not trace > 0:
        return None
    return _solved((tensor / trace).tobytes(), omega.tobytes())


@lru_cache(maxsize=4)
def _solved(tensor: bytes, omega: bytes) -> Trajectory | None:
    """The file's own motion is asked for once for every configuration."""
    inertia = np.frombuffer(tensor).reshape(3, 3)
    scene = loads(_SCENE.format(omega=np.frombuffer(omega).tolist()), "tumbling")
    try:
        body = body_about_com(1.0, (0.0, 0.0, 0.0), ((inertia + inertia.T) / 2).tolist())
        moved = Scenario(scene.name, None, scene.text, scene.document, body, scene.start)
        return solve_ode(moved, np.array([0.0, *TIMES]))
    except (ValueError, IntegrationError):
        return None
