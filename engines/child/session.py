"""A scene in a child process; states are converted between the scene's axes and the child's."""

import time
from collections.abc import Sequence
from typing import Any, final

import numpy as np
from spincheck.engine import BodyReading, EngineError, Scenario, Session, State, start_state

from ..scene_record import HeldRotor, RecordFrame, WorldBody, scene_record
from .messages import Active, Done, Opened, Seconds, StateRow, Stepped
from .process import ChildProcess, given_back

#: Largest number of steps in a call, so that the answer comes within the time limit.
MOST_STEPS_A_CALL = 1 << 12
#: Relative amount by which the time that a child measures may exceed the time that passes here.
CLOCK_SLACK = 0.01


@final
class ChildSession(Session):
    """A session of one scene in a child process, which no other session uses at the same time.

    The child is given the scene as a scene record.

    Parameters
    ----------
    child : the process, which has described itself
    method : name of the method
    timestep : length of the steps, s

    Raises
    ------
    EngineError
        From any method, if the child answers with an error or breaks the protocol.
    """

    def __init__(
        self, child: ChildProcess, scenario: Scenario, method: str, timestep: float
    ) -> None:
        self._child, self._timestep = child, timestep
        self._frame = RecordFrame.of(scenario)
        self._parts = start_state(scenario).spins.size
        scene = scene_record(scenario)
        self._opened = child.ask(Opened, "open", scene=scene, method=method, timestep=timestep)
        self._state: StateRow | Stepped = self._opened.state
        self._count("body.parts", self._opened.body.parts)
        self._left = 0

    def read_body(self) -> BodyReading:
        """Return the body as the child holds it, in the axes and origin of the scene's body."""
        body = self._opened.body
        parts = [
            HeldRotor(one.mass, np.array(one.com), one.inertia_com, np.array(one.axis))
            for one in body.parts
        ]
        reading = WorldBody(body.mass, body.com, body.inertia_com, body.arm, parts)
        return self._frame.body(reading)

    def _count(self, what: str, values: Sequence[object]) -> None:
        """Raise `EngineError` unless there is a value for each rotor; `what` names the values."""
        if len(values) != self._parts:
            words = f"{what!r} must have one entry a part, {self._parts}, got {len(values)}"
            raise EngineError(words, "protocol")

    def read_state(self) -> State:
        """Return the state after the last step, in the scene's body axes."""
        return self.states([self.snapshot()]).rows(0)

    @property
    def can_restart(self) -> bool:
        """Whether the child says in its description that it can restart."""
        return self._child.hello is not None and self._child.hello.restart

    def restart(self, state: State, timestep: float | None = None) -> None:
        """Set the child's body to a state, and the timestep, s, if given (`Session.restart`)."""
        self._timestep = self._timestep if timestep is None else timestep
        motion, self._left = self._frame.motion(state), 0
        self._state = self._child.ask(StateRow, "restart", **motion, timestep=self._timestep)

    def advance(self, steps: int) -> None:
        """Note that `steps` more steps are due; the next `snapshot` or `timed` takes them."""
        self._left += steps

    def timed(self, steps: int) -> tuple[float, float]:
        """Take steps; return the time that the child measures, s, twice: as CPU and as wall time.

        `EngineError` is raised if this time is longer than the wall time of the call.
        """
        self.snapshot()
        begun = time.perf_counter()
        seconds = self._child.ask(Seconds, "time", steps=steps).seconds
        wall = time.perf_counter() - begun
        if seconds > wall * (1 + CLOCK_SLACK):
            words = f"it says that {steps} steps took {seconds:.3g} s, of {wall:.3g} s that went by"
            raise EngineError(words, "clock")
        return seconds, seconds

    def snapshot(self) -> list[float | None]:
        """Take the steps that are due, and return the state that the child answers.

        The state is one list of the numbers `q`, `omega`, `com`, `velocity` and `spins` of a
        scene record; None stands for a number that is not finite.
        """
        while self._left:
            steps = min(MOST_STEPS_A_CALL, self._left)
            self._state = self._child.ask(Stepped, "run", steps=steps)
            self._left -= steps
        state = self._state
        self._count("spins", state.spins)
        return [*state.q, *state.omega, *state.com, *state.velocity, *state.spins]

    def states(self, snapshots: Sequence[Any]) -> State:
        """Return the states of n snapshots, in the scene's body axes."""
        return self._frame.states(np.array(snapshots, dtype=float))

    def check(self) -> None:
        """Do nothing: a child reports trouble by an answer, and the call that gets it raises."""

    def active(self) -> frozenset[str]:
        """Return the names of what the child reports as acting on the body."""
        return frozenset(self._child.ask(Active, "active").active)

    def close(self) -> None:
        """Close the scene in the child, and keep the child for another scene."""
        try:
            if self._child.usable:
                self._child.ask(Done, "close")
        finally:
            given_back(self._child)
