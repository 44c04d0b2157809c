"""Bodies and motions as MuJoCo has them: its tables of bodies, and coordinates qpos and qvel."""

from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from spincheck.engine import BodyReading, FloatArray, State, composed

from ....scenarios.rotation import across, cross, matrices, matrix, turned

#: MuJoCo's number of the world, which every model begins with.
WORLD = 0
#: How many numbers are ω; those before them move a point, at most three.
TURNING = 3
#: Of a body without rotors, whether each of them turns.
NO_ROTORS = np.empty(0, dtype=bool)


def body_of(model: Any) -> BodyReading:
    """The body of a compiled model with those welded to it, in its own axes."""
    if model.nbody == WORLD + 2:
        return one_body(model, -1)
    parts = [one_body(model, WORLD + 1)]
    poses = {WORLD + 1: (np.zeros(3), np.eye(3))}
    for body in range(WORLD + 2, model.nbody):
        at, R = poses[model.body_parentid[body]]
        at, R = at + R @ model.body_pos[body], R @ _rotation(model.body_quat[body]).as_matrix()
        poses[body] = at, R
        parts.append(one_body(model, body).placed(at, R))
    return composed(parts)


def axial_of(model: Any, count: int) -> FloatArray:
    """Axis times moment about it of the last `count` bodies, kg m², zero if welded, (count, 3)."""
    rows = np.zeros((count, 3))
    for joint in range(model.body_jntnum[WORLD + 1], model.njnt):
        body = model.jnt_bodyid[joint]
        axis = _rotation(model.body_quat[body]).apply(np.array(model.jnt_axis[joint]))
        rows[body - model.nbody + count] = axis * (axis @ one_body(model, body).inertia_com @ axis)
    return rows


def one_body(model: Any, body: int) -> BodyReading:
    """One body, its principal moments turned back into its axes."""
    R_body_axes = _rotation(model.body_iquat[body]).as_matrix()
    return BodyReading(
        mass=float(model.body_mass[body]),
        com=model.body_ipos[body].copy(),
        inertia_com=R_body_axes @ np.diag(model.body_inertia[body]) @ R_body_axes.T,
    )


def anchor_of(model: Any) -> tuple[FloatArray, FloatArray]:
    """The com from the point that the coordinates move, m, body axes; and where that begins."""
    com_body, last = body_of(model).com, model.body_jntnum[WORLD + 1] - 1
    if model.jnt_type[last] == mujoco.mjtJoint.mjJNT_FREE:
        return com_body, np.zeros(3)
    return com_body - model.jnt_pos[last], model.body_pos[WORLD + 1] + model.jnt_pos[last]


def states_of(
    qpos: FloatArray,
    qvel: FloatArray,
    arm_body: FloatArray,
    is_turning: NDArray[np.bool_] = NO_ROTORS,
) -> State:
    """The states of one body from its coordinates, (n, nq), and velocities, (n, nv).

    The com is a point that the first coordinates move plus the compiled arm, its velocity that of
    the point plus ω × arm; the origin on a ball joint alone stands still.
    """
    spins = np.zeros((len(qvel), len(is_turning)))
    count = np.count_nonzero(is_turning)
    if count:
        spins[:, is_turning] = qvel[:, -count:]
        qpos, qvel = qpos[:, :-count], qvel[:, :-count]
    q_world_body_wxyz, omega_body = qpos[:, -4:], qvel[:, -TURNING:]
    R_world_body = matrices(q_world_body_wxyz)
    com_world = R_world_body @ arm_body
    velocity_world = turned(R_world_body, omega_body @ across(arm_body))
    moving = qvel.shape[1] - TURNING
    com_world[:, :moving] += qpos[:, :moving]
    velocity_world[:, :moving] += qvel[:, :moving]
    return State(q_world_body_wxyz, omega_body, com_world, velocity_world, spins)


def coordinates_of(
    state: State, nv: int, arm_body: FloatArray, is_turning: NDArray[np.bool_] = NO_ROTORS
) -> tuple[FloatArray, FloatArray]:
    """Coordinates, (nq,), and velocities, (nv,), of a state, as `states_of` reads them."""
    q_world_body_wxyz, omega_body = state.q_world_body_wxyz, state.omega_body
    spins = state.spins[is_turning]
    R_world_body, moving = matrix(q_world_body_wxyz), nv - len(spins) - TURNING
    place_world = state.com_world - R_world_body @ arm_body
    speed_world = state.velocity_world - R_world_body @ cross(omega_body, arm_body)
    return (
        np.concatenate([place_world[:moving], q_world_body_wxyz, np.zeros_like(spins)]),
        np.concatenate([speed_world[:moving], omega_body, spins]),
    )


def _rotation(q_wxyz: FloatArray) -> Rotation:
    return Rotation.from_quat(q_wxyz, scalar_first=True)
