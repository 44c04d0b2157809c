"""The largest load that PyBullet's pivot bears in maximal coordinates; beyond it the body falls."""

import numpy as np
from spincheck.engine import Scenario, State, UnsupportedError

from ....scenarios.effects.push import push
from ....scenarios.rotation import cross, matrix

#: Largest impulse, N s, that a constraint between two rigid bodies exerts in a step: PyBullet's
#: default, which is not changed.
MOST_IMPULSE = 500.0


def check_borne(scenario: Scenario, state: State, timestep: float) -> None:
    """Raise `UnsupportedError` if the pivot cannot bear the load of the body in a state.

    The load follows from the acceleration of the com, by Euler's equations about the pivot.

    Parameters
    ----------
    timestep : length of the steps, s
    """
    mass, com, inertia = scenario.body.mass, scenario.body.com, scenario.inertia
    R_world_body, omega_body = matrix(state.q_world_body_wxyz), state.omega_body
    weight_body = mass * (scenario.gravity_world @ R_world_body)
    pushed_world = push(scenario.pushed, R_world_body, R_world_body @ omega_body)
    torque_body = cross(com, weight_body) + pushed_world @ R_world_body
    omega_rate = np.linalg.solve(inertia, torque_body - cross(omega_body, inertia @ omega_body))
    pull_body = cross(omega_rate, com) + cross(omega_body, cross(omega_body, com))
    force_world = R_world_body @ (mass * pull_body - weight_body)
    impulse = float(np.abs(force_world).max()) * timestep
    if impulse > MOST_IMPULSE:
        raise UnsupportedError(
            f"PyBullet's pivot of a rigid body bears at most {MOST_IMPULSE:g} N s a step along "
            f"each of the world's axes, this body needs {impulse:.3g}; use a timestep of less than "
            f"{timestep * MOST_IMPULSE / impulse:.2g} s, or another method",
            "clamp",
        )
