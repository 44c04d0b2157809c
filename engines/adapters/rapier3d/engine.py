"""Rapier 3D, in single precision, from its Python package `rapier3d`.

What it does to a top by default, and how each effect was measured: docs/measured/engines-more.md.
"""

from math import pi
from typing import final

import numpy as np

from ....scenarios import PUSHED
from ...checks.read_back import EngineError
from ...method import COMMON_EFFECTS, Method
from ...scene_record import WorldBody
from ...world_engine import WorldEngine
from ...world_parts import matrix, push
from ...world_session import WorldSession

#: rad: ANGULAR_MOTION_THRESHOLD of its sources: by default a body turns no further in a step.
MOST_ROTATION_A_STEP = pi / 4
#: Relative rounding of numbers in single precision.
SLACK = 8 * float(np.finfo(np.float32).eps)
#: How users keep bodies from falling asleep, and from being clamped.
AWAKE = """\
world.integration_parameters.dt = TIMESTEP
body = rapier3d.RigidBody.dynamic().can_sleep(False).allow_fast_rotation(True)"""


@final
class Rapier3DSession(WorldSession):
    """One body, its origin the com."""

    def world_body(self) -> WorldBody:
        """Its principal moments in the axes that they belong to, and the joint's anchor."""
        properties, joint, xyz = self.world.body.mass_properties, self.world.joint, self.module.xyz
        axes = matrix(self.module.wxyz(properties.principal_inertia_local_frame))
        inertia = axes @ np.diag(xyz(properties.principal_inertia)) @ axes.T
        arm = None if joint is None else xyz(joint.data.local_anchor2)
        return WorldBody(self.world.body.mass, xyz(properties.local_com), inertia, arm)

    def advance(self, steps: int) -> None:
        """Step; Rapier reports a body whose numbers are not finite only after that step."""
        self.world.advance(steps)
        self.check()

    def check(self) -> None:
        """Raise if any step so far was quarantined."""
        if self.world.quarantined:
            raise EngineError("Rapier has quarantined the body: not finite", "not-finite")

    def active(self) -> frozenset[str]:
        """What acts, as reported by the world and the body."""
        body, world, scenario = self.world.body, self.world.world, self.scenario
        motion = self.world.motion()
        wanted = push(self.scene, matrix(motion[:4]), motion[4:7])
        self.world.push()
        got = self.module.xyz(body.user_torque)
        torque = np.linalg.norm(got - wanted) <= SLACK * np.linalg.norm(got)
        gravity = self.module.xyz(world.gravity) * body.gravity_scale
        right = np.allclose(gravity, scenario.gravity_world, rtol=SLACK, atol=0)
        named = {
            "gravity" if right else f"a gravity of {gravity.tolist()} m/s²": gravity.any(),
            "pivot": len(world.impulse_joints) == 1,
            "joints": len(world.impulse_joints) > 1 or len(world.multibody_joints) > 0,
            f"a torque of {got.tolist()} N m": not torque,
            "damping": body.linear_damping or body.angular_damping,
            "sleeping": body.activation.angular_threshold > 0,
            "a collision shape": len(world.colliders) > 0,
            "no gyroscopic torque": not body.gyroscopic_forces_enabled,
            "a rotation clamp": not body.allow_fast_rotation,
        }
        acting = {name for name, acts in named.items() if acts}
        stated_effects = scenario.called_for & PUSHED
        return frozenset(acting | stated_effects if got.any() else acting)


@final
class Rapier3D(WorldEngine):
    """Rapier's rigid bodies, a pivot as an impulse joint."""

    session = Rapier3DSession
    name = "rapier3d"
    package = "rapier3d"
    step_seconds = 6e-6
    single_precision = True
    # IntegrationParameters.dt of its documentation.
    stock_timestep = 1 / 60
    methods = (
        Method(
            "impulse",
            1,
            1,
            "semi-implicit Euler, the pivot as an impulse joint",
            COMMON_EFFECTS,
            setup=AWAKE,
        ),
        Method(
            "default",
            1,
            1,
            "as shipped: may fall asleep, and clamps the rotation a step",
            COMMON_EFFECTS,
            max_rotation_per_step=MOST_ROTATION_A_STEP,
            as_shipped=True,
        ),
    )
