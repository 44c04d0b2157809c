"""DART, multibody dynamics in joint coordinates, in double precision.

What it does to a top by default, and how each effect was measured: docs/measured/engines-more.md.
"""

from typing import final

import numpy as np

from ...engine import COMMON_EFFECTS, Method
from ...world_engine import WorldEngine
from ...world_session import WorldBody, WorldSession

TORQUES = frozenset({"torque_body", "torque_world"})
#: Number of coordinates that turn the body; they come first in a joint.
TURNING = 3
#: Relative rounding of a torque that was rotated twice.
SLACK = 16 * float(np.finfo(float).eps)
#: How users keep bodies from falling asleep.
AWAKE = """\
world.setTimeStep(TIMESTEP)
options = world.getDeactivationOptions()
options.mEnabled = False
world.setDeactivationOptions(options)"""


@final
class DartSession(WorldSession):
    """One body in a world of its own; its frame is at the joint."""

    def world_body(self) -> WorldBody:
        """The body as its body node holds it, from the joint."""
        inertia = self.world.body.getInertia()
        arm = np.zeros(3) if self.scenario.constraint.is_pivot else None
        return WorldBody(
            inertia.getMass(), inertia.getLocalCOM(), np.array(inertia.getMoment()), arm
        )

    def active(self) -> frozenset[str]:
        """What acts, as reported by world, joint and body node."""
        world, joint, scenario = self.world.world, self.world.joint, self.scenario
        gravity = np.array(world.getGravity()) * self.world.body.getGravityMode()
        right = np.array_equal(gravity, scenario.gravity_world)
        count = joint.getNumDofs()
        damping = [joint.getDampingCoefficient(k) for k in range(count)]
        wanted = self.constant_push()
        self.world.push()
        torque = np.array(self.world.body.getExternalForceGlobal()[:TURNING])
        pushes = np.linalg.norm(torque - wanted) <= SLACK * np.linalg.norm(wanted)
        named = {
            "gravity" if right else f"a gravity of {gravity.tolist()} m/s²": gravity.any(),
            **self.damped_by(damping),
            "pivot": joint.getType() == "BallJoint",
            f"a torque of {torque.tolist()} N m": not pushes,
            "springs": any(joint.getSpringStiffness(k) for k in range(count)),
            "deactivation": world.getDeactivationOptions().mEnabled,
            "a collision shape": self.world.body.getNumShapeNodes() > 0,
        }
        acting = frozenset(name for name, acts in named.items() if acts)
        return acting | (scenario.called_for & TORQUES if torque.any() else frozenset())


@final
class Dart(WorldEngine):
    """A body on a free joint, or on a ball joint at its pivot."""

    session = DartSession
    name = "dartpy"
    package = "dartpy"
    step_seconds = 2e-6
    # getTimeStep() of a new World.
    stock_timestep = 1e-3
    methods = (
        Method(
            "semi-implicit",
            1,
            1,
            "semi-implicit Euler in joint coordinates",
            COMMON_EFFECTS,
            setup=AWAKE,
        ),
        Method("default", 1, 1, "as shipped: may fall asleep", COMMON_EFFECTS, as_shipped=True),
    )
