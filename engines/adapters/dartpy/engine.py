"""DART, multibody dynamics in joint coordinates, in double precision.

docs/measured/engines-more.md says what the engine does to a top by default, and how effects were
measured.
"""

from collections.abc import Iterator
from typing import Any, final

import numpy as np
from spincheck.engine import COMMON_EFFECTS, Method

from ...scene_record import HeldRotor, WorldBody
from ...world_engine import WorldEngine
from ...world_session import WorldSession

#: A table is modelled as a planar slide under a ball joint, a rotor's hinge as a revolute joint.
EFFECTS = COMMON_EFFECTS | {"rotors", "table"}
#: Number of components of the torque, which comes first in an external force.
TURNING = 3
#: Code by which users set the timestep and keep bodies from falling asleep (being deactivated).
AWAKE = """\
world.setTimeStep(TIMESTEP)
options = world.getDeactivationOptions()
options.mEnabled = False
world.setDeactivationOptions(options)"""


@final
class DartSession(WorldSession):
    """A session of one body in a DART world of its own; the body's origin is at its joint."""

    def world_body(self) -> WorldBody:
        """Return the body as DART holds it: mass, com, tensor, held point and rotors.

        The origin is the joint; axes are those of the scene record.
        """
        inertia = self.world.body.getInertia()
        arm = None if self.world.is_free else np.zeros(3)
        mass = inertia.getMass(), inertia.getLocalCOM(), np.array(inertia.getMoment())
        return WorldBody(*mass, arm, [_rotor(*rotor) for rotor in self.world.rotors])

    def active(self) -> frozenset[str]:
        """Return names of the effects that act, and descriptions of all else that acts.

        Both are read from DART.
        """
        world, joint = self.world.world, self.world.joint
        gravity = np.array(world.getGravity()) * self.world.body.getGravityMode()
        count = joint.getNumDofs()
        damping = [joint.getDampingCoefficient(k) for k in range(count)]
        self.world.push()
        named = {
            **self.gravity_by(gravity),
            **self.damped_by(damping),
            **self._joints(),
            **self.pushed_by(np.array(self.world.body.getExternalForceGlobal()[:TURNING])),
            "springs": any(joint.getSpringStiffness(k) for k in range(count)),
            "deactivation": world.getDeactivationOptions().mEnabled,
            "a collision shape": self.world.body.getNumShapeNodes() > 0,
        }
        return frozenset(name for name, acts in named.items() if acts)

    def _joints(self) -> dict[str, bool]:
        """Return effects and faults that joints may have, by name, each with whether it is there.

        The names are the effects "pivot", "table" and "rotors", and the fault "other bodies". A
        description of each way in which a rotor's joint differs from the scene is added, with the
        value true.
        """
        slide, rotors = self.world.slide, self.world.rotors
        count = self.world.skeleton.getNumBodyNodes()
        turns = self.world.joint.getType() == "BallJoint"
        slides = slide is not None and slide.getType() == "TranslationalJoint2D"
        return {
            "pivot": turns and slide is None,
            "table": turns and slides,
            "rotors": bool(rotors),
            **dict.fromkeys(self._wrong_hinges(), True),
            "other bodies": count != 1 + (slide is not None) + len(rotors),
        }

    def _wrong_hinges(self) -> Iterator[str]:
        """Yield, in words, how the joints of rotors differ from what the scene states."""
        kinds = self.module.dart.dynamics.ActuatorType
        described = self.scene.get("rotors", ())
        rows = enumerate(zip(described, self.world.rotors, strict=True), start=1)
        for number, (rotor, (joint, node)) in rows:
            if not joint.getNumDofs():
                continue
            wanted = kinds.ACCELERATION if rotor["hinge"] == "driven" else kinds.FORCE
            if joint.getActuatorType() != wanted or joint.getCommand(0):
                yield f"rotor {number} with another actuator than that of a {rotor['hinge']} hinge"
            if joint.getDampingCoefficient(0) or joint.getSpringStiffness(0):
                yield f"damping or a spring on the hinge of rotor {number}"
            if joint.getCoulombFriction(0):
                yield f"friction on the hinge of rotor {number}"
            if np.any(node.getInertia().getLocalCOM()):
                yield f"rotor {number} on a hinge beside its centre of mass"


def _rotor(joint: Any, node: Any) -> HeldRotor:
    """Return a rotor as DART holds it, at joint angle 0, in the frame of the body that carries it.

    Parameters
    ----------
    joint : the joint between the rotor and the body
    node : the rotor's own body node
    """
    inertia, at = node.getInertia(), joint.getTransformFromParentBodyNode()
    R = np.array(at.rotation())
    com = np.array(at.translation()) + R @ inertia.getLocalCOM()
    tensor = R @ np.array(inertia.getMoment()) @ R.T
    axis = R @ joint.getAxis() if joint.getNumDofs() else np.zeros(3)
    return HeldRotor(inertia.getMass(), com, tensor, axis)


@final
class Dart(WorldEngine):
    """The engine DART, with the body on a free joint, or on a ball joint where it is held."""

    session = DartSession
    name = "dartpy"
    package = "dartpy"
    # What getTimeStep() of a new World returns.
    stock_timestep = 1e-3
    methods = (
        Method(
            "semi-implicit",
            1,
            1,
            "semi-implicit Euler in joint coordinates",
            EFFECTS,
            setup=AWAKE,
        ),
        Method("default", 1, 1, "as shipped: may fall asleep", EFFECTS, as_shipped=True),
    )
