"""A scene record: a scene as plain numbers, for engines in other languages and for scripts.

Numbers are in SI units. The axes are the principal axes of the body without its rotors, and the
origin is its centre of mass (docs/reference/engine-protocol.md).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation
from spincheck.engine import BodyReading, FloatArray, Rotor, Scenario, State, composed, start_state

from ..scenarios.rotation import cross, matrices, matrix, times, turned, turned_back
from .models.principal_frame import principal_frame

#: The keys of a record, each with the comment by which scripts explain it.
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
    """A rotor as an engine holds it; vectors are along the axes of the body that carries it.

    Attributes
    ----------
    mass : mass, kg
    com : the rotor's com, from the origin of the body that carries it, m, (3,)
    inertia_com : the rotor's tensor about its own com, kg m², (3, 3)
    axis : the axis that it turns about, a unit vector, (3,), or zeros if the hinge is locked
    """

    mass: float
    com: FloatArray
    inertia_com: FloatArray
    axis: FloatArray


class WorldBody(NamedTuple):
    """A body as an engine holds it, in the axes and from the origin of the engine's body.

    Attributes
    ----------
    mass : mass without the rotors, kg
    com : com without the rotors, m, (3,)
    inertia_com : tensor of inertia without the rotors, about that com, kg m², (3, 3)
    arm : the point where the body is held, m, (3,); None if the body is free
    rotors : the rotors that the body carries
    """

    mass: float
    com: Sequence[float] | FloatArray
    inertia_com: FloatArray
    arm: Sequence[float] | FloatArray | None
    rotors: Sequence[HeldRotor] = ()


@dataclass(frozen=True, eq=False)
class RecordFrame:
    """Converts motions and bodies between a scene's body axes and the axes of its record.

    Attributes
    ----------
    body_from_axes : the rotation that takes components along the record's axes, which are the
        principal axes of the body without rotors, to components along the scene's body axes
    com_body : com of the body without rotors, m, body axes, from the body's origin, (3,)
    held_body : the point that is held, in the same units and axes; the origin if the body is free
    whole_body : com of the body with rotors, in the same units and axes
    """

    body_from_axes: Rotation
    com_body: FloatArray
    held_body: FloatArray
    whole_body: FloatArray

    @classmethod
    def of(cls, scenario: Scenario) -> "RecordFrame":
        """Return the frame of a scene's record."""
        axes = principal_frame(scenario.carrier).q_body_axes_wxyz
        whole = scenario.body.com
        point = whole - scenario.constraint.lever
        return cls(Rotation.from_quat(axes, scalar_first=True), scenario.carrier.com, point, whole)

    @cached_property
    def _axes_after(self) -> FloatArray:
        """The matrix M, (4, 4), with q M the attitude of the record's axes if the body's is q."""
        return times(self.body_from_axes.as_quat(scalar_first=True))

    @cached_property
    def _lag_body(self) -> FloatArray:
        """The vector from the com with rotors to the com without them, m, body axes, (3,)."""
        return self.com_body - self.whole_body

    def motion(self, state: State) -> dict[str, list[float]]:
        """Return a state as entries of a scene record: `q`, `omega`, `com`, `velocity` and `spins`.

        `spins` is left out if there are no rotors. `q` is the attitude of the record's axes,
        w x y z, and vectors are along world axes. Com and velocity are those of the body without
        rotors.
        """
        q_world_body = np.asarray(state.q_world_body_wxyz, dtype=float)
        omega_body = np.asarray(state.omega_body, dtype=float)
        # An engine's own quaternions may not be of unit length.
        q_world_body = q_world_body / np.sqrt(q_world_body @ q_world_body)
        R_world_body = matrix(q_world_body)
        com_world, velocity_world = state.com_world, state.velocity_world
        if self._lag_body.any():
            com_world = com_world + R_world_body @ self._lag_body
            swing_body = cross(omega_body, self._lag_body)
            velocity_world = velocity_world + R_world_body @ swing_body
        motion = {
            "q": (q_world_body @ self._axes_after).tolist(),
            "omega": (R_world_body @ omega_body).tolist(),
            "com": _numbers(com_world),
            "velocity": _numbers(velocity_world),
        }
        return motion | ({"spins": _numbers(state.spins)} if state.spins.size else {})

    def states(self, rows: FloatArray) -> State:
        """Return n states of the scene, given by numbers of its record: the inverse of `motion`.

        Parameters
        ----------
        rows : `q`, `omega`, `com`, `velocity` and `spins` in this order, a state in each row,
            (n, 13 + rotors)
        """
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
        """Return an engine's body, with its rotors, in the axes and origin of the scene's body.

        In mass, com and tensor the rotors count as fixed parts of the body.
        """
        alone = BodyReading(float(body.mass), np.array(body.com), np.array(body.inertia_com))
        rotors = [BodyReading(one.mass, one.com, one.inertia_com) for one in body.rotors]
        reading = with_rotors([alone, *rotors], [one.axis for one in body.rotors])
        R_body_axes, arm = self.body_from_axes.as_matrix(), body.arm
        # Place of the engine's origin: where the held points coincide, or for a free body at the
        # record's origin.
        at = self.com_body if arm is None else self.held_body - R_body_axes @ np.array(arm)
        return reading.placed(at, R_body_axes)


def with_rotors(
    parts: Sequence[BodyReading], axes: Sequence[FloatArray] | FloatArray
) -> BodyReading:
    """Return a body and its rotors, joined rigidly, as one body with the rotors' axial moments.

    Parameters
    ----------
    parts : the body, or several that form it, then the rotors; all in the same axes and from the
        same origin
    axes : the axis that each rotor turns about, a unit vector, or zeros if it is locked,
        (rotors, 3)
    """
    if len(parts) == 1:
        return parts[0]
    rotors = parts[len(parts) - len(axes) :]
    axial = [
        axis * (axis @ rotor.inertia_com @ axis) for axis, rotor in zip(axes, rotors, strict=True)
    ]
    return replace(composed(parts), axial=np.reshape(axial, (-1, 3)))


def scene_record(scenario: Scenario) -> dict[str, Any]:
    """Return a scene's record: the body, what acts on it, and its start, in SI units.

    The body has `mass`, `moments`, `axes` and `arm`, which is None if the body is free. What acts
    on it is `gravity`, `drag`, `torque_body` and `torque_world`. The start is `q`, `omega`, `com`
    and `velocity`. `slides` and `height` are there only for a body on a table, `rotors` and `spins`
    only for one with rotors. `ABOUT` says what each value means.
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
    """Return a rotor's entry in a scene record, in the record's axes and from its origin.

    It has `axis`, a unit vector; `place`, the rotor's com, m; `mass`, kg; `inertia`, the moments
    across and along the axis, kg m²; and `hinge`, "free", "driven" or "locked". `frame` is the
    frame of the scene's record.
    """
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
    """Return a vector as a list of Python's floats."""
    return [float(value) for value in vector]
