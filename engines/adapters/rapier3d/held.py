"""What Rapier is given of a body and its start."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from ....scenarios import FloatArray, Scenario
from ...models.principal_frame import principal_frame


@dataclass(frozen=True, eq=False)
class Held:
    """A body; its origin is the pivot, or that of the scene's body.

    Attributes
    ----------
    mass, com : kg, m
    moments, q_body_axes_wxyz : kg m², along principal axes, and their attitude in the body's
    origin_world, velocity_world : m, and of the com m/s
    q_world_body_wxyz, omega_world : the start; rad/s
    """

    mass: float
    com: FloatArray
    moments: FloatArray
    q_body_axes_wxyz: FloatArray
    origin_world: FloatArray
    velocity_world: FloatArray
    q_world_body_wxyz: FloatArray
    omega_world: FloatArray


def held(scenario: Scenario) -> Held:
    """The scene's body and start as Rapier is given them."""
    body, start = scenario.body, scenario.start
    frame = principal_frame(body)
    attitude = Rotation.from_quat(start.q_world_body_wxyz, scalar_first=True)
    origin, velocity = np.zeros(3), attitude.apply(np.cross(start.omega_body, body.com))
    if not scenario.has_pivot:
        origin = start.position_world - attitude.apply(np.array(body.com))
        velocity = start.velocity_world
    return Held(
        float(body.mass),
        body.com,
        frame.moments,
        frame.q_body_axes_wxyz,
        origin,
        velocity,
        start.q_world_body_wxyz,
        attitude.apply(np.array(start.omega_body)),
    )
