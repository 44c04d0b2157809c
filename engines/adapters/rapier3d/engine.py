"""Rapier 3D, in single precision, from its Python package `rapier3d`.

docs/measured/engines-more.md says what the engine does to a top by default, and how effects were
measured.
"""

from collections.abc import Iterator
from math import pi
from typing import Any, final

import numpy as np
from spincheck.engine import COMMON_EFFECTS, EngineError, FloatArray, Method

from ...scene_record import HeldRotor, WorldBody
from ...world_engine import WorldEngine
from ...world_parts import matrix, push
from ...world_session import WorldSession

#: Effects that Rapier can simulate. A pivot, a table and a rotor's hinge are joints that lock
#: different axes.
EFFECTS = COMMON_EFFECTS | {"rotors", "table"}
#: Number of axes, three of translation and three of rotation, that a joint can lock.
EVERY = 6
#: Largest rotation in a step, rad, by default: ANGULAR_MOTION_THRESHOLD of Rapier's sources.
MOST_ROTATION_A_STEP = pi / 4
#: Relative tolerance of numbers that were rounded to single precision.
SLACK = 8 * float(np.finfo(np.float32).eps)
#: Lines by which users set the timestep, and keep a body from falling asleep and being clamped.
AWAKE = """\
world.integration_parameters.dt = TIMESTEP
body = rapier3d.RigidBody.dynamic().can_sleep(False).allow_fast_rotation(True)"""


@final
class Rapier3DSession(WorldSession):
    """A session of one body in a Rapier world; the body's origin is its com."""

    def world_body(self) -> WorldBody:
        """Return the body as Rapier holds it: mass, com, tensor, held point and rotors.

        The origin is the com; axes are those of the scene record. The point where the body is held
        is read from the anchor of its joint.
        """
        joint, xyz = self.world.joint, self.module.xyz
        arm = None if joint is None else xyz(joint.data.local_anchor2)
        rotors = [self._rotor(*rotor) for rotor in self.world.rotors]
        return WorldBody(*self._mass_of(self.world.body), arm, rotors)

    def _mass_of(self, body: Any) -> tuple[float, FloatArray, FloatArray]:
        """Return a body's mass, kg, com, m, and tensor about the com, kg m², in its own axes."""
        properties, xyz = body.mass_properties, self.module.xyz
        axes = matrix(self.module.wxyz(properties.principal_inertia_local_frame))
        inertia = axes @ np.diag(xyz(properties.principal_inertia)) @ axes.T
        return body.mass, xyz(properties.local_com), inertia

    def _rotor(self, body: Any, joint: Any) -> HeldRotor:
        """Return a rotor as Rapier holds it, in the axes and from the origin of the scene's body.

        The axes of the two bodies coincide at the start, so that the rotor's tensor needs no
        rotation.

        Parameters
        ----------
        body : the rotor's body
        joint : the joint between the scene's body and the rotor
        """
        (mass, com, inertia), hinge, xyz = self._mass_of(body), joint.data, self.module.xyz
        place = xyz(hinge.local_anchor1) + com - xyz(hinge.local_anchor2)
        turns = self.module.count(hinge.locked_axes) < EVERY
        # The axis is taken from the joint's frame: Rapier adds the anchor to its `local_axis1`.
        axis = matrix(self.module.wxyz(hinge.local_frame1.rotation))[:, 0] * turns
        return HeldRotor(mass, place, inertia, axis)

    def advance(self, steps: int) -> None:
        """Take steps; raise `EngineError` if Rapier then reports numbers that are not finite."""
        self.world.advance(steps)
        self.check()

    def check(self) -> None:
        """Raise `EngineError` if Rapier has quarantined a body: its numbers are not finite."""
        if self.world.quarantined:
            raise EngineError("Rapier has quarantined the body: not finite", "not-finite")

    def active(self) -> frozenset[str]:
        """Return names of the effects that act, and descriptions of all else that acts.

        Both are read from Rapier.
        """
        body, world, scenario = self.world.body, self.world.world, self.scenario
        motion = self.world.motion()
        wanted = push(self.scene, matrix(motion[:4]), motion[4:7])
        self.world.push()
        got = self.module.xyz(body.user_torque)
        torque = np.linalg.norm(got - wanted) <= SLACK * np.linalg.norm(got)
        gravity = self.module.xyz(world.gravity) * body.gravity_scale
        right = np.allclose(gravity, scenario.gravity_world, rtol=SLACK, atol=0)
        locked = self.world.joint and self.module.count(self.world.joint.data.locked_axes)
        rotors = self.world.rotors
        bodies = [body, *(rotor for rotor, _ in rotors)]
        named = {
            "gravity" if right else f"a gravity of {gravity.tolist()} m/s²": gravity.any(),
            "pivot": locked == 3,
            "table": locked == 1,
            "rotors": bool(rotors),
            **dict.fromkeys(self._wrong_hinges(), True),
            "joints": len(world.impulse_joints) != len(rotors) + bool(locked),
            "joints that are springs": any(map(self.module.is_soft, self.world.joints())),
            "multibody joints": len(world.multibody_joints) > 0,
            f"a torque of {got.tolist()} N m": not torque,
            "damping": any(one.linear_damping or one.angular_damping for one in bodies),
            "sleeping": body.activation.angular_threshold > 0,
            "a collision shape": len(world.colliders) > 0,
            "no gyroscopic torque": not body.gyroscopic_forces_enabled,
            "a rotation clamp": not body.allow_fast_rotation,
        }
        acting = {name for name, acts in named.items() if acts}
        stated_effects = scenario.called_for & scenario.pushed.keys()
        return frozenset(acting | stated_effects if got.any() else acting)

    def _wrong_hinges(self) -> Iterator[str]:
        """Yield, in words, how the joints of rotors differ from what the scene states."""
        described = self.scene.get("rotors", ())
        for number, (rotor, (_, joint)) in enumerate(
            zip(described, self.world.rotors, strict=True), 1
        ):
            hinge, locked = rotor["hinge"], self.module.count(joint.data.locked_axes)
            if locked != EVERY - (hinge != "locked"):
                yield f"rotor {number} on a {hinge} hinge that locks {locked} axes"
            if joint.data.motor_axes.is_empty() == (hinge == "driven"):
                how = "without" if hinge == "driven" else "with"
                yield f"rotor {number} {how} a drive on a {hinge} hinge"


@final
class Rapier3D(WorldEngine):
    """The engine Rapier, with rigid bodies held together by impulse joints."""

    session = Rapier3DSession
    name = "rapier3d"
    package = "rapier3d"
    single_precision = True
    # The default of IntegrationParameters.dt, from Rapier's documentation.
    stock_timestep = 1 / 60
    methods = (
        Method(
            "impulse",
            1,
            1,
            "semi-implicit Euler, the pivot as an impulse joint",
            EFFECTS,
            setup=AWAKE,
        ),
        Method(
            "default",
            1,
            1,
            "as shipped: may fall asleep, and clamps the rotation a step",
            EFFECTS,
            max_rotation_per_step=MOST_ROTATION_A_STEP,
            clamps_parts=True,
            as_shipped=True,
        ),
    )
