"""A body in a PyBullet world, read and set in spincheck's frames."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import pybullet as p
from scipy.spatial.transform import Rotation
from spincheck.engine import BodyReading, FloatArray, Scenario, State, composed

from ....scenarios.rotation import across, cross, matrices, matrix, times, turned, turned_back
from .world import BASE, World

#: What a world's `move` takes.
Move = tuple[Sequence[float] | None, FloatArray, FloatArray]


@dataclass(frozen=True, eq=False)
class Placed:
    """Attitude and ω of a state as PyBullet is given them.

    Attributes
    ----------
    q_xyzw, omega : of a base, world axes; of a body that hangs, its joint's, principal axes
    arm_world : from the joint, or of a base from the body's origin, to the com, m, (3,)
    link_world : from the com of the link that is set to that of all, m, (3,)
    swing_world : ω × `arm_world`, m/s, (3,)
    """

    q_xyzw: Sequence[float] | FloatArray
    omega: FloatArray
    arm_world: FloatArray
    link_world: FloatArray
    swing_world: FloatArray


@dataclass(frozen=True, eq=False)
class Model:
    """The body in the world of one physics client.

    Attributes
    ----------
    body_from_principal : takes components along the engine's axes (principal) to body components
    link_com : of its base or hung link alone, as the engine holds it, m, body axes, (3,)
    joint_body : the point that it hangs by, m, body axes, (3,); of a base, its origin
    """

    world: World
    body_from_principal: Rotation
    link_com: FloatArray
    joint_body: FloatArray

    def read_body(self) -> BodyReading:
        """Mass, com and tensor, with what is welded to the link, and its rotors."""
        return self._body

    @cached_property
    def _body(self) -> BodyReading:
        """PyBullet keeps principal moments of each link, and a frame for them."""
        world, link = self.world, self.world.link
        mass, _, moments, *_ = p.getDynamicsInfo(world.body, link, world.client)
        R_body_principal = self.body_from_principal.as_matrix()
        tensor = R_body_principal @ np.diag(moments) @ R_body_principal.T
        alone = BodyReading(mass, self.link_com, tensor)
        links = range(link + 1, p.getNumJoints(world.body, world.client))
        if not links:
            return alone
        poses = {link: (self.link_com, self.body_from_principal)}
        body = composed([alone, *(self._welded(link, poses) for link in links)])
        return replace(body, axial=self._axial(poses)) if world.scene["rotors"] else body

    def _axial(self, poses: dict[int, tuple[FloatArray, Rotation]]) -> FloatArray:
        """Axis times moment about it of each rotor, kg m², body axes, (rotors, 3); 0 if locked."""
        world = self.world
        axial = np.zeros((len(world.scene["rotors"]), 3))
        for link in world.hinges:
            # Along the principal axes of the rotor's link.
            axis = np.array(p.getJointInfo(world.body, link, world.client)[13])
            moments = np.array(p.getDynamicsInfo(world.body, link, world.client)[2])
            moment = float(axis @ (moments * axis))
            axial[link - world.first_rotor] = poses[link][1].apply(axis) * moment
        return axial

    def _welded(self, link: int, poses: dict[int, tuple[FloatArray, Rotation]]) -> BodyReading:
        """A link on a fixed joint, or on a hinge at angle 0, in body axes.

        Parameters
        ----------
        poses : com and principal axes of the links before it; its own is added. PyBullet has the
            joint's place and the turn of these axes in the parent's.
        """
        world = self.world
        *_, joint, q_xyzw, parent = p.getJointInfo(world.body, link, world.client)
        mass, _, moments, com, q_own_xyzw, *_ = p.getDynamicsInfo(world.body, link, world.client)
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

    @cached_property
    def _lever(self) -> FloatArray:
        """The com of the whole from the joint, m, body axes, (3,)."""
        return self.com - self.joint_body

    def read_state(self) -> State:
        """The state now."""
        rows = np.concatenate([*self.world.motion(), self.world.spins()])[None]
        return self.states(rows).rows(0)

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
        spins = np.zeros((len(rows), len(self.world.scene["rotors"])))
        spins[:, [link - self.world.first_rotor for link in self.world.hinges]] = rows[:, 13:]
        return State(q_world_body, omega_body, com_world, velocity_world, spins)

    def coordinates(self, states: State) -> FloatArray:
        """The velocity coordinates that PyBullet clamps, rad/s and m/s, a row of each state."""
        R_world_body = matrices(states.q_world_body_wxyz)
        if self.world.link == BASE:
            omega_world = turned(R_world_body, states.omega_body)
            return np.hstack([omega_world, states.velocity_world, states.spins])
        turning = states.omega_body @ self.body_from_principal.as_matrix()
        swing_world = turned(R_world_body, cross(states.omega_body, self._lever))
        sliding = (states.velocity_world - swing_world)[:, : self.world.link]
        return np.hstack([sliding, turning, states.spins])

    def R_world_body(self) -> FloatArray:
        """The body's attitude now, (3, 3)."""
        q_world_body = self.read_state().q_world_body_wxyz
        return matrix(q_world_body / np.linalg.norm(q_world_body))

    def put_on_pivot(self) -> None:
        """Move the body's origin back to the pivot; the attitude stays, velocities become zero."""
        q_xyzw = self.world.motion()[1]
        com_world = self.R_world_body() @ self.link_com
        p.resetBasePositionAndOrientation(self.world.body, com_world, q_xyzw, self.world.client)

    def placed(self, state: State) -> Placed:
        """A state in PyBullet's coordinates; a body that hangs by a joint is turned there."""
        world_from_body = Rotation.from_quat(state.q_world_body_wxyz, scalar_first=True)
        arm_world, link_world = map(world_from_body.apply, (self._lever, self._arm))
        omega_world = world_from_body.apply(np.array(state.omega_body))
        arms = arm_world, link_world, cross(omega_world, arm_world)
        if self.world.link == BASE:
            q_xyzw = (world_from_body * self.body_from_principal).as_quat()
            return Placed(q_xyzw, omega_world, *arms)
        self._turn(world_from_body)
        q_joint_xyzw, _, omega_principal = self._move(omega_world, np.zeros(3))
        assert q_joint_xyzw is not None
        return Placed(q_joint_xyzw, omega_principal, *arms)

    def place(self, placed: Placed, com_world: FloatArray, velocity_world: FloatArray) -> None:
        """Set the body to a state; the joint of one that hangs stays at its height."""
        world = self.world
        if world.link != BASE:
            world.slide(com_world - placed.arm_world, velocity_world - placed.swing_world)
        else:
            of_link = com_world - placed.link_world
            p.resetBasePositionAndOrientation(world.body, of_link, placed.q_xyzw, world.client)
            velocity_world = velocity_world - cross(placed.omega, placed.link_world)
        world.move(placed.q_xyzw, velocity_world, placed.omega)

    def set_velocity(self, omega_world: FloatArray, velocity_world: FloatArray) -> None:
        """Set ω (3,) and the com's velocity (3,) as far as a joint lets it; the pose stays."""
        if self.world.link != BASE:
            arm_world = self.R_world_body() @ self._lever
            place = self.read_state().com_world - arm_world
            self.world.slide(place, velocity_world - cross(omega_world, arm_world))
        self.world.move(*self._move(omega_world, velocity_world))

    def in_its_axes(self, scenario: Scenario) -> dict[str, Any]:
        """What a world's `set_up` needs besides: the start and torque, along principal axes."""
        world_from_body = Rotation.from_quat(scenario.start.q_world_body_wxyz, scalar_first=True)
        principal_from_body = self.body_from_principal.inv()
        if self.world.link != BASE:
            self._turn(world_from_body)
        omega_world = world_from_body.apply(np.array(scenario.start.omega_body))
        velocity_world = scenario.start.velocity_world
        if scenario.constraint.is_pivot:
            velocity_world = np.cross(
                omega_world, world_from_body.apply(np.array(scenario.body.com))
            )
        joint, velocity, omega = self._move(omega_world, velocity_world)
        arm_world = world_from_body.apply(self._lever)
        is_tied = scenario.constraint.is_pivot and self.world.link == BASE
        torque = principal_from_body.apply(np.array(scenario.pushed["torque_body"]))
        return {
            "axes": self.body_from_principal.as_quat(scalar_first=True).tolist(),
            "pivot": principal_from_body.apply(-self.link_com).tolist() if is_tied else None,
            "place": (scenario.start.position_world - arm_world).tolist(),
            "speed": (velocity_world - np.cross(omega_world, arm_world)).tolist(),
            "joint": joint,
            "velocity": velocity.tolist(),
            "omega": omega.tolist(),
            "torque_body": torque.tolist(),
        }

    def _move(self, omega_world: FloatArray, velocity_world: FloatArray) -> Move:
        """What the world's `move` takes for these, at the attitude now."""
        world = self.world
        if world.link == BASE:
            if self._arm.any():
                arm_world = self.R_world_body() @ self._arm
                velocity_world = velocity_world - cross(omega_world, arm_world)
            return None, velocity_world, omega_world
        q_joint_xyzw, *_ = p.getJointStateMultiDof(world.body, world.link, world.client)
        world_from_principal = Rotation.from_quat(world.motion()[1])
        return q_joint_xyzw, velocity_world, world_from_principal.inv().apply(omega_world)

    def _turn(self, world_from_body: Rotation) -> None:
        """Turn the link that hangs: its joint's angle is counted along the principal axes."""
        turned = self.body_from_principal.inv() * world_from_body * self.body_from_principal
        self.world.move(turned.as_quat(), np.zeros(3), np.zeros(3))

    @cached_property
    def _times_q_principal_body(self) -> FloatArray:
        return times(self.body_from_principal.inv().as_quat(scalar_first=True))
