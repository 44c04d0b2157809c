"""A scene in a child process; converts between the scene's frames and the child's."""

import time
from collections.abc import Sequence
from typing import Any, final

import numpy as np
from scipy.spatial.transform import Rotation

from ...scenarios import FloatArray, Scenario
from ...scenarios.rotation import matrices, times, turned_back
from ..checks.read_back import BodyReading, EngineError, State
from ..models.principal_frame import principal_frame
from ..session import Session
from .messages import Active, Done, Opened, Seconds, StateRow, Stepped
from .process import ChildProcess, given_back

#: Largest number of steps a call, so that an answer comes within the time limit.
MOST_STEPS_A_CALL = 1 << 12
#: Relative amount by which a child's clock may run ahead of ours.
CLOCK_SLACK = 0.01


@final
class ChildSession(Session):
    """One scene in a child of its own.

    The child's body axes are the principal axes of the scene's body, their origin the com.

    Raises
    ------
    EngineError
        From any method: with the child's message, or how it broke the protocol.
    """

    def __init__(
        self, child: ChildProcess, scenario: Scenario, method: str, timestep: float
    ) -> None:
        self._child, self._scenario = child, scenario
        self._body_from_axes = _rotation(principal_frame(scenario.body).q_body_axes_wxyz)
        scene = scene_for_child(scenario)
        self._held = child.ask(Opened, "open", scene=scene, method=method, timestep=timestep)
        self._state: StateRow | Stepped = self._held.state
        self._left = 0

    def read_body(self) -> BodyReading:
        """The body as the child holds it, in the scene's body axes and from its origin."""
        held, to_body = self._held.body, self._body_from_axes
        axes = (to_body * _rotation(held.frame)).as_matrix()
        # The origin is where the body is held; of a free one, where the scene has it.
        arm = -self._scenario.body.com if held.arm is None else to_body.apply(np.array(held.arm))
        com = to_body.apply(np.array(held.com)) - arm
        return BodyReading(held.mass, com, axes @ np.diag(held.moments) @ axes.T)

    def read_state(self) -> State:
        """The state now."""
        return self.states([self.snapshot()]).rows(0)

    def advance(self, steps: int) -> None:
        """Take steps, in calls of a limited number."""
        self._left += steps

    def timed(self, steps: int) -> tuple[float, float]:
        """CPU and wall time, s, as the child measures it around the steps only."""
        self.snapshot()
        begun = time.perf_counter()
        seconds = self._child.ask(Seconds, "time", steps=steps).seconds
        wall = time.perf_counter() - begun
        if seconds > wall * (1 + CLOCK_SLACK):
            words = f"it says that {steps} steps took {seconds:.3g} s, of {wall:.3g} s that went by"
            raise EngineError(words, "clock")
        return seconds, seconds

    def snapshot(self) -> list[float | None]:
        """The state in the child's frames."""
        while self._left:
            steps = min(MOST_STEPS_A_CALL, self._left)
            self._state = self._child.ask(Stepped, "run", steps=steps)
            self._left -= steps
        state = self._state
        return [*state.q, *state.omega, *state.com, *state.velocity]

    def states(self, snapshots: Sequence[Any]) -> State:
        """The states of n snapshots, in the scene's body axes."""
        q_world_axes, omega_world, com_world, velocity_world = np.split(
            np.array(snapshots, dtype=float), (4, 7, 10), axis=1
        )
        axes_from_body = self._body_from_axes.inv().as_quat(scalar_first=True)
        q_world_body = q_world_axes @ times(axes_from_body)
        omega_body = turned_back(matrices(q_world_body), omega_world)
        return State(q_world_body, omega_body, com_world, velocity_world)

    def check(self) -> None:
        """Nothing to check: a child reports trouble in its answers."""

    def active(self) -> frozenset[str]:
        """The effects that the child reports as acting."""
        return frozenset(self._child.ask(Active, "active").active)

    def close(self) -> None:
        """Close the scene in the child, and keep the child for another."""
        try:
            if self._child.usable:
                self._child.ask(Done, "close")
        finally:
            given_back(self._child)


def scene_for_child(scenario: Scenario) -> dict[str, object]:
    """The scene as the protocol defines it: principal axes about the com, SI units."""
    body, start = scenario.body, scenario.start
    frame = principal_frame(body)
    body_from_axes = _rotation(frame.q_body_axes_wxyz)
    world_from_body = _rotation(start.q_world_body_wxyz)
    to_axes = body_from_axes.inv()
    com, velocity = start.position_world, start.velocity_world
    if scenario.has_pivot:
        com = _turned(world_from_body, body.com)
        velocity = _turned(world_from_body, np.cross(start.omega_body, body.com))
    return {
        "mass": float(body.mass),
        "moments": _numbers(frame.moments),
        "arm": _numbers(_turned(to_axes, -body.com)) if scenario.has_pivot else None,
        "gravity": _numbers(scenario.gravity_world),
        "drag": float(scenario.drag),
        "torque_body": _numbers(_turned(to_axes, scenario.torque_body)),
        "torque_world": _numbers(scenario.torque_world),
        "q": _numbers((world_from_body * body_from_axes).as_quat(scalar_first=True)),
        "omega": _numbers(_turned(world_from_body, start.omega_body)),
        "com": _numbers(com),
        "velocity": _numbers(velocity),
    }


def _rotation(q_wxyz: Sequence[float] | FloatArray) -> Rotation:
    return Rotation.from_quat(q_wxyz, scalar_first=True)


def _turned(rotation: Rotation, vector: FloatArray) -> FloatArray:
    return np.asarray(rotation.apply(np.array(vector)))


def _numbers(vector: FloatArray) -> list[float]:
    return [float(value) for value in vector]
