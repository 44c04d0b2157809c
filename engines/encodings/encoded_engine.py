"""An engine that simulates scenes in another encoding, and whose motions are converted back."""

import inspect
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, final

import numpy as np

from ...scenarios import Scenario
from ..checks.read_back import BodyReading, Difference, State, body_pairs
from ..engine import Engine
from ..fault import Fault
from ..method import Method
from ..models.description import PLAIN
from ..session import Session
from .changed_scene import SceneChange
from .table import ENCODINGS, Encoding

#: Largest difference, in ulp, between a scene's body and the same body read back in an encoding.
#: The tensor is turned at most three times, with errors of 10 ulp each, and diagonalised by
#: Jacobi's rotations, 25 ulp (Golub & Van Loan, §8.5). In MuJoCo and PyBullet 16 ulp were measured,
#: but 1e5 where PyBullet diagonalises a full tensor itself.
SAME_BODY = 64


@final
class EncodedEngine(Engine):
    """An engine that is given every scene in one encoding, and is judged like any other engine.

    Its name is, for example, "mujoco as welded". It has all methods of the wrapped engine but those
    as shipped.

    Parameters
    ----------
    base : the engine that is given the scenes
    encoding : name of the encoding, a key of `ENCODINGS`
    """

    def __init__(self, base: Engine, encoding: str) -> None:
        self.name, self.base, self._encoding = f"{base.name} as {encoding}", base, encoding
        self.methods = tuple(
            replace(method, reader=True, setup="")
            for method in base.methods
            if not method.as_shipped
        )
        self.single_precision, self.least_turn = base.single_precision, base.least_turn
        self.stock_timestep = base.stock_timestep

    @property
    def encoding(self) -> Encoding:
        """The encoding, looked up by name: only the name can be pickled and sent to workers."""
        return ENCODINGS[self._encoding]

    @property
    def site(self) -> str:
        """The folder that holds the modules of the engine that is wrapped."""
        return self.base.site

    @property
    def version(self) -> str:
        """The version of the engine that is wrapped."""
        return self.base.version

    @property
    def sources(self) -> tuple[Path, ...]:
        """The files of the wrapped engine's adapter, and those that are its own `sources`."""
        folder = Path(inspect.getfile(type(self.base))).parent
        return (*sorted(folder.glob("*.py")), *self.base.sources)

    @property
    def arguments(self) -> tuple[str, ...]:
        """The wrapped engine's `arguments`."""
        return self.base.arguments

    def applies_to(self, scenario: Scenario) -> bool:
        """Whether the engine can be given the scene in this encoding."""
        return self.base.applies_to(scenario) and not self.why_not(scenario)

    def why_not(self, scenario: Scenario) -> str:
        """Return why a scene cannot be given in this encoding; empty if it can."""
        return self.encoding.why_not(self.base, scenario)

    def open(self, scenario: Scenario, method: Method, timestep: float) -> Session:
        """Open a scene in the engine, changed and with its body described as the encoding says.

        Parameters
        ----------
        scenario : the original scene
        timestep : in the original scene's time, s
        """
        change, description = self.encoding.change(scenario), self.encoding.description
        changed, timestep = self.encoding.scene(scenario), timestep * change.time
        if description == PLAIN:
            session = self.base.open(changed, method, timestep)
        else:
            session = self.base.open_with(changed, method, timestep, description=description)
        return EncodedSession(session, scenario, change)

    def differences(
        self,
        scenario: Scenario,
        method: str,  # noqa: ARG002
        body: BodyReading,
        state: State,  # noqa: ARG002
    ) -> list[Difference]:
        """Return the quantities of the engine's body that are off by more than `SAME_BODY` ulp.

        They are compared with those of the scene's body, in the axes and units of the scene.
        The start is not compared: if it is wrong, the motion is wrong too.
        """
        own, change = scenario.body, self.encoding.change(scenario)
        shift = np.array(change.shift, dtype=float)
        # The tensor about a distant origin is larger, and so are its rounding errors.
        far = float(shift @ shift + own.com @ own.com)
        moment = float(own.principal_moments[-1]) + own.mass * far
        sizes = {"mass": own.mass, "com": float(np.sqrt(moment / own.mass))}
        return [
            Difference(what, wanted, got, largest / size)
            for what, got, wanted in body_pairs(scenario, body)
            for size in [sizes.get(what, moment)]
            if not (largest := float(np.abs(got - wanted).max())) <= SAME_BODY * self.ulp * size
        ]


@final
class EncodedSession(Session):
    """A session of a changed scene whose states are those of the original scene.

    Parameters
    ----------
    session : the engine's session of the changed scene
    scenario : the original scene
    change : how the scene was changed
    """

    def __init__(self, session: Session, scenario: Scenario, change: SceneChange) -> None:
        self._session, self._scenario, self._change = session, scenario, change

    def read_body(self) -> BodyReading:
        """Return the engine's body in the axes and units of the original scene."""
        return self._change.body_back(self._session.read_body())

    def read_state(self) -> State:
        """Return the state after the last step, as one of the original scene."""
        return self.states([self.snapshot()]).rows(0)

    @property
    def can_restart(self) -> bool:
        """Whether the engine's own session can be restarted."""
        return self._session.can_restart

    @property
    def restarts_to_the_last_bit(self) -> bool:
        """False: a restart converts states in double precision, `open` in extended precision."""
        return False

    def restart(self, state: State, timestep: float | None = None) -> None:
        """Set the body to a state, and set the timestep.

        Parameters
        ----------
        state : a state of the original scene
        timestep : in the original scene's time, s; None leaves it as it is
        """
        timestep = None if timestep is None else timestep * self._change.time
        self._session.restart(self._change.state(state), timestep)

    def advance(self, steps: int) -> None:
        """Take `steps` steps."""
        self._session.advance(steps)

    def record(self, strides: Sequence[int], keep: Callable[[Any], object]) -> None:
        """Take steps in strides, and keep a snapshot of the engine's own session after each stride.

        Parameters
        ----------
        strides : number of steps of each stride
        keep : called with each snapshot
        """
        self._session.record(strides, keep)

    def snapshot(self) -> Any:
        """Return a snapshot of the engine's own session, which is of the changed scene."""
        return self._session.snapshot()

    def states(self, snapshots: Sequence[Any]) -> State:
        """Return the states of n snapshots, in the axes and units of the original scene."""
        return self._change.state_back(self._session.states(snapshots))

    def first_fault(
        self,
        snapshots: Sequence[Any],
        states: State,  # noqa: ARG002
    ) -> Fault | None:
        """Return the first fault that the engine's own session finds; None if it finds none.

        The snapshots are its own; `states`, which are of the original scene, is ignored.
        """
        return self._session.first_fault(snapshots, self._session.states(snapshots))

    def check(self) -> None:
        """Raise `EngineError` if the engine reports trouble."""
        self._session.check()

    def active(self) -> frozenset[str]:
        """Return the effects that the scene calls for, without an audit.

        Effects are audited in runs of the unchanged scene.
        """
        return self._scenario.called_for

    def close(self) -> None:
        """Free the engine's memory."""
        self._session.close()
