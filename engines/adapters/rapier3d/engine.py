"""Rapier 3D, in single precision, from its Python package `rapier3d`.

What it does to a top by default, and how each effect was measured: docs/engines-more.md.
"""

from importlib import import_module
from importlib.metadata import version
from math import pi
from typing import Any, final

import numpy as np
from scipy.spatial.transform import Rotation

from ....scenarios import FloatArray, Scenario
from ...checks.read_back import BodyReading, EngineError, State
from ...engine import Engine, Method
from ...session import Session
from .held import Held, held
from .script import script

EFFECTS = frozenset({"gravity", "pivot", "drag", "torque_body", "torque_world"})
#: rad: ANGULAR_MOTION_THRESHOLD of its sources: by default a body turns no further in a step.
MOST_ROTATION_A_STEP = pi / 4


@final
class Rapier3D(Engine):
    """Rapier's rigid bodies, a pivot as an impulse joint."""

    name = "rapier3d"
    package = "rapier3d"
    step_seconds = 6e-6
    single_precision = True
    # IntegrationParameters.dt of its documentation.
    stock_timestep = 1 / 60
    methods = (
        Method("impulse", 1, 1, "semi-implicit Euler, the pivot as an impulse joint", EFFECTS),
        Method(
            "default",
            1,
            1,
            "as shipped: may fall asleep, and clamps the rotation a step",
            EFFECTS,
            max_rotation_per_step=MOST_ROTATION_A_STEP,
            as_shipped=True,
        ),
    )

    @property
    def version(self) -> str:
        """Of the installed package."""
        return version("rapier3d")

    def open(self, scenario: Scenario, method: Method, timestep: float) -> Session:
        """Build a world with the body, and for a pivot the joint that holds it."""
        return Rapier3DSession(scenario, method.as_shipped, timestep)

    def script(self, scenario: Scenario, method: Method, timestep: float) -> str:  # noqa: ARG002
        """The world as Python."""
        return script(scenario, held(scenario), method.as_shipped)


@final
class Rapier3DSession(Session):
    """One body in a world of its own; its frame is the scene's body frame."""

    def __init__(self, scenario: Scenario, as_shipped: bool, timestep: float) -> None:
        rapier3d: Any = import_module("rapier3d")
        self._scenario, self._quarantined = scenario, False
        self._world = rapier3d.PhysicsWorld(gravity=_tuple(scenario.gravity_world))
        self._world.integration_parameters.dt = timestep
        handle = self._world.add_body(_described(rapier3d, held(scenario), as_shipped))
        self._body = self._world.rigid_bodies[handle]
        # Its mass reads 0 until it is recomputed.
        self._body.recompute_mass_properties_from_colliders(self._world.colliders)
        self._arm_body = np.zeros(3)
        if scenario.has_pivot:
            joint = rapier3d.SphericalJoint.builder().build()
            ground = self._world.add_body(rapier3d.RigidBody.fixed())
            number = self._world.impulse_joints.insert(ground, handle, joint)
            self._arm_body = _array(self._world.impulse_joints.get(number).data.local_anchor2)
        self._push_turns = bool(scenario.torque_body.any() or scenario.drag)
        self._push()

    def read_body(self) -> BodyReading:
        """Its principal moments turned back into body axes, the com seen from the joint."""
        held = self._body.mass_properties
        axes = _rotation(held.principal_inertia_local_frame).as_matrix()
        inertia = axes @ np.diag(_array(held.principal_inertia)) @ axes.T
        return BodyReading(self._body.mass, _array(held.local_com) - self._arm_body, inertia)

    def read_state(self) -> State:
        """The state now."""
        world_from_body = _rotation(self._body.rotation)
        return State(
            world_from_body.as_quat(scalar_first=True),
            world_from_body.inv().apply(_array(self._body.angvel)),
            _array(self._body.center_of_mass),
            _array(self._body.linvel),
        )

    def advance(self, steps: int) -> None:
        """Step; Rapier keeps a torque, so one that changes is set again before each step.

        Rapier stops a body whose numbers are not finite, and reports it only after that step.
        """
        world = self._world
        for _ in range(steps):
            if self._push_turns:
                self._push()
            world.step()
            self._quarantined |= not world.quarantine.is_empty()
            self.check()

    def check(self) -> None:
        """Raise if any step so far was quarantined."""
        if self._quarantined:
            raise EngineError("Rapier has quarantined the body: not finite", "not-finite")

    def active(self) -> frozenset[str]:
        """What acts, as reported by the world and the body."""
        body, world, scenario = self._body, self._world, self._scenario
        self._push()
        held = _array(body.user_torque)
        torque = np.linalg.norm(held - self._torque()) <= _SLACK * np.linalg.norm(held)
        gravity = _array(world.gravity) * body.gravity_scale
        right = np.allclose(gravity, scenario.gravity_world, rtol=_SLACK, atol=0)
        named = {
            "gravity" if right else f"a gravity of {gravity.tolist()} m/s²": gravity.any(),
            "pivot": len(world.impulse_joints) == 1,
            "joints": len(world.impulse_joints) > 1 or len(world.multibody_joints) > 0,
            f"a torque of {held.tolist()} N m": not torque,
            "damping": body.linear_damping or body.angular_damping,
            "sleeping": body.activation.angular_threshold > 0,
            "a collision shape": len(world.colliders) > 0,
            "no gyroscopic torque": not body.gyroscopic_forces_enabled,
            "a rotation clamp": not body.allow_fast_rotation,
        }
        acting = {name for name, acts in named.items() if acts}
        stated_effects = scenario.called_for & {"drag", "torque_body", "torque_world"}
        return frozenset(acting | stated_effects if held.any() else acting)

    def close(self) -> None:
        """Drop the world."""
        del self._body, self._world

    def _push(self) -> None:
        torque = _tuple(self._torque())
        self._body.reset_torques()
        self._body.add_torque(torque)

    def _torque(self) -> FloatArray:
        """The scene's torques at the attitude and ω now, N m, world axes."""
        scenario = self._scenario
        turned = np.zeros(3)
        if scenario.torque_body.any():
            turned = _rotation(self._body.rotation).apply(np.array(scenario.torque_body))
        return scenario.torque_world + turned - scenario.drag * _array(self._body.angvel)


#: Relative rounding of numbers in single precision.
_SLACK = 8 * float(np.finfo(np.float32).eps)


def _described(rapier3d: Any, told: Held, as_shipped: bool) -> Any:
    """The description of the body and its start that Rapier takes."""
    axes = rapier3d.Rotation3(*_tuple(told.q_body_axes_wxyz))
    held = rapier3d.MassProperties(_tuple(told.com), told.mass, _tuple(told.moments), axes)
    turned = rapier3d.Rotation3(*_tuple(told.q_world_body_wxyz))
    described = (
        rapier3d.RigidBody.dynamic()
        .position(rapier3d.Isometry3(_tuple(told.origin_world), turned))
        .linvel(_tuple(told.velocity_world))
        .angvel(_tuple(told.omega_world))
        .additional_mass_properties(held)
    )
    return described if as_shipped else described.can_sleep(False).allow_fast_rotation(True)


def _rotation(rotation: Any) -> Rotation:
    return Rotation.from_quat((rotation.w, rotation.i, rotation.j, rotation.k), scalar_first=True)


def _array(vector: Any) -> FloatArray:
    return np.array((vector.x, vector.y, vector.z))


def _tuple(values: FloatArray) -> tuple[float, ...]:
    return tuple(float(value) for value in values)
