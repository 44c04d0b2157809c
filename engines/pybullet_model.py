"""A body in a PyBullet world: what PyBullet holds, in the program's own frames."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pybullet as p
from scipy.spatial.transform import Rotation

from ..scenarios import FloatArray
from .read_back import BodyReading, State

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

#: PyBullet's index of a body's base; its links count from 0.
BASE = -1
#: The one link of a body that hangs by a joint.
HUNG = 0


@dataclass(frozen=True, eq=False)
class Model:
    """The body in the world of one physics client.

    Attributes
    ----------
    client, body : PyBullet's numbers for the world and the body in it
    link : `BASE`, or `HUNG` if the body hangs by a joint
    body_from_principal : takes components along the engine's axes (principal) to body components
    com : as the engine holds it, m, body axes, (3,)
    """

    client: int
    body: int
    link: int
    body_from_principal: Rotation
    com: FloatArray

    def read_body(self) -> BodyReading:
        """Mass, com and tensor; PyBullet keeps principal moments and a frame for them."""
        mass, _, moments, *_ = p.getDynamicsInfo(self.body, self.link, self.client)
        R_body_principal = self.body_from_principal.as_matrix()
        tensor = R_body_principal @ np.diag(moments) @ R_body_principal.T
        return BodyReading(mass, self.com, tensor)

    def read_state(self) -> State:
        """Pose and velocities now; a link's are computed afresh, its cache is a step old."""
        com_world, q_xyzw, velocity_world, omega_world = self._motion()
        q_world_body = _product((q_xyzw[3], *q_xyzw[:3]), self._q_principal_body)
        omega_body = _product(_product(_conjugate(q_world_body), (0.0, *omega_world)), q_world_body)
        return State(
            q_world_body_wxyz=np.array(q_world_body),
            omega_body=np.array(omega_body[1:]),
            com_world=np.array(com_world),
            velocity_world=np.array(velocity_world),
        )

    def drift(self) -> float:
        """How far the body's origin is from the world's, m."""
        state = self.read_state()
        arm_world = _product(
            _product(state.q_world_body_wxyz, (0.0, *self.com)),
            _conjugate(state.q_world_body_wxyz),
        )
        return float(np.linalg.norm(state.com_world - arm_world[1:]))

    def world_from_body(self) -> Rotation:
        """The body's attitude now."""
        return Rotation.from_quat(self.read_state().q_world_body_wxyz, scalar_first=True)

    def put_on_pivot(self) -> None:
        """Take back what a constraint let the origin drift; the attitude stays, the motion ends."""
        q_xyzw = self._motion()[1]
        com_world = self.world_from_body().apply(self.com)
        p.resetBasePositionAndOrientation(self.body, com_world, q_xyzw, self.client)

    def set_velocity(self, omega_world: FloatArray, velocity_world: FloatArray) -> None:
        """Set ω (3,) and, unless it hangs by a joint, the com's velocity (3,); the pose stays."""
        if self.link == BASE:
            p.resetBaseVelocity(self.body, velocity_world, omega_world, self.client)
            return
        q_joint_xyzw, *_ = p.getJointStateMultiDof(self.body, self.link, self.client)
        world_from_principal = Rotation.from_quat(self._motion()[1])
        omega_principal = world_from_principal.inv().apply(omega_world)
        self._set_joint(q_joint_xyzw, omega_principal)

    def set_joint_attitude(self, world_from_body: Rotation) -> None:
        """Turn the link that hangs: its joint's angle is counted along the principal axes."""
        turned = self.body_from_principal.inv() * world_from_body * self.body_from_principal
        self._set_joint(turned.as_quat(), np.zeros(3))

    def _set_joint(self, q_xyzw: FloatArray, omega_principal: FloatArray) -> None:
        p.resetJointStateMultiDof(
            self.body, self.link, q_xyzw, omega_principal, physicsClientId=self.client
        )

    @cached_property
    def _q_principal_body(self) -> Quaternion:
        x, y, z, w = self.body_from_principal.inv().as_quat().tolist()
        return (w, x, y, z)

    def _motion(self) -> tuple[Vector, Quaternion, Vector, Vector]:
        """Com, attitude of the principal axes as x, y, z, w, velocity, ω; world axes."""
        if self.link == BASE:
            com_world, q_xyzw = p.getBasePositionAndOrientation(self.body, self.client)
            velocity_world, omega_world = p.getBaseVelocity(self.body, self.client)
            return com_world, q_xyzw, velocity_world, omega_world
        state = p.getLinkState(
            self.body,
            self.link,
            computeLinkVelocity=1,
            computeForwardKinematics=1,
            physicsClientId=self.client,
        )
        return state[0], state[1], state[6], state[7]


def _product(a: Quaternion | FloatArray, b: Quaternion | FloatArray) -> Quaternion:
    """Hamilton product a b, scalar first: twenty times as fast as scipy's, and NaN may pass."""
    (a0, a1, a2, a3), (b0, b1, b2, b3) = a, b
    return (
        a0 * b0 - a1 * b1 - a2 * b2 - a3 * b3,
        a0 * b1 + a1 * b0 + a2 * b3 - a3 * b2,
        a0 * b2 - a1 * b3 + a2 * b0 + a3 * b1,
        a0 * b3 + a1 * b2 - a2 * b1 + a3 * b0,
    )


def _conjugate(q: Quaternion | FloatArray) -> Quaternion:
    return (q[0], -q[1], -q[2], -q[3])
