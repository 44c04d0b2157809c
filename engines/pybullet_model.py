"""A body in a PyBullet world: what PyBullet holds, in the program's own frames."""

from dataclasses import dataclass

import numpy as np
import pybullet as p
from scipy.spatial.transform import Rotation

from ..scenarios import FloatArray
from .read_back import BodyReading, State

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
        world_from_body = self._world_from_body(q_xyzw)
        return State(
            q_world_body_wxyz=world_from_body.as_quat(scalar_first=True),
            omega_body=world_from_body.inv().apply(omega_world),
            com_world=com_world,
            velocity_world=velocity_world,
        )

    def drift(self) -> float:
        """How far the body's origin is from the world's, m."""
        com_world, q_xyzw, *_ = self._motion()
        arm_world = self._world_from_body(q_xyzw).apply(self.com)
        return float(np.linalg.norm(com_world - arm_world))

    def world_from_body(self) -> Rotation:
        """The body's attitude now."""
        return self._world_from_body(self._motion()[1])

    def put_on_pivot(self) -> None:
        """Take back what a constraint let the origin drift; the attitude stays, the motion ends."""
        q_xyzw = self._motion()[1]
        com_world = self._world_from_body(q_xyzw).apply(self.com)
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

    def _world_from_body(self, q_xyzw: FloatArray) -> Rotation:
        return Rotation.from_quat(q_xyzw) * self.body_from_principal.inv()

    def _motion(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Com (3,), attitude of the principal axes (4,) xyzw, velocity (3,), ω (3,); world axes."""
        if self.link == BASE:
            pose = p.getBasePositionAndOrientation(self.body, self.client)
            motion = (*pose, *p.getBaseVelocity(self.body, self.client))
        else:
            state = p.getLinkState(
                self.body,
                self.link,
                computeLinkVelocity=1,
                computeForwardKinematics=1,
                physicsClientId=self.client,
            )
            motion = (state[0], state[1], state[6], state[7])
        com_world, q_xyzw, velocity_world, omega_world = (np.array(part) for part in motion)
        return com_world, q_xyzw, velocity_world, omega_world
