"""A body in a PyBullet world, which is read and set in the axes of the scene's body."""

from typing import Any

import numpy as np
import pybullet as p
from scipy.spatial.transform import Rotation
from spincheck.engine import BodyReading, FloatArray, Scenario, State, start_state

from ....scenarios.rotation import (
    across,
    conjugate,
    cross,
    matrices,
    matrix,
    times,
    turned,
    turned_back,
)
from ...scene_record import with_rotors
from .world import BASE, World

#: Indices into the tuple that `getJointInfo` returns: the joint's axis, its position and rotation
#: relative to the parent link, and the number of that link.
AXIS, PLACE, TURN, PARENT = 13, 14, 15, 16
#: Indices that reorder a quaternion from w x y z to PyBullet's x y z w, and back.
XYZW, WXYZ = [1, 2, 3, 0], [3, 0, 1, 2]


def attitude(state: State) -> FloatArray:
    """Return the rotation matrix of a state, (3, 3), body to world."""
    q_wxyz = state.q_world_body_wxyz
    return matrix(q_wxyz / np.linalg.norm(q_wxyz))


class Model:
    """The body in one PyBullet world; a `Model` is made as soon as the body is loaded.

    Parameters
    ----------
    world : the world, before `World.set_up`
    scenario : the scene

    Attributes
    ----------
    body_from_principal : the rotation that takes components along the principal axes, which
        PyBullet uses, to components along the scene's body axes
    link_com : com, as PyBullet holds it, of the body's link (the base, or the link on the spherical
        joint) without other links, m, body axes, (3,)
    body : this link, with all links that are welded to it and the rotors, as read back
    """

    def __init__(self, world: World, scenario: Scenario) -> None:
        self.world, joint_body = world, np.zeros(3)
        if world.scene["hung"]:
            joint_body = scenario.body.com - scenario.constraint.lever
        if world.scene["maximal"]:
            self.body_from_principal, self.link_com = _frame_of_rigid_body(world, scenario)
        else:
            of_link = p.getDynamicsInfo(world.body, world.link, world.client)
            self.body_from_principal = Rotation.from_quat(of_link[4])
            # A link's frame is at its joint.
            self.link_com = joint_body + of_link[3]
        self._q_body_principal = self.body_from_principal.as_quat(scalar_first=True)
        self._times_q_principal_body = times(conjugate(self._q_body_principal))
        self.body = self._read_body()
        # Vectors to the com of the whole body from the link's com, and from the joint, m, body
        # axes.
        self._arm, self._lever = self.body.com - self.link_com, self.body.com - joint_body

    def _read_body(self) -> BodyReading:
        """Return all links as one body, with joints at angle 0, in the scene's body axes.

        PyBullet reports for each link its principal moments, its com and the attitude of its
        principal axes relative to its joint; and for the joint its position, from the com and along
        the principal axes of the parent link, and its rotation relative to those axes.
        """
        world, R_body_principal = self.world, self.body_from_principal.as_matrix()
        mass, _, moments, *_ = p.getDynamicsInfo(world.body, world.link, world.client)
        tensor = R_body_principal @ np.diag(moments) @ R_body_principal.T
        parts = [BodyReading(mass, self.link_com, tensor)]
        poses = {world.link: (self.link_com, self.body_from_principal)}
        axes_of_rotors = np.zeros((len(world.scene["rotors"]), 3))
        for link in range(world.link + 1, p.getNumJoints(world.body, world.client)):
            joint = p.getJointInfo(world.body, link, world.client)
            mass, _, moments, com, q_own_xyzw, *_ = p.getDynamicsInfo(
                world.body, link, world.client
            )
            at, parent_axes = poses[joint[PARENT]]
            axes = parent_axes * Rotation.from_quat(joint[TURN]).inv()
            link_axes = axes * Rotation.from_quat(q_own_xyzw).inv()
            its_com = at + parent_axes.apply(joint[PLACE]) + link_axes.apply(com)
            poses[link] = its_com, axes
            alone = BodyReading(mass, np.zeros(3), np.diag(moments))
            parts.append(alone.placed(its_com, axes.as_matrix()))
            if link in world.hinges:
                axes_of_rotors[link - world.first_rotor] = axes.apply(np.array(joint[AXIS]))
        return with_rotors(parts, axes_of_rotors)

    def read_state(self) -> State:
        """Return the present state, in the scene's body axes."""
        rows = np.concatenate([*self.world.motion(), self.world.spins()])[None]
        return self.states(rows).rows(0)

    def states(self, rows: FloatArray) -> State:
        """Return n states, in the scene's body axes, given the numbers that PyBullet returns.

        Parameters
        ----------
        rows : the numbers of a state in each row, (n, 13 + rotors): com of the link, attitude of
            the principal axes (x y z w), velocity and ω in world axes, and spins of rotors that are
            not locked
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
        """Return the velocity coordinates of n states, which PyBullet clamps, (n, coordinates).

        A row has ω, rad/s, and the velocity, m/s, in world axes. For a body on a spherical joint it
        has the rates of slides, m/s, and ω along principal axes instead. The spins of all rotors,
        rad/s, come last.
        """
        R_world_body = matrices(states.q_world_body_wxyz)
        if self.world.link == BASE:
            omega_world = turned(R_world_body, states.omega_body)
            return np.hstack([omega_world, states.velocity_world, states.spins])
        turning = states.omega_body @ self.body_from_principal.as_matrix()
        swing_world = turned(R_world_body, cross(states.omega_body, self._lever))
        sliding = (states.velocity_world - swing_world)[:, : self.world.link]
        return np.hstack([sliding, turning, states.spins])

    def motion(self, state: State) -> dict[str, Any]:
        """Return a state as a motion, a dict for `World.restart`.

        Its keys are `turn`, `omega`, `place`, `velocity` and `spins`, which `World` describes.
        If the body is on a spherical joint, this call turns the joint in the world to the state's
        attitude, and the motion has the joint's attitude as PyBullet then reports it, rounded.
        """
        world, times_q_body_principal = self.world, times(self._q_body_principal)
        q_world_body = state.q_world_body_wxyz / np.linalg.norm(state.q_world_body_wxyz)
        R_world_body = matrix(q_world_body)
        omega = omega_world = R_world_body @ state.omega_body
        if world.link == BASE:
            arm_world = R_world_body @ self._arm
            q_xyzw = (q_world_body @ times_q_body_principal)[XYZW]
        else:
            arm_world = R_world_body @ self._lever
            turned = conjugate(self._q_body_principal) @ times(q_world_body)
            world.turn_joint((turned @ times_q_body_principal)[XYZW], np.zeros(3))
            q_xyzw, *_ = p.getJointStateMultiDof(world.body, world.link, world.client)
            omega = omega @ matrix(np.array(world.motion()[1])[WXYZ])
        return {
            "turn": q_xyzw,
            "omega": omega,
            "place": state.com_world - arm_world,
            "velocity": state.velocity_world - cross(omega_world, arm_world),
            "spins": state.spins,
        }

    def in_its_axes(self, scenario: Scenario) -> dict[str, Any]:
        """Return the entries of the record that are known only after the body was loaded.

        They are `axes`, the principal axes that PyBullet has found; `pivot` and `torque_body`,
        along these axes; and the motion at the start, with the keys that `motion` returns.
        """
        start, is_pivot = scenario.start, scenario.constraint.is_pivot
        is_base, principal_from_body = self.world.link == BASE, self.body_from_principal.inv()
        world_from_body = Rotation.from_quat(start.q_world_body_wxyz, scalar_first=True)
        omega_world = world_from_body.apply(np.array(start.omega_body))
        velocity_world = start.velocity_world
        if is_pivot:
            com_world = world_from_body.apply(np.array(scenario.body.com))
            velocity_world = cross(omega_world, com_world)
        pivot = principal_from_body.apply(-self.link_com)
        motion = self.motion(start_state(scenario))
        arm_world = world_from_body.apply(self._lever)
        if is_base:
            # From the attitude that PyBullet holds, so that the place is that of loading to the
            # last bit.
            arm_world = attitude(self.read_state()) @ self._arm
        motion["place"] = start.position_world - arm_world
        motion["velocity"] = velocity_world - cross(omega_world, arm_world)
        return {
            "axes": self.body_from_principal.as_quat(scalar_first=True).tolist(),
            "pivot": pivot.tolist() if is_pivot and is_base else None,
            "torque_body": principal_from_body.apply(
                np.array(scenario.pushed["torque_body"])
            ).tolist(),
            **{name: np.array(numbers).tolist() for name, numbers in motion.items()},
        }


def _frame_of_rigid_body(world: World, scenario: Scenario) -> tuple[Rotation, FloatArray]:
    """Return the principal axes and the com of a body that is in PyBullet's maximal coordinates.

    These are the rotation from principal to body axes and the com, m, body axes, (3,), for
    `Model.body_from_principal` and `Model.link_com`. They are computed from the body's pose after
    loading, because for such bodies `getDynamicsInfo` returns uninitialised memory.
    """
    com_world, q_world_principal_xyzw = p.getBasePositionAndOrientation(world.body, world.client)
    q_world_body_wxyz = scenario.start.q_world_body_wxyz
    body_from_world = Rotation.from_quat(q_world_body_wxyz, scalar_first=True).inv()
    body_from_principal = body_from_world * Rotation.from_quat(q_world_principal_xyzw)
    return body_from_principal, body_from_world.apply(com_world - np.array(world.scene["position"]))
