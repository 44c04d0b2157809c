"""Pinocchio, rigid-body dynamics without integrators of its own, in double precision.

What is judged is its forward dynamics (articulated-body algorithm), stepped as its examples do and
by a Runge-Kutta rule. How each effect was measured: docs/measured/engines-more.md.
"""

from typing import final

import numpy as np

from ....scenarios import PUSHED
from ...engine import COMMON_EFFECTS, Method
from ...world_engine import WorldEngine
from ...world_session import WorldBody, WorldSession


@final
class PinocchioSession(WorldSession):
    """One body; its joint is at the pivot, or else at the com."""

    def world_body(self) -> WorldBody:
        """The body as the model holds it, from the joint."""
        inertia = self.world.model.inertias[1]
        arm = None if self.world.is_free else np.zeros(3)
        return WorldBody(inertia.mass, np.array(inertia.lever), np.array(inertia.inertia), arm)

    def active(self) -> frozenset[str]:
        """Gravity and pivot as in the model; torques as passed to `aba`."""
        model, scenario = self.world.model, self.scenario
        gravity = np.array(model.gravity.vector)
        right = np.array_equal(gravity, [*scenario.gravity_world, 0.0, 0.0, 0.0])
        named = {
            "gravity" if right else f"a gravity of {gravity.tolist()} m/s²": gravity.any(),
            "pivot": model.joints[1].shortname() == "JointModelSpherical",
            "more bodies": model.njoints > 2,
            **dict.fromkeys(scenario.called_for & PUSHED, True),
            "armature": model.armature.any(),
            "joint friction": model.damping.any() or model.friction.any(),
        }
        return frozenset(name for name, acts in named.items() if acts)


@final
class Pinocchio(WorldEngine):
    """A body on a free-flyer joint, or on a spherical joint at its pivot."""

    session = PinocchioSession
    name = "pin"
    package = "pinocchio"
    step_seconds = 30e-6
    methods = (
        Method("semi-implicit", 1, 1, "aba, then integrate with the new velocity", COMMON_EFFECTS),
        Method("RK4", 4, 4, "aba, in classical Runge-Kutta steps of its state", COMMON_EFFECTS),
        Method(
            "default",
            1,
            1,
            "the loop of its examples, which is semi-implicit: it has no integrator",
            COMMON_EFFECTS,
            as_shipped=True,
        ),
    )
