"""A scene as plain numbers, which engines in other languages and stand-alone modules are given.

SI units, along the body's principal axes and from its centre of mass:
docs/reference/engine-protocol.md.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from ..scenarios import FloatArray, Scenario
from ..scenarios.rotation import matrices, times, turned_back
from .checks.read_back import BodyReading, State, start_state
from .models.principal_frame import principal_frame

#: The keys of a record, and what they hold, as scripts say it.
ABOUT = {
    "mass": "kg",
    "moments": "kg m^2, principal: the axes here are principal ones, from the com",
    "axes": "w x y z, these axes in the body's own",
    "arm": "m, from the com to the pivot, if there is one",
    "gravity": "m/s^2",
    "drag": "N m s",
    "torque_body": "N m",
    "torque_world": "N m",
    "q": "w x y z, axes to world",
    "omega": "rad/s, world axes",
    "com": "m",
    "velocity": "m/s",
}


@dataclass(frozen=True, eq=False)
class RecordFrame:
    """Takes motions and bodies from a scene's body axes to those of its record, and back.

    Attributes
    ----------
    body_from_axes : takes components along the principal axes to body components
    com_body : m, from the origin of the scene's body
    """

    body_from_axes: Rotation
    com_body: FloatArray

    @classmethod
    def of(cls, scenario: Scenario) -> "RecordFrame":
        """The frame of a scene's record."""
        axes = principal_frame(scenario.body).q_body_axes_wxyz
        return cls(Rotation.from_quat(axes, scalar_first=True), scenario.body.com)

    def motion(self, state: State) -> dict[str, list[float]]:
        """A state as a record has it: `q`, `omega`, `com`, `velocity`."""
        world_from_body = Rotation.from_quat(state.q_world_body_wxyz, scalar_first=True)
        return {
            "q": _numbers((world_from_body * self.body_from_axes).as_quat(scalar_first=True)),
            "omega": _numbers(world_from_body.apply(np.array(state.omega_body))),
            "com": _numbers(state.com_world),
            "velocity": _numbers(state.velocity_world),
        }

    def states(self, rows: FloatArray) -> State:
        """The states of n motions, each a row of `q`, `omega`, `com` and `velocity`, (n, 13)."""
        q_world_axes, omega_world, com_world, velocity_world = np.split(rows, (4, 7, 10), axis=1)
        axes_from_body = self.body_from_axes.inv().as_quat(scalar_first=True)
        q_world_body = q_world_axes @ times(axes_from_body)
        omega_body = turned_back(matrices(q_world_body), omega_world)
        return State(q_world_body, omega_body, com_world, velocity_world)

    def body(
        self,
        mass: float,
        com: Sequence[float] | FloatArray,
        inertia_com: FloatArray,
        arm: Sequence[float] | FloatArray | None,
    ) -> BodyReading:
        """A body that an engine holds, in the scene's body axes and from its origin.

        Parameters
        ----------
        com, arm : m, from the origin of the engine's body, (3,); where it is held, None if it is
            free
        inertia_com : kg m², (3, 3)
        """
        # The origin is where the body is held; of a free one, where the scene has it.
        pivot_body = -self.com_body if arm is None else self.body_from_axes.apply(np.array(arm))
        R_body_axes = self.body_from_axes.as_matrix()
        com_body = self.body_from_axes.apply(np.array(com)) - pivot_body
        return BodyReading(float(mass), com_body, R_body_axes @ inertia_com @ R_body_axes.T)


def scene_record(scenario: Scenario) -> dict[str, Any]:
    """What `ABOUT` names, as numbers and lists of numbers; `arm` is None without a pivot."""
    body, frame = scenario.body, RecordFrame.of(scenario)
    to_axes, is_pivot = frame.body_from_axes.inv(), scenario.constraint.is_pivot
    return {
        "mass": float(body.mass),
        "moments": _numbers(principal_frame(body).moments),
        "axes": _numbers(principal_frame(body).q_body_axes_wxyz),
        "arm": _numbers(to_axes.apply(-np.array(body.com))) if is_pivot else None,
        "gravity": _numbers(scenario.gravity_world),
        "drag": float(scenario.pushed["drag"]),
        "torque_body": _numbers(to_axes.apply(np.array(scenario.pushed["torque_body"]))),
        "torque_world": _numbers(scenario.pushed["torque_world"]),
        **frame.motion(start_state(scenario)),
    }


def _numbers(vector: FloatArray) -> list[float]:
    return [float(value) for value in vector]
