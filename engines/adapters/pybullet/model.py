"""A body in a PyBullet world, read in spincheck's frames."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import pybullet as p
from scipy.spatial.transform import Rotation

from ....scenarios import FloatArray
from ....scenarios.rotation import across, cross, matrices, matrix, times, turned, turned_back
from ...checks.read_back import BodyReading, State, composed
from .hinges import Hinges

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
#: Com, attitude of the principal axes as x, y, z, w, velocity of the com, ω; world axes.
Motion = tuple[Vector, Quaternion, Vector, Vector]

#: PyBullet's index of a body's base; its links count from 0.
BASE = -1
#: The one link of a body that hangs by a joint.
HUNG = 0


@dataclass(frozen=True, eq=False)
class Placed:
    """Attitude and ω of a state as PyBullet is given them.

    Attributes
    ----------
    q_xyzw, omega : of a base, world axes; of a body that hangs, its joint's, principal axes
    arm_world : from the body's origin to the com, m, (3,)
    link_world : from the com of the link that is set to that of all, m, (3,)
    """

    q_xyzw: Quaternion | FloatArray
    omega: FloatArray
    arm_world: FloatArray
    link_world: FloatArray


@dataclass(frozen=True, eq=False)
class Model:
    """The body in the world of one physics client.

    Attributes
    ----------
    client, body : PyBullet's numbers for the world and the body in it
    link : `BASE`, or `HUNG` if the body hangs by a joint
    body_from_principal : takes components along the engine's axes (principal) to body components
    link_com : of that link alone, as the engine holds it, m, body axes, (3,)
    hinges : of a body with rotors
    """

    client: int
    body: int
    link: int
    body_from_principal: Rotation
    link_com: FloatArray
    hinges: Hinges | None = None

    def read_body(self) -> BodyReading:
        """Mass, com and tensor, with what is welded to the link, and its rotors."""
        return self._body

    @cached_property
    def _body(self) -> BodyReading:
        """PyBullet keeps principal moments of each link, and a frame for them."""
        mass, _, moments, *_ = p.getDynamicsInfo(self.body, self.link, self.client)
        R_body_principal = self.body_from_principal.as_matrix()
        tensor = R_body_principal @ np.diag(moments) @ R_body_principal.T
        alone = BodyReading(mass, self.link_com, tensor)
        links = range(self.link + 1, p.getNumJoints(self.body, self.client))
        if not links:
            return alone
        poses = {self.link: (self.link_com, self.body_from_principal)}
        body = composed([alone, *(self._welded(link, poses) for link in links)])
        return replace(body, axial=self._axial(poses)) if self.hinges else body

    def _axial(self, poses: dict[int, tuple[FloatArray, Rotation]]) -> FloatArray:
        """Axis times moment about it of each rotor, kg m², body axes, (rotors, 3); 0 if locked."""
        assert self.hinges is not None
        axial = np.zeros((len(self.hinges.is_turning), 3))
        for link, axis in zip(self.hinges.links, self.hinges.axes(), strict=True):
            moments = np.array(p.getDynamicsInfo(self.body, link, self.client)[2])
            moment = float(axis @ (moments * axis))
            axial[link - self.hinges.first] = poses[link][1].apply(axis) * moment
        return axial

    def _welded(self, link: int, poses: dict[int, tuple[FloatArray, Rotation]]) -> BodyReading:
        """A link on a fixed joint, or on a hinge at angle 0, in body axes.

        Parameters
        ----------
        poses : com and principal axes of the links before it; its own is added. PyBullet has the
            joint's place and the turn of these axes in the parent's.
        """
        *_, joint, q_xyzw, parent = p.getJointInfo(self.body, link, self.client)
        mass, _, moments, com, q_own_xyzw, *_ = p.getDynamicsInfo(self.body, link, self.client)
        at, parent_axes = poses[parent]
        axes = parent_axes * Rotation.from_quat(q_xyzw).inv()
        link_axes = axes * Rotation.from_quat(q_own_xyzw).inv()
        its_com = at + parent_axes.apply(joint) + link_axes.apply(com)
        poses[link] = its_com, axes
        return BodyReading(mass, np.zeros(3), np.diag(moments)).placed(its_com, axes.as_matrix())

    @cached_property
    def com(self) -> FloatArray:
        """Centre of mass of the whole, as the engine holds it, m, body axes, (3,)."""
        return self._body.com

    @cached_property
    def _arm(self) -> FloatArray:
        """The com of the whole from the link's, m, body axes, (3,)."""
        return self.com - self.link_com

    def read_state(self) -> State:
        """The state now."""
        spins = self.hinges.read() if self.hinges else ()
        rows = np.concatenate([*self.motion(), spins])[None]
        return self.states(rows).rows(0)

    def motion(self) -> Motion:
        """Com, attitude of the principal axes as x, y, z, w, velocity, ω; world axes.

        Those of a link are computed anew: PyBullet's cached values are one step old.
        """
        if self.link == BASE:
            com_world, q_xyzw = p.getBasePositionAndOrientation(self.body, self.client)
            velocity_world, omega_world = p.getBaseVelocity(self.body, self.client)
            return com_world, q_xyzw, velocity_world, omega_world
        # computeLinkVelocity and computeForwardKinematics; keywords would take longer.
        state = p.getLinkState(self.body, self.link, 1, 1, self.client)
        return state[0], state[1], state[6], state[7]

    def states(self, rows: FloatArray) -> State:
        """States from n readings, in spincheck's frames.

        Parameters
        ----------
        rows : the numbers of each reading, (n, 13), and the spins of rotors that turn
        """
        com_world, q_wxyz = rows[:, :3], rows[:, (6, 3, 4, 5)]
        velocity_world, omega_world = rows[:, 7:10], rows[:, 10:13]
        q_world_body = q_wxyz @ self._times_q_principal_body
        R_world_body = matrices(q_world_body)
        omega_body = turned_back(R_world_body, omega_world)
        if self._arm.any():
            com_world = com_world + R_world_body @ self._arm
            velocity_world = velocity_world + turned(R_world_body, omega_body @ across(self._arm))
        spins = self.hinges.spins(rows[:, 13:]) if self.hinges else np.empty((len(rows), 0))
        return State(q_world_body, omega_body, com_world, velocity_world, spins)

    def coordinates(self, states: State) -> FloatArray:
        """The velocity coordinates that PyBullet clamps, rad/s and m/s, a row of each state."""
        if self.link == HUNG:
            turning = states.omega_body @ self.body_from_principal.as_matrix()
            return np.hstack([turning, states.spins])
        omega_world = turned(matrices(states.q_world_body_wxyz), states.omega_body)
        return np.hstack([omega_world, states.velocity_world, states.spins])

    def R_world_body(self) -> FloatArray:
        """The body's attitude now, (3, 3)."""
        q_world_body = self.read_state().q_world_body_wxyz
        return matrix(q_world_body / np.linalg.norm(q_world_body))

    def put_on_pivot(self) -> None:
        """Move the body's origin back to the pivot; the attitude stays, velocities become zero."""
        q_xyzw = self.motion()[1]
        com_world = self.R_world_body() @ self.link_com
        p.resetBasePositionAndOrientation(self.body, com_world, q_xyzw, self.client)

    def placed(self, state: State) -> Placed:
        """A state in PyBullet's coordinates; a body that hangs by a joint is turned there."""
        world_from_body = Rotation.from_quat(state.q_world_body_wxyz, scalar_first=True)
        arms = world_from_body.apply(self.com), world_from_body.apply(self._arm)
        omega_world = world_from_body.apply(np.array(state.omega_body))
        if self.link == BASE:
            q_xyzw = (world_from_body * self.body_from_principal).as_quat()
            return Placed(q_xyzw, omega_world, *arms)
        self.set_joint_attitude(world_from_body)
        return Placed(*self._joint(omega_world), *arms)

    def place(self, placed: Placed, com_world: FloatArray, velocity_world: FloatArray) -> None:
        """Set the body to a state; the com of one that hangs by a joint stays where it hangs."""
        if self.link == HUNG:
            self._set_joint(placed.q_xyzw, placed.omega)
            return
        of_link = com_world - placed.link_world
        p.resetBasePositionAndOrientation(self.body, of_link, placed.q_xyzw, self.client)
        of_link = velocity_world - cross(placed.omega, placed.link_world)
        p.resetBaseVelocity(self.body, of_link, placed.omega, self.client)

    def set_velocity(self, omega_world: FloatArray, velocity_world: FloatArray) -> None:
        """Set ω (3,) and, unless it hangs by a joint, the com's velocity (3,); the pose stays."""
        if self.link == BASE:
            if self._arm.any():
                velocity_world = velocity_world - cross(
                    omega_world, self.R_world_body() @ self._arm
                )
            p.resetBaseVelocity(self.body, velocity_world, omega_world, self.client)
            return
        self._set_joint(*self._joint(omega_world))

    def _joint(self, omega_world: FloatArray) -> tuple[Quaternion, FloatArray]:
        """The joint's attitude now, and ω (3,) along the principal axes."""
        q_joint_xyzw, *_ = p.getJointStateMultiDof(self.body, self.link, self.client)
        world_from_principal = Rotation.from_quat(self.motion()[1])
        return q_joint_xyzw, world_from_principal.inv().apply(omega_world)

    def set_joint_attitude(self, world_from_body: Rotation) -> None:
        """Turn the link that hangs: its joint's angle is counted along the principal axes."""
        turned = self.body_from_principal.inv() * world_from_body * self.body_from_principal
        self._set_joint(turned.as_quat(), np.zeros(3))

    def _set_joint(self, q_xyzw: Quaternion | FloatArray, omega_principal: FloatArray) -> None:
        p.resetJointStateMultiDof(
            self.body, self.link, q_xyzw, omega_principal, physicsClientId=self.client
        )

    @cached_property
    def _times_q_principal_body(self) -> FloatArray:
        return times(self.body_from_principal.inv().as_quat(scalar_first=True))
