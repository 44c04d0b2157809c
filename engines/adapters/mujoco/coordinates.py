"""Converts MuJoCo's models to bodies, and coordinates (qpos, qvel) to states and back."""

from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from spincheck.engine import (
    BodyReading,
    FloatArray,
    Scenario,
    Session,
    State,
    UnsupportedError,
)

from ....scenarios.rotation import across, cross, matrices, matrix, turned
from ...models.hinged import hinged, unhinged
from ...scene_record import with_rotors

#: MuJoCo's indices of the world, with which every model begins, and of the body.
WORLD, BODY = 0, 1
#: Number of velocities in qvel that are ω. Up to three, the velocity of a point of the body, come
#: before them.
TURNING = 3


def one_body(model: Any, body: int) -> BodyReading:
    """Return mass, com and tensor of one body of a compiled model, in the body's own frame.

    Bodies that are attached to it are not included. `body` is the body's index in the model.
    """
    R_body_axes = _rotation(model.body_iquat[body]).as_matrix()
    return BodyReading(
        mass=float(model.body_mass[body]),
        com=model.body_ipos[body].copy(),
        inertia_com=R_body_axes @ np.diag(model.body_inertia[body]) @ R_body_axes.T,
    )


def _rotation(q_wxyz: FloatArray) -> Rotation:
    """Return the rotation of a quaternion, w x y z, (4,)."""
    return Rotation.from_quat(q_wxyz, scalar_first=True)


class CoordinateSession(Session):
    """A session in MuJoCo, or in a port of it, that reads and sets states by qpos and qvel alone.

    The body is on a free joint, a ball joint or three hinges. Slides may come before a ball joint
    or hinges. In qpos and qvel the slides come first, and rotors that are not locked come last.

    Parameters
    ----------
    model : the compiled model of the scene, or a port's model with the same field names
    """

    def __init__(self, scenario: Scenario, model: Any) -> None:
        self._scenario, self._compiled = scenario, model
        self._is_turning = scenario.rotors.is_turning
        self._spins = int(np.count_nonzero(self._is_turning))
        self._moving = model.nv - self._spins - TURNING
        last = model.body_jntadr[BODY] + model.body_jntnum[BODY] - 1
        self._on_hinges = model.jnt_type[last] == mujoco.mjtJoint.mjJNT_HINGE
        self._on_pivot = model.jnt_type[0] == mujoco.mjtJoint.mjJNT_BALL
        # The first coordinates move a point of the body. These are the vector from this point to
        # the com, m, body axes, and the point's place when all coordinates are zero, m.
        self._arm_body, self._place_world = self.read_body().com, np.zeros(3)
        if model.jnt_type[last] != mujoco.mjtJoint.mjJNT_FREE:
            self._arm_body = self._arm_body - model.jnt_pos[last]
            self._place_world = model.body_pos[BODY] + model.jnt_pos[last]

    @property
    def can_restart(self) -> bool:
        """True: coordinates can be set at any time."""
        return True

    @property
    def restarts_to_the_last_bit(self) -> bool:
        """Whether a restart rounds no coordinate.

        This is so if the body is on a ball joint without slides, or if the first coordinates are
        those of the com.
        """
        return bool(self._on_pivot or not self._arm_body.any())

    @property
    def turning(self) -> NDArray[np.intp]:
        """The indices, in qvel, of the velocities that are ω in body axes, (3,).

        Raises
        ------
        UnsupportedError
            If the body is on hinges.
        """
        if self._on_hinges:
            raise UnsupportedError("derivatives are taken of a ball joint, got three hinges")
        return np.arange(self._moving, self._moving + TURNING)

    def read_body(self) -> BodyReading:
        """Return the body with its rotors and all bodies welded to it, in the body's own axes."""
        model, poses = self._compiled, {BODY: (np.zeros(3), np.eye(3))}
        parts = [one_body(model, BODY)]
        for body in range(BODY + 1, model.nbody):
            at, R = poses[model.body_parentid[body]]
            at, R = at + R @ model.body_pos[body], R @ _rotation(model.body_quat[body]).as_matrix()
            poses[body] = at, R
            parts.append(one_body(model, body).placed(at, R))
        axes = np.zeros((len(self._is_turning), 3))
        for joint, rotor in enumerate(np.flatnonzero(self._is_turning), -self._spins):
            axes[rotor] = poses[model.jnt_bodyid[joint]][1] @ model.jnt_axis[joint]
        return with_rotors(parts, axes)

    def read_state(self) -> State:
        """Return the state after the last step."""
        return self.states([self.snapshot()]).rows(0)

    def states_at(self, qpos: FloatArray, qvel: FloatArray) -> State:
        """Return n states, as one `State` with n rows, given their coordinates and velocities.

        The first coordinates are the place of a point of the body: the origin of a free body, or
        the point that slides move. On a ball joint without slides this point is fixed, and has no
        coordinates. With R the attitude, and a the vector from the point to the com, body axes, the
        com is at the point plus R a; its velocity is that of the point plus R (ω × a).

        Parameters
        ----------
        qpos : coordinates, a state in each row, (n, nq)
        qvel : velocities, a state in each row, (n, nv)
        """
        if self._on_hinges:
            qpos, qvel = unhinged(qpos, qvel)
        spins = np.zeros((len(qvel), len(self._is_turning)))
        if self._spins:
            spins[:, self._is_turning] = qvel[:, -self._spins :]
            qpos, qvel = qpos[:, : -self._spins], qvel[:, : -self._spins]
        q_world_body_wxyz, omega_body = qpos[:, -4:], qvel[:, -TURNING:]
        R_world_body, moving = matrices(q_world_body_wxyz), self._moving
        com_world = R_world_body @ self._arm_body
        velocity_world = turned(R_world_body, omega_body @ across(self._arm_body))
        com_world[:, :moving] += qpos[:, :moving]
        velocity_world[:, :moving] += qvel[:, :moving]
        com_world += self._place_world
        return State(q_world_body_wxyz, omega_body, com_world, velocity_world, spins)

    def coordinates(self, state: State) -> tuple[FloatArray, FloatArray]:
        """Return the coordinates qpos, (nq,), and the velocities qvel, (nv,), of one state.

        The angles of rotors are set to 0. `states_at` does the reverse.
        """
        q_world_body_wxyz, omega_body = state.q_world_body_wxyz, state.omega_body
        spins, moving = state.spins[self._is_turning], self._moving
        R_world_body = matrix(q_world_body_wxyz)
        place_world = state.com_world - R_world_body @ self._arm_body
        speed_world = state.velocity_world - R_world_body @ cross(omega_body, self._arm_body)
        qpos = np.concatenate([place_world[:moving], q_world_body_wxyz, np.zeros_like(spins)])
        qvel = np.concatenate([speed_world[:moving], omega_body, spins])
        return hinged(qpos, qvel) if self._on_hinges else (qpos, qvel)
