"""Pinocchio, rigid-body dynamics without integrators of its own, in double precision.

What is judged is its forward dynamics (articulated-body algorithm), integrated as in its examples,
and by a Runge-Kutta rule. docs/measured/engines-more.md says how each effect was measured.
"""

from collections.abc import Mapping
from typing import final

import numpy as np
from spincheck.engine import (
    COMMON_EFFECTS,
    Derivative,
    FloatArray,
    Method,
    UnsupportedError,
    along,
)

from ...scene_record import HeldRotor, WorldBody
from ...world_engine import WorldEngine
from ...world_session import WorldSession

#: A table is modelled by two slides under a spherical joint, a rotor's hinge by a revolute joint.
EFFECTS = COMMON_EFFECTS | {"rotors", "table"}


@final
class PinocchioSession(WorldSession):
    """A session of one body in a Pinocchio model.

    The body's joint is at the point that is held, or at the com of a free body.
    """

    def world_body(self) -> WorldBody:
        """Return the body as the model holds it: mass, com, tensor, held point and rotors.

        The origin is the joint; axes are those of the scene record.
        """
        inertia = self.world.model.inertias[self.world.joint]
        arm = None if self.world.is_free else np.zeros(3)
        rotors = [self._rotor(joint) for joint in self.world.rotors]
        return WorldBody(
            inertia.mass, np.array(inertia.lever), np.array(inertia.inertia), arm, rotors
        )

    def _rotor(self, joint: int) -> HeldRotor:
        """Return the rotor on the joint with a given number, at joint angle 0.

        The number 0 stands for a locked rotor. Pinocchio has merged it into the body, and so the
        returned rotor has mass 0.
        """
        if not joint:
            return HeldRotor(0.0, np.zeros(3), np.zeros((3, 3)), np.zeros(3))
        model = self.world.model
        inertia, at = model.inertias[joint], model.jointPlacements[joint]
        R, axis = np.array(at.rotation), np.array(model.joints[joint].extract().axis)
        com = np.array(at.translation) + R @ inertia.lever
        return HeldRotor(inertia.mass, com, R @ inertia.inertia @ R.T, R @ axis)

    def derivatives(self) -> Mapping[str, Derivative]:
        """Return the derivative of dω/dt by `computeABADerivatives`; this name is its key."""
        return {"computeABADerivatives": Derivative(self._rate)}

    def _rate(self) -> FloatArray:
        """Return the derivative of dω/dt in the chart, (3, 6).

        It consists of blocks of ∂v'/∂q and ∂v'/∂v, where v has ω in body axes, and ∂q of the
        attitude is a turn in body axes, as in the chart. `UnsupportedError` is raised if the scene
        has torques or drag.
        """
        world = self.world
        if world.is_pushed:
            words = "the torques are its caller's, which computeABADerivatives does not see"
            raise UnsupportedError(words)
        rates = self.module.pinocchio.computeABADerivatives(
            world.model, world.data, world.q, world.v, np.zeros(world.model.nv)
        )
        turning = world.v_turning
        rate = np.hstack([one[turning, turning] for one in rates[:2]])
        return along(self.frame.body_from_axes.as_matrix(), rate)

    def active(self) -> frozenset[str]:
        """Return names of the effects that act, and descriptions of all else that acts.

        Both are read from the model, except torques and drag, which it does not hold: they are
        passed to `aba` in each step, and those of the scene are assumed to act.
        """
        model, scenario = self.world.model, self.scenario
        named = {
            **self.gravity_by(np.array(model.gravity.linear)),
            "a gravity that turns": np.any(model.gravity.angular),
            **self._joints(),
            **dict.fromkeys(scenario.called_for & scenario.pushed.keys(), True),
            "joint friction": model.damping.any() or model.friction.any(),
        }
        return frozenset(name for name, acts in named.items() if acts)

    def _joints(self) -> dict[str, bool]:
        """Return effects and faults that joints may have, by name, each with whether it is there.

        The names are the effects "pivot", "table" and "rotors", then descriptions of ways in which
        joints may differ from the scene. Joints before the body's own are slides, those
        after it are hinges of rotors.
        """
        world, model = self.world, self.world.model
        kinds = [joint.shortname() for joint in model.joints]
        hinges = [joint for joint in world.rotors if joint]
        beside = [joint for joint in hinges if model.inertias[joint].lever.any()]
        armature: FloatArray = np.zeros(model.nv)
        for rotor, joint in zip(self.scene.get("rotors", ()), world.rotors, strict=True):
            # A locked rotor has no joint.
            if joint:
                armature[model.joints[joint].idx_v] = self.module.drive(rotor)
        turns = kinds[world.joint] == "JointModelSpherical"
        return {
            "pivot": turns and world.joint == 1,
            "table": turns and kinds[1 : world.joint] == ["JointModelPrismaticUnaligned"] * 2,
            "rotors": bool(world.rotors),
            "a rotor on a hinge beside its centre of mass": bool(beside),
            "armature": not np.array_equal(model.armature, armature),
            "more bodies": model.njoints != world.joint + 1 + len(hinges),
        }


@final
class Pinocchio(WorldEngine):
    """The engine Pinocchio: a free body on a free-flyer joint, a held one on a spherical joint."""

    session = PinocchioSession
    name = "pin"
    package = "pinocchio"
    methods = (
        Method("semi-implicit", 1, 1, "aba, then integrate with the new velocity", EFFECTS),
        Method("RK4", 4, 4, "aba, in classical Runge-Kutta steps of its state", EFFECTS),
        Method(
            "default",
            1,
            1,
            "the loop of its examples, which is semi-implicit: it has no integrator",
            EFFECTS,
            as_shipped=True,
        ),
    )
