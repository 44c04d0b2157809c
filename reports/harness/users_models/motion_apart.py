"""The effect of a wrong tensor: exact motions of both bodies from the same start, compared."""

from dataclasses import replace
from functools import cache

import numpy as np
from scipy.spatial.transform import Rotation

from ....reference import IntegrationError, solve_ode
from ....scenarios import FloatArray, Scenario, loads
from ....scenarios.body import body_about_com
from ....scenarios.exact import exact
from .records import TIMES

#: One turn a second about an axis that is none of the principal ones: ω along the file's principal
#: axes, ascending, rad/s.
START = 2 * np.pi * np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0)
#: A scene to put the bodies into: free, from rest in its own axes.
_SCENE = """spincheck = 1
title = "Tumbling"
source = "docs/how-to/models.md"
[body]
mass = 1.0
inertia = [1.0, 1.0, 1.0]
[start]
rotation_vector_deg = [0.0, 0.0, 0.0]
omega_body = [0.0, 0.0, 0.0]
[window]
duration = 3.0
samples = 2
"""


def attitude_apart_deg(stated: FloatArray, got: FloatArray) -> dict[float, float] | None:
    """The angle between the two bodies after each of `TIMES` s, degrees.

    Parameters
    ----------
    stated, got : tensors about the com in the link's axes, (3, 3); a common factor has no effect

    Returns
    -------
    None if one of them is a tensor that no body can have
    """
    apart = attitude_apart(stated, got, np.array(TIMES))
    if apart is None:
        return None
    return {time: float(angle) for time, angle in zip(TIMES, np.degrees(apart), strict=True)}


def attitude_apart(stated: FloatArray, got: FloatArray, times: FloatArray) -> FloatArray | None:
    """The angle between the two bodies, rad, (n,); None as above.

    Parameters
    ----------
    times : s, (n,), at most the scene's 3
    """
    omega = np.linalg.eigh(stated)[1] @ START
    one, other = (_attitudes(tensor, omega, times) for tensor in (stated, got))
    if one is None or other is None:
        return None
    return np.asarray((one.inv() * other).magnitude())


def _attitudes(tensor: FloatArray, omega: FloatArray, times: FloatArray) -> Rotation | None:
    """The attitude at each time of a body that starts unturned.

    Solved along its principal axes: the reference would look for them in 60 digits.
    """
    moments, axes = np.linalg.eigh(tensor)
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    if not (total := float(moments.sum())) > 0:
        return None
    scene = _scene()
    x, y, z = exact(omega @ axes)
    try:
        body = body_about_com(1.0, (0.0, 0.0, 0.0), np.diag(moments / total).tolist())
        start = replace(scene.start, omega_body_exact=(x, y, z))
        moved = solve_ode(replace(scene, carrier=body, start=start), times)
    except (ValueError, IntegrationError):
        return None
    turn = Rotation.from_matrix(axes)
    return turn * moved.R_world_body * turn.inv()


@cache
def _scene() -> Scenario:
    return loads(_SCENE, "tumbling")
