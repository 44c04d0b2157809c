"""A scene's body in a PyBullet world: loaded, stripped of what nobody asked for, set to its start.

Why each call is there, and what happens without it: docs/engines-pybullet.md.
"""

import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pybullet as p
from scipy.spatial.transform import Rotation

from ..scenarios import FloatArray, Scenario
from ..scenarios.document import Effects
from .read_back import BodyReading, EngineError, State
from .urdf import urdf

#: PyBullet's index of a body's base; its links count from 0.
BASE = -1
#: The one link of a body that hangs by a joint.
HUNG = 0
#: rad/s and m/s. The default clamps every velocity coordinate at 100; this is out of reach.
UNREACHED_VELOCITY = 1e100
#: N. A constraint's default limit is an impulse of 500 N s a step; this is out of reach.
UNREACHED_FORCE = 1e100


@dataclass(frozen=True)
class Holding:
    """How a method represents the body, and its pivot where there is one.

    Attributes
    ----------
    maximal : six coordinates a body (btRigidBody) instead of joint coordinates (btMultiBody)
    hung : the pivot is a spherical joint; otherwise a point-to-point constraint
    """

    maximal: bool
    hung: bool


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


def load(client: int, scenario: Scenario, holding: Holding) -> Model:
    """Put the scene's body into an empty world, at its start, held as the scene says.

    Raises
    ------
    EngineError
        If PyBullet cannot load the model.
    """
    hung = holding.hung and scenario.has_pivot
    world_from_body = Rotation.from_quat(scenario.start.q_world_body_wxyz, scalar_first=True)
    arm_world = world_from_body.apply(np.array(scenario.body.com))
    origin_world = np.zeros(3) if scenario.has_pivot else scenario.start.position_world - arm_world
    p.setPhysicsEngineParameter(enableFileCaching=0, physicsClientId=client)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "top.urdf")
        file.write_text(urdf(scenario if hung else _set_free(scenario)), encoding="utf-8")
        try:
            body = p.loadURDF(
                str(file),
                np.zeros(3) if hung else origin_world,
                (0, 0, 0, 1) if hung else world_from_body.as_quat(),
                useMaximalCoordinates=holding.maximal,
                useFixedBase=hung,
                flags=p.URDF_USE_INERTIA_FROM_FILE,
                physicsClientId=client,
            )
        except p.error as error:
            raise EngineError(f"PyBullet cannot load the body: {error}") from None
    link = HUNG if hung else BASE
    _, _, _, com, q_body_principal_xyzw, *_ = p.getDynamicsInfo(body, link, client)
    if holding.maximal:
        com_world, q_world = p.getBasePositionAndOrientation(body, client)
        com = world_from_body.inv().apply(np.array(com_world) - origin_world)
        q_body_principal_xyzw = (world_from_body.inv() * Rotation.from_quat(q_world)).as_quat()
    model = Model(client, body, link, Rotation.from_quat(q_body_principal_xyzw), np.array(com))
    _strip(model)
    if hung:
        model.set_joint_attitude(world_from_body)
    elif scenario.has_pivot:
        _tie_to_world(model, holding)
    omega_world = world_from_body.apply(np.array(scenario.start.omega_body))
    velocity_world = scenario.start.velocity_world
    if scenario.has_pivot:
        velocity_world = np.cross(omega_world, arm_world)
    model.set_velocity(omega_world, velocity_world)
    return model


def _set_free(scenario: Scenario) -> Scenario:
    """The same body on its own: what holds it is not part of the URDF."""
    return replace(scenario, document=scenario.document.model_copy(update={"effects": Effects()}))


def _strip(model: Model) -> None:
    """Take away damping, velocity clamp, sleep and motor: defaults that nobody asked for."""
    for link in range(BASE, p.getNumJoints(model.body, model.client)):
        p.changeDynamics(
            model.body,
            link,
            linearDamping=0,
            angularDamping=0,
            jointDamping=0,
            maxJointVelocity=UNREACHED_VELOCITY,
            activationState=p.ACTIVATION_STATE_DISABLE_SLEEPING,
            physicsClientId=model.client,
        )
    if model.link == HUNG:
        # One number as the force, not three: only so is the motor left out of the solver.
        p.setJointMotorControlMultiDof(
            model.body,
            model.link,
            p.POSITION_CONTROL,
            targetPosition=(0, 0, 0, 1),
            positionGain=0,
            velocityGain=0,
            force=[0],
            physicsClientId=model.client,
        )


def _tie_to_world(model: Model, holding: Holding) -> None:
    """A point-to-point constraint from the body's origin to the world's."""
    anchor = BASE
    if holding.maximal:
        # Of two rigid bodies only: a massless, shapeless one stands for the world.
        anchor = p.createMultiBody(
            baseMass=0, useMaximalCoordinates=True, physicsClientId=model.client
        )
    constraint = p.createConstraint(
        model.body,
        BASE,
        anchor,
        BASE,
        p.JOINT_POINT2POINT,
        jointAxis=(0, 0, 0),
        parentFramePosition=model.body_from_principal.inv().apply(-model.com),
        childFramePosition=(0, 0, 0),
        physicsClientId=model.client,
    )
    p.changeConstraint(constraint, maxForce=UNREACHED_FORCE, physicsClientId=model.client)
