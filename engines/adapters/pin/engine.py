"""Pinocchio, rigid-body dynamics without integrators of its own, in double precision.

What is judged is its forward dynamics (articulated-body algorithm), stepped as its examples do and
by a Runge-Kutta rule. How each effect was measured: docs/engines-more.md.
"""

import math
from importlib import import_module
from importlib.metadata import version
from typing import Any, final

import numpy as np

from ....scenarios import FloatArray, Scenario
from ...checks.read_back import BodyReading, EngineError, State
from ...engine import Engine, Method
from ...session import Session
from .script import script
from .start import start_of

EFFECTS = frozenset({"gravity", "pivot", "drag", "torque_body", "torque_world"})
#: Effects that are given to `aba` as a force; the others are in the model.
PUSHES = frozenset({"drag", "torque_body", "torque_world"})
#: The classical Runge-Kutta rule (Hairer, Nørsett & Wanner I, II.1): nodes of the stages, and their
#: weights in sixths.
STAGES = ((0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0))


@final
class Pinocchio(Engine):
    """A body on a free-flyer joint, or on a spherical joint at its pivot."""

    name = "pin"
    package = "pinocchio"
    step_seconds = 30e-6
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

    @property
    def version(self) -> str:
        """Of the installed package."""
        return version("pin")

    def open(self, scenario: Scenario, method: Method, timestep: float) -> Session:
        """Build a model of one joint and its body."""
        return PinocchioSession(scenario, method.name, timestep)

    def script(self, scenario: Scenario, method: Method, timestep: float) -> str:  # noqa: ARG002
        """The model and its steps as Python."""
        return script(scenario, method.name)


@final
class PinocchioSession(Session):
    """One body; its joint's frame is the scene's body frame."""

    def __init__(self, scenario: Scenario, method: str, timestep: float) -> None:
        self._pin: Any = import_module("pinocchio")
        pin, body = self._pin, scenario.body
        self._scenario, self._timestep = scenario, timestep
        self._is_pushed = bool(scenario.called_for & PUSHES)
        self._step = self._runge_kutta if method == "RK4" else self._semi_implicit
        self._model = pin.Model()
        joint = pin.JointModelSpherical() if scenario.has_pivot else pin.JointModelFreeFlyer()
        number = self._model.addJoint(0, joint, pin.SE3.Identity(), "top")
        held = pin.Inertia(body.mass, np.array(body.com), np.array(body.inertia_com))
        self._model.appendBodyToJoint(number, held, pin.SE3.Identity())
        self._model.gravity.linear = np.array(scenario.gravity_world)
        self._data = self._model.createData()
        self._q, self._v = start_of(scenario)

    def read_body(self) -> BodyReading:
        """The body as the model holds it; com from the joint."""
        held = self._model.inertias[1]
        return BodyReading(float(held.mass), np.array(held.lever), np.array(held.inertia))

    def read_state(self) -> State:
        """The state now."""
        if not (np.isfinite(self._q).all() and np.isfinite(self._v).all()):
            raise EngineError("the state is no longer finite", "not-finite")
        lever = self._model.inertias[1].lever
        self._pin.forwardKinematics(self._model, self._data, self._q, self._v)
        placed, moving = self._data.oMi[1], self._data.v[1]
        R_world_body, omega_body = np.array(placed.rotation), np.array(moving.angular)
        x, y, z, w = self._q[-4:]
        return State(
            np.array((w, x, y, z)) / np.linalg.norm(self._q[-4:]),
            omega_body,
            np.asarray(placed.act(lever)),
            R_world_body @ (moving.linear + np.cross(omega_body, lever)),
        )

    def advance(self, steps: int) -> None:
        """Step one by one: Pinocchio has no native loop."""
        for _ in range(steps):
            self._step()

    def check(self) -> None:
        """Nothing to do: a state that is not finite raises when it is read."""

    def active(self) -> frozenset[str]:
        """Gravity and pivot as in the model; torques as passed to `aba`."""
        model, scenario = self._model, self._scenario
        gravity = np.array(model.gravity.vector)
        right = np.array_equal(gravity, [*scenario.gravity_world, 0.0, 0.0, 0.0])
        named = {
            "gravity" if right else f"a gravity of {gravity.tolist()} m/s²": gravity.any(),
            "pivot": model.joints[1].shortname() == "JointModelSpherical",
            "more bodies": model.njoints > 2,
            "drag": scenario.drag > 0,
            "torque_body": scenario.torque_body.any(),
            "torque_world": scenario.torque_world.any(),
            "armature": model.armature.any(),
            "joint friction": model.damping.any() or model.friction.any(),
        }
        return frozenset(name for name, acts in named.items() if acts)

    def close(self) -> None:
        """Drop the model."""
        del self._data, self._model

    def _semi_implicit(self) -> None:
        self._v = self._v + self._timestep * self._acceleration(self._q, self._v)
        self._q = self._pin.integrate(self._model, self._q, self._timestep * self._v)

    def _runge_kutta(self) -> None:
        """A Runge-Kutta step of position, quaternion (as plain numbers) and velocity."""
        h, q, v = self._timestep, self._q, self._v
        q_rate, v_rate = np.zeros(len(q)), np.zeros(len(v))
        q_gain, v_gain = np.zeros(len(q)), np.zeros(len(v))
        for at, weight in STAGES:
            stage_q, stage_v = _normalised(q + at * h * q_rate), v + at * h * v_rate
            q_rate = self._rate(stage_q, stage_v)
            v_rate = self._acceleration(stage_q, stage_v)
            q_gain += weight * q_rate
            v_gain += weight * v_rate
        self._q, self._v = _normalised(q + h / 6 * q_gain), v + h / 6 * v_gain

    def _rate(self, q: FloatArray, v: FloatArray) -> FloatArray:
        """Time derivative of the coordinates; of the quaternion, half its product with ω."""
        # As Python's floats: numpy's cost several times as much one by one.
        (x, y, z, w), (a, b, c) = q[-4:].tolist(), v[-3:].tolist()
        turning = (
            w * a + y * c - z * b,
            w * b + z * a - x * c,
            w * c + x * b - y * a,
            -x * a - y * b - z * c,
        )
        is_held = len(q) == len(turning)
        moving = () if is_held else self._pin.Quaternion(q[-4:]).matrix() @ v[:-3]
        return np.array([*moving, *(part / 2 for part in turning)])

    def _acceleration(self, q: FloatArray, v: FloatArray) -> FloatArray:
        push = np.zeros(len(v))
        if self._is_pushed:
            scenario = self._scenario
            R_world_body = self._pin.Quaternion(q[-4:]).matrix()
            push[-3:] = scenario.torque_body - scenario.drag * v[-3:]
            push[-3:] += R_world_body.T @ scenario.torque_world
        return np.asarray(self._pin.aba(self._model, self._data, q, v, push))


def _normalised(q: FloatArray) -> FloatArray:
    q[-4:] /= math.sqrt(q[-4:] @ q[-4:])
    return q
