"""A scene as plain numbers, which engines in other languages and stand-alone modules are given.

SI units, along the body's principal axes and from its centre of mass:
docs/reference/engine-protocol.md.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation
from spincheck.engine import BodyReading, FloatArray, Rotor, Scenario, State, composed, start_state

from ..scenarios.rotation import cross, matrices, times, turned, turned_back
from .models.principal_frame import principal_frame

#: The keys of a record, and what they hold, as scripts say it.
ABOUT = {
    "mass": "kg",
    "moments": "kg m^2, principal: the axes here are principal ones, from the com",
    "axes": "w x y z, these axes in the body's own",
    "arm": "m, from the com to the point that is held, if there is one",
    "slides": "world axes along which that point may move",
    "height": "m, of that point along z",
    "gravity": "m/s^2",
    "drag": "N m s",
    "torque_body": "N m",
    "torque_world": "N m",
    "q": "w x y z, axes to world",
    "omega": "rad/s, world axes",
    "com": "m",
    "velocity": "m/s",
    "rotors": "axis, place and inertia (across, along the axis) in these axes",
    "spins": "rad/s",
}


class HeldRotor(NamedTuple):
    """A rotor as an engine holds it: m from the origin of the engine's body, kg m², its axes.

    `axis` is (3,), of zeros where the hinge is locked.
    """

    mass: float
    com: FloatArray
    inertia_com: FloatArray
    axis: FloatArray


class WorldBody(NamedTuple):
    """A body as an engine holds it; kg, kg m².

    `com` and `arm`, where it is held, None if it is free, are in m from the origin of the engine's
    body, (3,); `inertia_com` is (3, 3).
    """

    mass: float
    com: Sequence[float] | FloatArray
    inertia_com: FloatArray
    arm: Sequence[float] | FloatArray | None
    rotors: Sequence[HeldRotor] = ()


@dataclass(frozen=True, eq=False)
class RecordFrame:
    """Takes motions and bodies from a scene's body axes to those of its record, and back.

    Attributes
    ----------
    body_from_axes : takes components along the principal axes to body components
    com_body, held_body, whole_body : of the body without rotors, of the point of it that is held,
        and of it with its rotors, m, from the origin of the scene's body
    """

    body_from_axes: Rotation
    com_body: FloatArray
    held_body: FloatArray
    whole_body: FloatArray

    @classmethod
    def of(cls, scenario: Scenario) -> "RecordFrame":
        """The frame of a scene's record."""
        axes = principal_frame(scenario.carrier).q_body_axes_wxyz
        whole = scenario.body.com
        point = whole - scenario.constraint.lever
        return cls(Rotation.from_quat(axes, scalar_first=True), scenario.carrier.com, point, whole)

    @property
    def _lag_body(self) -> FloatArray:
        """The com without rotors, from that with them, m, body axes, (3,)."""
        return self.com_body - self.whole_body

    def motion(self, state: State) -> dict[str, list[float]]:
        """A state as a record has it: `q`, `omega`, `com`, `velocity`, of rotors also `spins`."""
        world_from_body = Rotation.from_quat(state.q_world_body_wxyz, scalar_first=True)
        com_world, velocity_world = state.com_world, state.velocity_world
        if self._lag_body.any():
            com_world = com_world + world_from_body.apply(self._lag_body)
            swing_body = cross(state.omega_body, self._lag_body)
            velocity_world = velocity_world + world_from_body.apply(swing_body)
        motion = {
            "q": _numbers((world_from_body * self.body_from_axes).as_quat(scalar_first=True)),
            "omega": _numbers(world_from_body.apply(np.array(state.omega_body))),
            "com": _numbers(com_world),
            "velocity": _numbers(velocity_world),
        }
        return motion | ({"spins": _numbers(state.spins)} if state.spins.size else {})

    def states(self, rows: FloatArray) -> State:
        """The states of n motions: rows of `q`, `omega`, `com`, `velocity` and `spins`."""
        q_world_axes, omega_world, com_world, velocity_world, spins = np.split(
            rows, (4, 7, 10, 13), axis=1
        )
        axes_from_body = self.body_from_axes.inv().as_quat(scalar_first=True)
        q_world_body = q_world_axes @ times(axes_from_body)
        R_world_body = matrices(q_world_body)
        omega_body = turned_back(R_world_body, omega_world)
        if self._lag_body.any():
            com_world = com_world - R_world_body @ self._lag_body
            swing_body = cross(omega_body, self._lag_body)
            velocity_world = velocity_world - turned(R_world_body, swing_body)
        return State(q_world_body, omega_body, com_world, velocity_world, spins)

    def body(self, body: WorldBody) -> BodyReading:
        """A body that an engine holds, in the scene's body axes and from its origin."""
        reading = BodyReading(float(body.mass), np.array(body.com), np.array(body.inertia_com))
        if body.rotors:
            axial = [one.axis * (one.axis @ one.inertia_com @ one.axis) for one in body.rotors]
            parts = [BodyReading(one.mass, one.com, one.inertia_com) for one in body.rotors]
            reading = replace(composed([reading, *parts]), axial=np.array(axial))
        R_body_axes, arm = self.body_from_axes.as_matrix(), body.arm
        # The origin is where the body is held; of a free one, where the scene has it.
        at = self.com_body if arm is None else self.held_body - R_body_axes @ np.array(arm)
        return reading.placed(at, R_body_axes)


def scene_record(scenario: Scenario) -> dict[str, Any]:
    """What `ABOUT` names, as numbers and lists of numbers; `arm` is None of a free body.

    With `slides` and `height` of a body on a table, with `rotors` and `spins` of one that has them.
    """
    body, frame, constraint = scenario.carrier, RecordFrame.of(scenario), scenario.constraint
    to_axes = frame.body_from_axes.inv()
    record: dict[str, Any] = {
        "mass": float(body.mass),
        "moments": _numbers(principal_frame(body).moments),
        "axes": _numbers(principal_frame(body).q_body_axes_wxyz),
        "arm": None if constraint.is_free else _numbers(to_axes.apply(frame.held_body - body.com)),
        "gravity": _numbers(scenario.gravity_world),
        "drag": float(scenario.pushed["drag"]),
        "torque_body": _numbers(to_axes.apply(np.array(scenario.pushed["torque_body"]))),
        "torque_world": _numbers(scenario.pushed["torque_world"]),
        **frame.motion(start_state(scenario)),
    }
    if not (constraint.is_free or constraint.is_pivot):
        record["slides"] = [axis for axis in range(3) if not constraint.is_held[axis]]
        record["height"] = float(constraint.place_exact[-1])
    if scenario.rotors:
        record["rotors"] = [_rotor(rotor, frame) for rotor in scenario.rotors.each]
    return record


def _rotor(rotor: Rotor, frame: RecordFrame) -> dict[str, Any]:
    to_axes = frame.body_from_axes.inv()
    axis, place = np.array(rotor.axis, dtype=float), rotor.body.com - frame.com_body
    return {
        "axis": _numbers(to_axes.apply(axis)),
        "place": _numbers(to_axes.apply(place)),
        "mass": float(rotor.mass),
        "inertia": [float(rotor.across), float(rotor.along)],
        "hinge": rotor.hinge,
    }


def _numbers(vector: FloatArray) -> list[float]:
    return [float(value) for value in vector]
