"""What the pivot of a rigid body bears: beyond it the body falls through."""

import numpy as np
from spincheck.engine import State, UnsupportedError

from ....scenarios.rotation import cross, matrix
from ...checks.equations import Equations

#: N s a step, of a constraint between two rigid bodies: PyBullet's default, which it keeps.
MOST_IMPULSE = 500.0


def check_borne(equations: Equations, state: State, timestep: float) -> None:
    """Raise `UnsupportedError` if the pivot cannot bear the body at this state."""
    body, com = equations.scenario.body, equations.scenario.body.com
    R_world_body, omega_body = matrix(state.q_world_body_wxyz), state.omega_body
    torque_body = equations.torque_body(R_world_body, omega_body, equations.kept_body(state))
    omega_rate = equations.inverse @ torque_body
    pull_body = cross(omega_rate, com) + cross(omega_body, cross(omega_body, com))
    force_world = body.mass * (R_world_body @ pull_body - equations.scenario.gravity_world)
    impulse = float(np.abs(force_world).max()) * timestep
    if impulse > MOST_IMPULSE:
        raise UnsupportedError(
            f"PyBullet's pivot of a rigid body bears at most {MOST_IMPULSE:g} N s a step along "
            f"each of the world's axes, this body needs {impulse:.3g}; use a timestep of less than "
            f"{timestep * MOST_IMPULSE / impulse:.2g} s, or another method",
            "clamp",
        )
