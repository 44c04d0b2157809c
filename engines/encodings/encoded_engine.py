"""An engine that is given scenes in another encoding; its motions are converted back."""

from collections.abc import Callable, Sequence
from typing import Any, final

import numpy as np

from ...scenarios import FloatArray, Scenario
from ..checks.read_back import BodyReading, Difference, State, body_pairs
from ..engine import Engine
from ..fault import Fault
from ..method import Method
from ..models.description import PLAIN
from ..session import Session
from .changed_scene import SceneChange
from .table import ENCODINGS, Encoding

#: Ulp within which a body reads back as the same one: its tensor is turned three times at most, 10
#: ulp each, and diagonalised by Jacobi's rotations, 25 ulp (Golub & Van Loan, §8.5). Measured in
#: MuJoCo and PyBullet: 16, and 1e5 where PyBullet diagonalises a whole tensor itself.
SAME_BODY = 64


@final
class EncodedEngine(Engine):
    """An engine that opens scenes in one encoding, and otherwise behaves as the engine itself.

    A body that the engine holds differently from the scene's does not fail a run: the difference is
    a finding.
    """

    def __init__(self, base: Engine, encoding: str) -> None:
        self.name, self.base, self._encoding = base.name, base, encoding
        self.varied = {"as": encoding}
        self.methods = base.methods
        self.single_precision = base.single_precision

    @property
    def encoding(self) -> Encoding:
        """The encoding, found by name: an `Encoding` has functions, which workers are not sent."""
        return ENCODINGS[self._encoding]

    @property
    def site(self) -> str:
        """The engine's own `site`."""
        return self.base.site

    @property
    def version(self) -> str:
        """The engine's own version."""
        return self.base.version

    def open(self, scenario: Scenario, method: Method, timestep: float) -> Session:
        """Open the changed scene in the engine, with its body described as the encoding says."""
        change, description = self.encoding.change(scenario), self.encoding.description
        changed, timestep = self.encoding.scene(scenario), timestep * change.time
        if description == PLAIN:
            session = self.base.open(changed, method, timestep)
        else:
            session = self.base.open_with(changed, method, timestep, description=description)
        return EncodedSession(session, scenario, change, timestep)

    def differences(
        self,
        scenario: Scenario,
        method: str,  # noqa: ARG002
        body: BodyReading,
        state: State,  # noqa: ARG002
    ) -> list[Difference]:
        """Return the differences of the body; a wrong start shows in the motion."""
        own, change = scenario.body, self.encoding.change(scenario)
        shift = np.array(change.shift, dtype=float)
        # The tensor about a point far away is larger, and with it its rounding.
        far = float(shift @ shift + own.com @ own.com)
        moment = float(own.principal_moments[-1]) + own.mass * far
        # In maximal coordinates PyBullet's places of links are relative to the world's origin.
        reach = np.sqrt(moment / own.mass) + abs(change.place) / change.length
        sizes = {"mass": own.mass, "com": reach}
        return [
            _Off(what, wanted, got, largest / size)
            for what, got, wanted in body_pairs(scenario, body)
            for size in [sizes.get(what, moment)]
            if not (largest := float(np.abs(got - wanted).max())) <= SAME_BODY * self.ulp * size
        ]


class _Off(Difference):
    """A number of the body whose value in the engine differs from the scene's."""

    @property
    def remark(self) -> str:
        """The size of the difference, in words."""
        return f"'{self.what}' is off by {self.relative:.1e}"


@final
class EncodedSession(Session):
    """A session of the changed scene, read in the axes and units of the original scene."""

    def __init__(
        self, session: Session, scenario: Scenario, change: SceneChange, timestep: float
    ) -> None:
        self._session, self._scenario, self._change = session, scenario, change
        self._timestep, self._steps = timestep, 0

    def read_body(self) -> BodyReading:
        """Return the engine's body in the axes and units of the original scene."""
        return self._change.body_back(self._session.read_body())

    def read_state(self) -> State:
        """The state after the last step."""
        return self.states([self.snapshot()]).rows(0)

    def advance(self, steps: int) -> None:
        """Take whole steps."""
        self._session.advance(steps)
        self._steps += steps

    def record(self, strides: Sequence[int], keep: Callable[[Any], object]) -> None:
        """Take steps and keep snapshots, each with the number of steps taken before it."""
        counts = iter(self._steps + np.cumsum(strides))

        def kept(snapshot: Any) -> None:
            self._steps = int(next(counts))
            keep((self._steps, snapshot))

        self._session.record(strides, kept)

    def snapshot(self) -> tuple[int, Any]:
        """Return the number of steps so far, and the engine's own snapshot."""
        return self._steps, self._session.snapshot()

    def states(self, snapshots: Sequence[tuple[int, Any]]) -> State:
        """The states of n snapshots."""
        states = self._session.states([own for _, own in snapshots])
        return self._change.state_back(states, self._times(snapshots))

    def _times(self, snapshots: Sequence[tuple[int, Any]]) -> FloatArray:
        return np.array([steps for steps, _ in snapshots]) * self._timestep

    def first_fault(
        self,
        snapshots: Sequence[tuple[int, Any]],
        states: State,  # noqa: ARG002
    ) -> Fault | None:
        """Return the first fault that the engine finds in its own snapshots."""
        own = [snapshot for _, snapshot in snapshots]
        return self._session.first_fault(own, self._session.states(own))

    def check(self) -> None:
        """Raise `EngineError` if the engine reports trouble."""
        self._session.check()

    def active(self) -> frozenset[str]:
        """Return the effects that the scene calls for, unchecked.

        They are audited in runs of the unchanged scene.
        """
        return self._scenario.called_for

    def close(self) -> None:
        """Free the engine's memory."""
        self._session.close()
