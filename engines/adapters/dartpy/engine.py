"""DART, multibody dynamics in joint coordinates, in double precision.

What it does to a top by default, and how each effect was measured: docs/engines-more.md.
"""

from importlib import import_module
from importlib.metadata import version
from typing import Any, final

import numpy as np

from ....scenarios import FloatArray, Scenario
from ...checks.read_back import BodyReading
from ...engine import Engine, Method
from ...matrix_session import MatrixReading, MatrixSession
from ...session import Session
from .script import script
from .start import start_of

EFFECTS = frozenset({"gravity", "pivot", "drag", "torque_body", "torque_world"})
TORQUES = frozenset({"torque_body", "torque_world"})
#: Number of coordinates that turn the body; they come first in a joint.
TURNING = 3
#: Relative rounding of a torque that was rotated twice.
SLACK = 16 * float(np.finfo(float).eps)


@final
class Dart(Engine):
    """A body on a free joint, or on a ball joint at its pivot."""

    name = "dartpy"
    package = "dartpy"
    step_seconds = 2e-6
    # getTimeStep() of a new World.
    stock_timestep = 1e-3
    methods = (
        Method("semi-implicit", 1, 1, "semi-implicit Euler in joint coordinates", EFFECTS),
        Method("default", 1, 1, "as shipped: may fall asleep", EFFECTS, as_shipped=True),
    )

    @property
    def version(self) -> str:
        """Of the installed package."""
        return version("dartpy")

    def open(self, scenario: Scenario, method: Method, timestep: float) -> Session:
        """Build a world with the body on its joint."""
        return DartSession(scenario, method.as_shipped, timestep)

    def script(self, scenario: Scenario, method: Method, timestep: float) -> str:  # noqa: ARG002
        """The world as Python."""
        return script(scenario, method.as_shipped)


@final
class DartSession(MatrixSession):
    """One body in a world of its own; its frame is the scene's body frame."""

    def __init__(self, scenario: Scenario, as_shipped: bool, timestep: float) -> None:
        dart: Any = import_module("dartpy")
        self._scenario = scenario
        self._world = dart.simulation.World("spincheck")
        self._world.setTimeStep(timestep)
        # dartpy refuses read-only arrays, as the scene's are.
        self._world.setGravity(np.array(scenario.gravity_world))
        if not as_shipped:
            deactivation = self._world.getDeactivationOptions()
            deactivation.mEnabled = False
            self._world.setDeactivationOptions(deactivation)
        skeleton = dart.dynamics.Skeleton("top")
        kind = "Ball" if scenario.has_pivot else "Free"
        self._joint, self._body = getattr(skeleton, f"create{kind}JointAndBodyNodePair")()
        body = scenario.body
        com, inertia_com = np.array(body.com), np.array(body.inertia_com)
        self._body.setInertia(dart.dynamics.Inertia(body.mass, com, inertia_com))
        for coordinate in range(TURNING):
            self._joint.setDampingCoefficient(coordinate, scenario.drag)
        _set_start(dart, self._joint, scenario)
        self._world.addSkeleton(skeleton)

    def read_body(self) -> BodyReading:
        """The body as its body node holds it; com from the joint."""
        held = self._body.getInertia()
        com, inertia = np.array(held.getLocalCOM()), np.array(held.getMoment())
        return BodyReading(float(held.getMass()), com, inertia)

    def read_matrix(self) -> MatrixReading:
        """The state now."""
        body = self._body
        return MatrixReading(
            np.array(body.getWorldTransform().rotation()),
            np.array(body.getSpatialVelocity()[:TURNING]),
            np.array(body.getCOM()),
            np.array(body.getCOMLinearVelocity()),
        )

    def advance(self, steps: int) -> None:
        """Step one by one: DART clears a torque after each step, so it is set again."""
        world, pushed = self._world, bool(self._scenario.called_for & TORQUES)
        for _ in range(steps):
            if pushed:
                self._push()
            world.step()

    def check(self) -> None:
        """Nothing to do: a state that is not finite raises when it is read."""

    def active(self) -> frozenset[str]:
        """What acts, as reported by world, joint and body node."""
        world, joint, scenario = self._world, self._joint, self._scenario
        gravity = np.array(world.getGravity()) * self._body.getGravityMode()
        right = np.array_equal(gravity, scenario.gravity_world)
        count = joint.getNumDofs()
        damping = [joint.getDampingCoefficient(k) for k in range(count)]
        is_drag = damping == [scenario.drag] * TURNING + [0.0] * (count - TURNING)
        torque, wanted = self._push(), self._torque()
        pushes = np.linalg.norm(torque - wanted) <= SLACK * np.linalg.norm(wanted)
        named = {
            "gravity" if right else f"a gravity of {gravity.tolist()} m/s²": gravity.any(),
            "drag" if is_drag else f"a joint damping of {damping} N m s": any(damping),
            "pivot": joint.getType() == "BallJoint",
            f"a torque of {torque.tolist()} N m": not pushes,
            "springs": any(joint.getSpringStiffness(k) for k in range(count)),
            "deactivation": world.getDeactivationOptions().mEnabled,
            "a collision shape": self._body.getNumShapeNodes() > 0,
        }
        acting = frozenset(name for name, acts in named.items() if acts)
        return acting | (scenario.called_for & TORQUES if torque.any() else frozenset())

    def close(self) -> None:
        """Drop the world."""
        del self._body, self._joint, self._world

    def _push(self) -> FloatArray:
        """Apply the scene's torques; returns what the body node then holds, N m, world axes."""
        body, scenario = self._body, self._scenario
        body.clearExternalForces()
        body.addExtTorque(np.array(scenario.torque_body), True)
        body.addExtTorque(np.array(scenario.torque_world), False)
        return np.array(body.getExternalForceGlobal()[:TURNING])

    def _torque(self) -> FloatArray:
        """The torque that the scene has, N m, world axes."""
        R_world_body = np.array(self._body.getWorldTransform().rotation())
        return np.asarray(R_world_body @ self._scenario.torque_body + self._scenario.torque_world)


def _set_start(dart: Any, joint: Any, scenario: Scenario) -> None:
    start = start_of(scenario)
    if scenario.has_pivot:
        joint.setPositions(start.rotation_vector)
        joint.setVelocities(start.omega_body)
        return
    joint.setTransform(dart.math.Isometry3(start.R_world_body, start.origin_world))
    world, body = dart.dynamics.Frame.World(), joint.getChildBodyNode()
    joint.setSpatialVelocity(np.array([*start.omega_body, *start.velocity_body]), world, body)
