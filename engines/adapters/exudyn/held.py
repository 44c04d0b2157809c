"""What Exudyn is given of a scene, in the axes of its node."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from ....scenarios import FloatArray, Scenario

#: The node has the body's axes in another order. Exudyn composes rotation vectors with an arc
#: cosine, which loses half the digits of a small one: from a start along the world's axes,
#: rotations of less than 1.5e-8 rad a step were lost.
R_BODY_NODE = np.roll(np.eye(3), 1, axis=0)
#: Entries of a tensor in Exudyn's order.
ENTRIES = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))


@dataclass(frozen=True, eq=False)
class Held:
    """A body on its node, and what acts on it.

    Explicit solvers eliminate constraints wrongly if the com is not at the node. So the node is at
    the pivot, the tensor is taken about the pivot, and gravity is a force on a marker at the com.

    Attributes
    ----------
    mass : kg
    inertia : kg m², about the node, xx, yy, zz, yz, xz, xy, (6,)
    com : m, from the node, (3,)
    place, velocity : of the node, m and a rotation vector, m/s and rad/s in node axes, (6,)
    weight : N, world axes, (3,)
    torque_node, torque_world : N m, (3,)
    damping : of a connector between two bodies, N s/m, then N m s, (6, 6)
    """

    mass: float
    inertia: FloatArray
    com: FloatArray
    place: FloatArray
    velocity: FloatArray
    weight: FloatArray
    torque_node: FloatArray
    torque_world: FloatArray
    damping: FloatArray


def held(scenario: Scenario) -> Held:
    """The scene as Exudyn is given it."""
    body, start = scenario.body, scenario.start
    world_from_body = Rotation.from_quat(start.q_world_body_wxyz, scalar_first=True)
    attitude = world_from_body * Rotation.from_matrix(R_BODY_NODE)
    origin, velocity, arm = start.position_world, start.velocity_world, np.zeros(3)
    inertia = np.array(body.inertia_com)
    if scenario.has_pivot:
        origin, velocity, arm = np.zeros(3), np.zeros(3), R_BODY_NODE.T @ body.com
        inertia += of_point(body.mass, np.array(body.com))
    inertia = R_BODY_NODE.T @ inertia @ R_BODY_NODE
    drag = scenario.drag
    return Held(
        float(body.mass),
        np.array([inertia[row, column] for row, column in ENTRIES]),
        arm,
        np.array([*origin, *attitude.as_rotvec()]),
        np.array([*velocity, *(R_BODY_NODE.T @ start.omega_body)]),
        body.mass * scenario.gravity_world,
        R_BODY_NODE.T @ scenario.torque_body,
        scenario.torque_world,
        np.diag([0.0, 0.0, 0.0, drag, drag, drag]),
    )


def of_point(mass: float, arm: FloatArray) -> FloatArray:
    """The tensor of a point mass, kg m², (3, 3)."""
    return np.asarray(mass * (arm @ arm * np.eye(3) - np.outer(arm, arm)))
