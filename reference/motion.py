"""From a rotation about the principal axes to the motion of the body a scene describes."""

import numpy as np
from scipy.spatial.transform import Rotation

from ..scenarios import FloatArray, Scenario, Trajectory
from .problem import Problem


def motion(
    scenario: Scenario,
    problem: Problem,
    times: FloatArray,
    states: tuple[FloatArray, FloatArray],
) -> Trajectory:
    """Assemble a trajectory.

    Parameters
    ----------
    times : (n,) s
    states : q_world_axes (n, 4) and omega_axes (n, 3) rad/s, along the principal axes
    """
    q_world_axes, omega_axes = states
    q_axes_body = np.array(problem.q_axes_body, dtype=float)
    if q_axes_body[0] == 1:  # body axes are principal: nothing to round
        q_world_body, omega_body = q_world_axes, omega_axes
    else:
        R_axes_body = Rotation.from_quat(q_axes_body, scalar_first=True)
        R_world_axes = Rotation.from_quat(q_world_axes, scalar_first=True)
        q_world_body = (R_world_axes * R_axes_body).as_quat(scalar_first=True)
        # scipy refuses read-only arrays, hence the copies here and below.
        omega_body = np.asarray(R_axes_body.inv().apply(np.array(omega_axes)))
    com_world, velocity_world = _centre_of_mass(scenario, times, q_world_body, omega_body)
    return Trajectory(times, q_world_body, omega_body, com_world, velocity_world)


def _centre_of_mass(
    scenario: Scenario, times: FloatArray, q_world_body: FloatArray, omega_body: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Position (n, 3) m and velocity (n, 3) m/s: about the pivot, or on the parabola."""
    if scenario.has_pivot:
        R_world_body = Rotation.from_quat(q_world_body, scalar_first=True)
        com = np.array(scenario.body.com)
        velocity_body = np.cross(omega_body, com)
        return (
            np.asarray(R_world_body.apply(com)),
            np.asarray(R_world_body.apply(velocity_body)),
        )
    t, g = times[:, None], scenario.gravity_world
    start = scenario.start
    fallen = start.position_world + start.velocity_world * t + 0.5 * g * t**2
    return fallen, start.velocity_world + g * t
